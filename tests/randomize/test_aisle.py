"""What is painted along a row lies where it says, beside the slots and never under a label."""

import itertools
import math

import attrs
import numpy as np
import pytest
from shapely import LineString, Polygon, unary_union

from pavemark.labels.truth import truth
from pavemark.randomize import aisle
from pavemark.randomize.domains import Domains
from pavemark.randomize.fitted import fitted
from pavemark.randomize.row import Row, slots
from pavemark.randomize.scene import randomize
from pavemark.randomize.shape import Ranges, sample
from pavemark.scene import Paint
from scenes import plate

WHITE = Paint((255.0, 255.0, 255.0), (3.0, 3.0, 3.0))
PLATE = plate(car=(1.86, 3.42))
ALL = aisle.Ranges(rate=1.0, line=1.0, second=1.0, band=1.0, zebra=1.0, hatch=1.0, crossed=0.0, lane=0.0, floor=1.0)


def row(heading: float = 0.7, angle: float = 70.0) -> Row:
    shape = attrs.evolve(sample(np.random.default_rng(0), Ranges(), fitted()), angle=math.radians(angle), depth=5.0)
    return Row(shape, (1.0, -2.0), heading, ((-3.0, -0.5, 2.0), (3.0, 5.5)))


def drawn(number: int, ranges: aisle.Ranges = ALL) -> aisle.Aisle:
    return aisle.sample(np.random.default_rng(number), ranges)


def shapes(marking, width=True):
    strokes = [
        LineString([*stroke.path, *stroke.path[:1]] if stroke.closed else stroke.path).buffer(
            stroke.width / 2 if width else 1e-9, cap_style="flat"
        )
        for stroke in marking.strokes
    ]
    return unary_union([*strokes, *(Polygon(area.ring) for area in marking.areas)])


@pytest.mark.parametrize("number", range(12))
def test_lines_lie_in_the_aisle_and_not_on_the_slots(number):
    of, lying = row(), drawn(number)
    floor = unary_union([Polygon(slot.corners) for slot in slots(of)])
    painted = shapes(aisle.marking(lying, of, WHITE), width=False)
    assert painted.area > 0
    assert floor.intersection(painted).area < 1e-6
    # As seen from the entrance line all of it is on the side away from the slots, no nearer than the first line.
    away = -(np.array(painted.convex_hull.exterior.coords) - of.origin) @ of.normal
    nearest = min(*lying.lines, lying.zebra.near, lying.hatch.near)
    assert away.min() == pytest.approx(nearest, abs=1e-6)


def test_lines_run_along_the_row_at_their_distance():
    of, lying = row(), drawn(3)
    first, second = aisle.marking(attrs.evolve(lying, zebra=None, hatch=None), of, WHITE).strokes
    for stroke, away in ((first, lying.lines[0]), (second, lying.lines[1])):
        ends = np.array(stroke.path) - of.origin
        np.testing.assert_allclose(-ends @ of.normal, away, atol=1e-9)
        np.testing.assert_allclose(ends @ of.along, [-3.0 - lying.run_on[0], 5.5 + lying.run_on[1]], atol=1e-9)


def test_a_band_lies_between_the_lines_and_a_floor_in_the_slots():
    of, lying = row(), drawn(5)
    floor, band = aisle.floors(lying, of)
    assert {floor.kind, band.kind} == {"floor"}
    assert shapes(floor).area == pytest.approx(sum(Polygon(slot.corners).area for slot in slots(of)))
    assert shapes(floor).symmetric_difference(unary_union([Polygon(s.corners) for s in slots(of)])).area < 1e-6
    length = 8.5 + sum(lying.run_on)
    assert shapes(band).area == pytest.approx(length * (lying.lines[1] - lying.lines[0]))
    assert shapes(band).intersection(shapes(floor)).area < 1e-6
    assert floor.paint.ratio == aisle.FLOORS[lying.floor] and band.paint.opacity == lying.opacity


@pytest.mark.parametrize("number", range(12))
def test_hatching_stays_in_its_box_and_crosses_it(number):
    of, lying = row(heading=-2.0), drawn(number)
    only = attrs.evolve(lying, lines=(), zebra=None)
    outline, *lines = aisle.marking(only, of, WHITE).strokes
    box = Polygon(outline.path)
    assert box.area == pytest.approx(lying.hatch.length * (lying.hatch.far - lying.hatch.near))
    assert len(lines) >= 2
    slants = []
    for line in lines:
        assert box.buffer(1e-6).contains(LineString(line.path))
        # Both ends lie on the box's outline: no line hangs in it.
        assert max(box.exterior.distance(LineString(line.path).boundary), 0) < 1e-6
        run = np.array(line.path[1]) - line.path[0]
        slants.append(math.atan2(-run @ of.normal, run @ of.along) % math.pi)
    np.testing.assert_allclose(slants, lying.slant % math.pi, atol=1e-9)


def test_a_box_that_is_crossed_is_hatched_both_ways():
    of, lying = row(), attrs.evolve(drawn(4), lines=(), zebra=None)
    outline, *once = aisle.marking(lying, of, WHITE).strokes
    _, *both = aisle.marking(attrs.evolve(lying, crossed=True), of, WHITE).strokes
    assert both[: len(once)] == once
    for line in both[len(once) :]:
        run = np.array(line.path[1]) - line.path[0]
        assert math.atan2(-run @ of.normal, run @ of.along) % math.pi == pytest.approx(-lying.slant % math.pi)
        assert Polygon(outline.path).buffer(1e-6).contains(LineString(line.path))


