"""DMPR files, read back as DMPR-PS reads them, and paired by its rule, written down here a second time."""

import json
import math

import numpy as np
import pytest

from pavemark.labels import dmpr
from pavemark.labels.truth import truth
from pavemark.scene import Curvature
from scenes import CAR, plate, row, together

EVERYWHERE = np.ones((600, 600), bool)
BENT = Curvature(150.0, 0.4, 21)


def read(scene, ground=EVERYWHERE):
    """Points (x, y, direction, shape) normalised as DMPR-PS does it, and slots numbered from 0."""
    label = json.loads(dmpr.encode(truth(scene, ground)))
    marks = [
        ((x - 0.5) / 600, (y - 0.5) / 600, math.atan2(to_y - y, to_x - x), shape)
        for x, y, to_x, to_y, shape in label["marks"]
    ]
    return marks, [(i - 1, j - 1) for i, j, _, _ in label["slots"]]


def off(a, b):
    """Angle between two directions, radians."""
    return abs((a - b + math.pi) % (2 * math.pi) - math.pi)


def side(mark, other):
    """Which slots a point allows beside its line to the other: +1 left of it as seen, -1 right, 0 both, None none.

    A T whose stem lies along the line, or to one side; an L that stands left of it or, by its second arm, right.
    The tolerances are those of the published configuration.
    """
    bridge, separator = 0.0976 + 0.1384, 0.285 + 0.1384
    along = math.atan2(other[1] - mark[1], other[0] - mark[0])
    left, right = along - math.pi / 2, along + math.pi / 2
    direction, shape = mark[2:]
    if shape == 0:
        if off(direction, along) < bridge:
            return 0
        if off(direction, right) < separator:
            return -1
    elif off(direction, along) < bridge:
        return -1
    return 1 if off(direction, left) < separator else None


def between(a, c, b):
    """Whether the way from a to b leads by c: the turn there has a cosine of more than 0.8."""
    there, on = np.subtract(c[:2], a[:2]), np.subtract(b[:2], c[:2])
    return there @ on > 0.8 * math.hypot(*there) * math.hypot(*on)


def paired(marks):
    """All pairs (p1, p2) that the published rule finds."""
    found = set()
    for i, a in enumerate(marks):
        for j in range(i + 1, len(marks)):
            b = marks[j]
            length = math.dist(a[:2], b[:2]) ** 2
            if not (0.04477 <= length <= 0.10995 or 0.15057 <= length <= 0.4445):
                continue
            if any(between(a, c, b) for c in marks if c not in (a, b)):
                continue
            one, two = side(a, b), side(b, a)
            if one is None or two is None:
                continue
            # Seen from b the line runs the other way: what is left of it there is right of it here.
            sides = {one, -two} - {0}
            if len(sides) == 1:
                found.add((i, j) if sides == {1} else (j, i))
    return found


def beside_the_car(**options):
    asphalt = plate(car=CAR)
    return together(
        row(asphalt, start=(1.6, 4.2), heading=-90.0, **options),
        row(asphalt, start=(-1.6, -4.2), heading=90.0, **options),
    ), asphalt.ground


@pytest.mark.parametrize("curvature", [None, BENT])
@pytest.mark.parametrize(("entrance", "n"), [(2.6, 3), (2.3, 1), (6.0, 1)])
@pytest.mark.parametrize("heading", [-90.0, 0.0, 61.0, 90.0, 180.0])
def test_the_published_pairing_finds_the_labelled_slots(entrance, n, heading, curvature):
    x, y = -math.cos(math.radians(heading)) * n * entrance / 2, -math.sin(math.radians(heading)) * n * entrance / 2
    marks, slots = read(row(n=n, start=(x, y), heading=heading, entrance=entrance, curvature=curvature))
    assert len(slots) == n
    assert paired(marks) == set(slots)


def test_the_published_pairing_on_both_sides_of_the_car():
    scene, ground = beside_the_car(n=3, entrance=2.6)
    marks, slots = read(scene, ground)
    assert len(slots) == 6
    assert paired(marks) == set(slots)


def test_acute_slots_pair_within_the_published_tolerance():
    marks, slots = read(row(n=2, kind="slanted", angle=67.0, start=(0.0, 2.6)))
    assert paired(marks) == set(slots) == {(0, 1), (1, 2)}


def test_normalised_points_are_shares_of_the_frame():
    marks, _ = read(row(n=1, start=(-5.0, 5.0 - 2.0), entrance=2.0))
    assert marks[0][:2] == pytest.approx((0.0, 0.2), abs=1e-7)
    assert marks[1][:2] == pytest.approx((0.0, 0.4), abs=1e-7)


@pytest.mark.parametrize("angle", [67.0, 90.0, 128.0])
def test_arms_of_the_corners(angle):
    heading = 15.0
    marks, _ = read(row(n=2, kind="slanted", angle=angle, heading=heading, start=(-2.0, -1.0)))
    # Angles in the picture run clockwise as seen.
    entrance, depth = -math.radians(heading), -math.radians(heading + angle)
    first, middle, last = marks
    assert [mark[3] for mark in marks] == [1, 0, 1]
    assert off(first[2], depth) < 1e-5
    assert off(middle[2], depth) < 1e-5
    assert off(last[2], entrance + math.pi) < 1e-5
    # The second arm of an L is the first, a quarter turn clockwise as seen; with slanted slots only nearly.
    slant = abs(math.radians(angle - 90)) + 1e-5
    assert off(first[2] + math.pi / 2, entrance) < slant
    assert off(last[2] + math.pi / 2, depth) < slant


def test_the_second_point_lies_fifty_pixels_along():
    for x, y, to_x, to_y, _ in json.loads(dmpr.encode(truth(row(n=3, curvature=BENT), EVERYWHERE)))["marks"]:
        assert math.dist((x, y), (to_x, to_y)) == pytest.approx(50, abs=3e-4)


def test_rows_are_whole_numbers_so_that_readers_can_index_with_them():
    label = json.loads(dmpr.encode(truth(row(n=2, kind="slanted", angle=67.3, curvature=BENT), EVERYWHERE)))
    slots = np.array(label["slots"])
    assert slots.dtype.kind == "i" and slots[0, 2] == 2 and abs(slots[0, 3] - 67) <= 3
    assert np.array(label["marks"])[slots[:, 0] - 1].shape == (2, 5)


def test_without_slots_both_lists_are_there():
    assert json.loads(dmpr.encode(truth(row(n=0), EVERYWHERE))) == {"marks": [], "slots": []}
