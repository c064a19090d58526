"""Rows on plates whose roadside is known: they follow it, and lie on free ground where there is some."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np
import pytest
import shapely

from pavemark.ground import Frame
from pavemark.plate import Roadside
from pavemark.randomize.domains import Domains
from pavemark.randomize.scene import randomize
from scenes import plate

FULL = plate(car=(1.86, 3.42))
SHOWN = attrs.evolve(Domains(), layout=attrs.evolve(Domains().layout, empty_rate=0.0))


def roadside(degrees, left=None, right=None):
    return Roadside(math.radians(degrees), left, right, 0.8)


def on_line(share, **values):
    return attrs.evolve(SHOWN, layout=attrs.evolve(SHOWN.layout, on_line=share, **values))


def quarter(degrees):
    return (degrees + 45) % 90 - 45


def headings(scene):
    """Degrees of the entrance line of each slot."""
    return [math.degrees(math.atan2(b[1] - a[1], b[0] - a[0])) for a, b in (slot.corners[:2] for slot in scene.slots)]


@pytest.mark.parametrize("degrees", [90.0, 97.0, 76.0, 130.0])
@pytest.mark.parametrize("half", [False, True])
def test_rows_follow_the_roadside(degrees, half):
    on = attrs.evolve(FULL, roadside=roadside(degrees))
    if half:
        ground = np.ones((300, 96), bool)
        ground[110:230, -11:] = False
        on = attrs.evolve(plate(Frame(96, 300, 1 / 0.044)), ground=ground, roadside=roadside(degrees))
    found = np.array([turn for index in range(60) for turn in headings(randomize(on, index, 5, SHOWN))])
    assert len(found) > 150
    # A degree of scatter, and one more of an opposite row.
    assert np.abs(quarter(found - degrees)).max() < 2.01
    assert np.abs(quarter(found - degrees)).max() > 0.5


def test_rows_that_are_turned_leave_the_roadside_by_as_much_as_is_asked_for():
    on = attrs.evolve(FULL, roadside=roadside(97.0))
    turned = attrs.evolve(SHOWN, layout=attrs.evolve(SHOWN.layout, turned=0.5, turn=(20.0, 30.0)))
    scenes = [randomize(on, index, 5, turned) for index in range(80)]
    off = np.array([np.median(quarter(np.array(headings(scene)) - 97.0)) for scene in scenes if scene.slots])
    away = np.abs(off) > 5
    assert 0.3 < away.mean() < 0.7
    assert off[away].min() > 20 - 2.01 and off[away].max() < 30 + 2.01
    assert np.abs(off[~away]).max() < 2.01
    # Who is not turned lies where it lay before.
    before = [randomize(on, index, 5, SHOWN) for index in range(80)]
    same = [one.slots == other.slots for one, other in zip(scenes, before, strict=True) if one.slots]
    assert np.array_equal(np.array(same), ~away)


def test_gaps_between_slots_come_at_the_rate_and_size_asked_for():
    def gaps(**ranges):
        domains = attrs.evolve(SHOWN, layout=attrs.evolve(SHOWN.layout, both_sides=0.0, run_on=1.0, **ranges))
        found = []
        for index in range(60):
            slots = randomize(plate(), index, 5, domains).slots
            found += [math.dist(one.corners[1], other.corners[0]) for one, other in itertools.pairwise(slots)]
        return np.array(found)

    assert gaps(gap_rate=0.0).max() < 1e-6
    half = gaps(gap_rate=0.5, gap=(0.5, 0.5))
    assert 0.4 < (half > 1e-6).mean() < 0.6
    # The fitted ones are 1 to 2.4 m wide.
    assert half[half > 1e-6].min() > 0.5 and half.max() < 1.2


def test_rows_begin_on_the_roadside_s_line():
    on = attrs.evolve(FULL, roadside=roadside(95.0, left=2.6, right=-2.1))
    domains = on_line(1.0, offset=(-0.1, 0.1), both_sides=0.0)
    normal = np.array([-math.sin(math.radians(95)), math.cos(math.radians(95))])
    offsets = []
    for index in range(80):
        for slot in randomize(on, index, 2, domains).slots[:1]:
            p1, p2 = np.array(slot.corners[:2])
            if abs((p2 - p1) @ normal) < 0.2:  # beside the car, not across its way
                offsets.append(float((p1 + p2) @ normal / 2))
    offsets = np.array(offsets)
    assert (offsets > 0).sum() > 20 and (offsets < 0).sum() > 10
    wanted = np.where(offsets > 0, 2.6, -2.1)
    # The drawn offset, and a degree of turn at a slot that begins 10 m up or down.
    assert np.abs(offsets - wanted).max() < 0.1 + 0.175
    elsewhere = randomize(on, 1, 2, on_line(0.0)), randomize(on, 1, 2, on_line(1.0))
    assert elsewhere[0].slots != elsewhere[1].slots


def crowded():
    """Room for slots of 5 m on the left, if they begin 1.9 to 2.4 m from the middle, between a fence and a planter."""
    frame = Frame(1000, 600, 60.0)
    on = plate(frame, car=(1.86, 3.42))
    x, y = np.moveaxis(frame.pixel_centres(), -1, 0)
    ground = on.ground & ~((x > 1.5) | (x < -7.8) | ((x > -1.7) & (x < -1.4)) | ((y > 2.0) & (x < -1.4)))
    return attrs.evolve(on, ground=ground)


def taken(on, scenes):
    """Of each scene with slots, the share of not-ground on the floor of its emptiest slot, as far as it is seen."""
    centres = on.frame.pixel_centres()
    for scene in scenes:
        shares = []
        for slot in scene.slots:
            floor = shapely.contains_xy(shapely.Polygon(slot.corners), *np.moveaxis(centres, -1, 0))
            shares.append((floor & ~on.ground).sum() / max(1, floor.sum()) if floor.any() else 1.0)
        if shares:
            yield min(shares)


def test_free_ground_is_looked_for_before_slots_with_something_in_them():
    on = crowded()
    domains = attrs.evolve(
        on_line(0.0, both_sides=0.0), shape=attrs.evolve(SHOWN.shape, parallel=0.0, slanted=0.0, depth=(1.0, 1.0))
    )
    plain = np.array(list(taken(on, (randomize(on, index, 3, domains) for index in range(40)))))
    found = attrs.evolve(on, roadside=roadside(90.0))
    better = np.array(list(taken(found, (randomize(found, index, 3, domains) for index in range(40)))))
    assert np.mean(plain > 0.1) > 0.2
    assert np.mean(better > 0.1) < 0.1
    assert len(better) >= len(plain)


def test_slots_that_are_taken_are_better_than_none():
    """Parked cars all along: no floor is free, the marking points are."""
    x, _ = np.moveaxis(FULL.frame.pixel_centres(), -1, 0)
    on = attrs.evolve(FULL, ground=FULL.ground & (np.abs(x) < 2.4), roadside=roadside(90.0))
    assert sum(bool(randomize(on, index, 3, SHOWN).slots) for index in range(30)) > 10


def test_no_row_begins_along_a_kerb():
    """Lawn beyond 2.5 m on both sides, and the roadside's line is its kerb."""
    x, _ = np.moveaxis(FULL.frame.pixel_centres(), -1, 0)
    on = attrs.evolve(FULL, ground=FULL.ground & (np.abs(x) < 2.5), roadside=roadside(90.0, 2.5, -2.5))
    seen = 0
    for index in range(60):
        for slot in randomize(on, index, 3, on_line(1.0, offset=(-0.3, 0.3))).slots:
            p1, p2, p3, p4 = np.array(slot.corners)
            for point, inwards in ((p1, p4 - p1), (p2, p3 - p2)):
                uv = on.frame.to_image(point + 1.0 * inwards / np.linalg.norm(inwards))
                if on.frame.contains(uv) and on.frame.contains(on.frame.to_image(point)):
                    assert on.ground[int(uv[1]), int(uv[0])]
                    seen += 1
    assert seen > 20