@pytest.mark.parametrize("number", range(6))
def test_a_lane_is_dashes_of_one_length_in_the_aisle(number):
    of = row()
    lying = attrs.evolve(drawn(number, attrs.evolve(ALL, lane=1.0)), lines=(), zebra=None, hatch=None)
    dashes = aisle.marking(lying, of, WHITE).strokes
    ends = np.array([dash.path for dash in dashes]) - of.origin
    np.testing.assert_allclose(-ends @ of.normal, lying.lane.away, atol=1e-9)
    along = ends @ of.along
    assert along.min() >= -3.0 - lying.run_on[0] - 1e-9 and along.max() <= 5.5 + lying.run_on[1] + 1e-9
    np.testing.assert_allclose((along[1:, 0] - along[:-1, 1]), lying.lane.between, atol=1e-9)
    np.testing.assert_allclose(np.diff(along[1:-1]), lying.lane.dash, atol=1e-9)


def test_a_crossing_has_stripes_as_wide_as_the_ground_between_them():
    of, lying = row(), drawn(4)
    only = attrs.evolve(lying, lines=(), hatch=None)
    stripes = [Polygon(area.ring) for area in aisle.marking(only, of, WHITE).areas]
    assert len(stripes) >= 2
    for one, other in itertools.pairwise(stripes):
        assert one.area == pytest.approx(lying.stripe * (lying.zebra.far - lying.zebra.near))
        assert one.distance(other) == pytest.approx(lying.stripe)


@pytest.mark.parametrize("number", range(12))
def test_each_of_two_rows_has_its_half_of_the_aisle(number):
    """The narrowest aisle that is drawn: whole crossings would reach into the slots across it."""
    of, wide = row(), drawn(number)
    across = attrs.evolve(of, origin=tuple(np.asarray(of.origin) - 2.5 * of.normal), heading=of.heading + math.pi)
    halves = [aisle.beside(wide, one, [other]) for one, other in ((of, across), (across, of))]
    for lying, one, other in ((halves[0], of, across), (halves[1], across, of)):
        mine = [aisle.marking(lying, one, WHITE), *aisle.floors(lying, one)[1:]]
        for each in filter(None, mine):
            away = -(np.array(shapes(each).convex_hull.exterior.coords) - one.origin) @ one.normal
            assert away.max() <= 1.25 + 1e-6
            assert shapes(each).intersection(unary_union([Polygon(slot.corners) for slot in slots(other)])).area < 1e-6
        assert not (lying.band and len(lying.lines) < 2)


def test_with_room_nothing_is_left_out():
    of, lying = row(), drawn(3)
    lying = attrs.evolve(lying, hatch=None)
    far = attrs.evolve(of, origin=tuple(np.asarray(of.origin) - 20.0 * of.normal), heading=of.heading + math.pi)
    assert aisle.beside(lying, of, []) == aisle.beside(lying, of, [far]) == lying


def test_a_hatched_box_is_not_painted_on_a_crossing():
    of, lying = row(), drawn(4)
    apart = attrs.evolve(lying.zebra, start=0.0, length=1.5), attrs.evolve(lying.hatch, start=1.0, length=1.5)
    assert aisle.beside(attrs.evolve(lying, zebra=apart[0], hatch=apart[1]), of, []).hatch == apart[1]
    assert aisle.beside(attrs.evolve(lying, zebra=apart[0], hatch=apart[0]), of, []).hatch is None


def test_nothing_is_painted_where_nothing_is_drawn():
    assert aisle.sample(np.random.default_rng(0), aisle.Ranges()) is None
    bare = drawn(1, aisle.Ranges(rate=1.0, line=0.0, zebra=0.0, hatch=0.0, lane=0.0, floor=0.0))
    assert aisle.marking(bare, row(), WHITE) is None and aisle.floors(bare, row()) == ()
    # A band needs two lines to lie between.
    assert drawn(1, attrs.evolve(ALL, second=0.0, floor=0.0)).band == ""


def test_rates_are_met():
    ranges = aisle.Ranges(rate=0.5, crossed=0.3, lane=0.2)
    found = [drawn(number, ranges) for number in range(600)]
    some = [each for each in found if each is not None]
    assert 260 < len(some) < 340
    for name, rate in (("zebra", 0.25), ("hatch", 0.25), ("crossed", 0.3), ("lane", 0.2), ("floor", 0.2)):
        assert rate * 0.7 < sum(bool(getattr(each, name)) for each in some) / len(some) < rate * 1.35
    assert {each.floor for each in some} == {"", *aisle.FLOORS}


def test_labels_are_those_of_the_same_scene_without_it():
    domains = Domains()
    domains = attrs.evolve(domains, layout=attrs.evolve(domains.layout, empty_rate=0.0))
    for index in range(6):
        with_it = randomize(PLATE, index, 3, attrs.evolve(domains, aisle=ALL))
        without = randomize(PLATE, index, 3, domains)
        assert {marking.kind for marking in with_it.markings} >= {"slot", "aisle", "floor"}
        kinds = [marking.kind for marking in with_it.markings]
        assert max(k for k, kind in enumerate(kinds) if kind == "floor") < kinds.index("aisle") < kinds.index("slot")
        one, other = truth(with_it, PLATE.ground), truth(without, PLATE.ground)
        assert one.marks == other.marks
        assert [slot.corners for slot in one.slots] == [slot.corners for slot in other.slots]
