"""What wheels roll against lies square in its slot, at its far end, and is no label."""

import math

import attrs
import numpy as np
import pytest
from shapely import Polygon, unary_union

from pavemark.labels.truth import truth
from pavemark.randomize import stops
from pavemark.randomize.domains import Domains
from pavemark.randomize.fitted import fitted
from pavemark.randomize.row import Row, slots
from pavemark.randomize.scene import randomize
from pavemark.randomize.shape import Ranges, sample
from scenes import plate

PLATE = plate(car=(1.86, 3.42))


def row(angle: float = 90.0, kind: str = "perpendicular") -> Row:
    shape = sample(np.random.default_rng(0), Ranges(), fitted())
    shape = attrs.evolve(shape, angle=math.radians(angle), depth=5.0, kind=kind)
    return Row(shape, (1.0, -2.0), 0.7, ((-3.0, -0.5, 2.0), (3.0, 5.5)))


def drawn(number: int, **ranges) -> stops.Stops:
    return stops.sample(np.random.default_rng(number), stops.Ranges(rate=1.0, **ranges))


def boxes(marking) -> list[Polygon]:
    return [Polygon(area.ring) for area in marking.areas]


@pytest.mark.parametrize("angle", [90.0, 60.0, 120.0])
@pytest.mark.parametrize("number", range(8))
def test_each_slot_has_its_own_at_its_far_end(number, angle):
    of, lying = row(angle), drawn(number)
    found = boxes(stops.markings(lying, of)[0])
    each = slots(of)
    assert len(found) == len(lying.centres) * len(each)
    for slot in each:
        mine = [box for box in found if Polygon(slot.corners).contains(box)]
        assert len(mine) == len(lying.centres)
        entrance = (np.array(slot.corners[0]) + slot.corners[1]) / 2
        for box in mine:
            assert box.area == pytest.approx(lying.length * lying.deep)
            assert (box.centroid.coords[0] - entrance) @ of.inwards == pytest.approx(5.0 - lying.back)


def test_it_lies_square_to_its_slot():
    of, lying = row(60.0), drawn(1)
    for box in boxes(stops.markings(lying, of)[0]):
        corners = np.array(box.exterior.coords)
        sides = np.diff(corners, axis=0)
        np.testing.assert_allclose(np.abs(sides[0] @ of.inwards), 0.0, atol=1e-9)
        np.testing.assert_allclose(np.abs(sides[1] @ of.inwards), lying.deep, atol=1e-9)


def test_stripes_lie_on_it_and_cover_half():
    of, lying = row(), drawn(2, striped=1.0, bar=1.0)
    bars, stripes = stops.markings(lying, of)
    below, above = unary_union(boxes(bars)), unary_union(boxes(stripes))
    assert below.buffer(1e-9).contains(above)
    assert 0.3 < above.area / below.area < 0.7
    assert stripes.paint.ratio != bars.paint.ratio


def test_rates_are_met():
    found = [stops.sample(np.random.default_rng(number), stops.Ranges(rate=0.5)) for number in range(600)]
    some = [each for each in found if each is not None]
    assert 260 < len(some) < 340
    assert 0.25 < np.mean([len(each.centres) == 1 for each in some]) < 0.45
    assert 0.3 < np.mean([each.stripes is not None for each in some]) < 0.5
    assert stops.sample(np.random.default_rng(0), stops.Ranges()) is None
    assert stops.markings(some[0], row(kind="parallel")) == ()


def test_labels_are_those_of_the_same_scene_without_it():
    domains = Domains()
    domains = attrs.evolve(domains, layout=attrs.evolve(domains.layout, empty_rate=0.0))
    domains = attrs.evolve(domains, shape=attrs.evolve(domains.shape, parallel=0.0))
    for index in range(6):
        with_it = randomize(PLATE, index, 3, attrs.evolve(domains, stops=stops.Ranges(rate=1.0)))
        without = randomize(PLATE, index, 3, domains)
        kinds = [marking.kind for marking in with_it.markings]
        assert kinds[-1] == "stop"  # they lie on the lines
        assert attrs.evolve(with_it, markings=tuple(m for m in with_it.markings if m.kind != "stop")) == without
        one, other = truth(with_it, PLATE.ground), truth(without, PLATE.ground)
        assert one.marks == other.marks
        assert [(kind, area.wkb) for kind, area in one.markings] == [(kind, area.wkb) for kind, area in other.markings]