def test_opposite_rows_leave_an_aisle_wherever_they_are_moved():
    on = attrs.evolve(FULL, roadside=roadside(92.0, left=1.0, right=-0.9))
    pairs = 0
    for index in range(60):
        scene = randomize(on, index, 6, on_line(0.5, both_sides=1.0))
        rows = [np.array([slot.corners[:2] for slot in scene.slots]).reshape(-1, 2)]
        facing = np.round(np.array(headings(scene)) - 92.0, -1) % 360
        if len(set(facing)) == 2:
            first, second = (rows[0].reshape(-1, 2, 2)[facing == side].mean((0, 1)) for side in sorted(set(facing)))
            pairs += 1
            assert math.dist(first, second) > 2.4
    assert pairs > 15


@pytest.mark.parametrize("part", ["curvature", "noise", "brightness", "optics", "tyres"])
def test_the_roadside_moves_no_other_domain(part):
    on = attrs.evolve(FULL, roadside=roadside(94.0, 2.5, -2.5))
    pairs = [
        (randomize(FULL, k, 11, SHOWN, blur=((1.0,),)), randomize(on, k, 11, SHOWN, blur=((1.0,),))) for k in range(12)
    ]
    assert sum(a.slots != b.slots for a, b in pairs) > 8
    for a, b in pairs:
        if part == "tyres":
            assert (a.tyres is None) == (b.tyres is None)
        else:
            assert getattr(a, part) == getattr(b, part)
        paints = [{m.paint for m in scene.markings if m.kind == "slot"} for scene in (a, b)]
        assert paints[0] <= paints[1] or paints[1] <= paints[0]


def test_the_same_roadside_gives_the_same_scene():
    on = attrs.evolve(FULL, roadside=roadside(94.0, 2.5, -2.5))
    assert [randomize(on, k, 1, SHOWN) for k in range(5)] == [randomize(on, k, 1, SHOWN) for k in reversed(range(5))][
        ::-1
    ]
