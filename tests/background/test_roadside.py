"""The roadside of pictures drawn by hand."""

import math

import cv2
import numpy as np
import pytest

from pavemark.background.roadside import CERTAIN, find_roadside
from pavemark.ground import Frame

FULL = Frame(600, 600, 60.0)
HALF = Frame(96, 300, 1 / 0.044)
RNG = np.random.default_rng(4)


def canvas(frame):
    return np.zeros((frame.height, frame.width), np.uint8)


def drawn(frame, segments, width=0.12):
    """Segments, world metres, as a mask."""
    image = canvas(frame)
    for ends in segments:
        a, b = np.rint(frame.to_image(np.array(ends)) * 16).astype(int)
        cv2.line(image, tuple(a), tuple(b), 1, max(2, round(width * frame.scale)), shift=4)
    return image > 0


def turned(points, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array(points) @ [[c, s], [-s, c]]


def ego_of(frame):
    ego = canvas(frame) > 0
    if frame is FULL:
        ego[200:400, 240:360] = True
    else:
        ego[110:230, -11:] = True
    return ego


def row(x, side, slant=90.0, entrance=True, pitch=2.6):
    """An upright entrance line at x with separating lines to one side, leaning."""
    lean = math.radians(slant)
    depth = side * 5.0 * np.array([math.sin(lean), 0]) + 5.0 * np.array([0, math.cos(lean)])
    starts = [np.array([x, y]) for y in np.arange(-9.0, 9.1, pitch)]
    segments = [(start, start + depth) for start in starts]
    return [*segments, ((x, -9.0), (x, 9.0))] if entrance else segments


@pytest.mark.parametrize("turn", [-12.0, -3.3, 0.0, 4.7, 11.0])
@pytest.mark.parametrize(("frame", "x", "side"), [(FULL, 2.4, 1), (FULL, -2.4, -1), (HALF, -0.6, -1)])
def test_a_row_of_slots_tells_direction_and_line(frame, x, side, turn):
    marks = drawn(frame, [turned(ends, turn) for ends in row(x, side)])
    ego = ego_of(frame)
    found = find_roadside(marks & ~ego, ~ego, ego, frame)
    assert math.degrees(found.direction) == pytest.approx(90 + turn, abs=0.5)
    assert CERTAIN < found.confidence <= 1
    line = found.right if side > 0 else found.left
    assert line == pytest.approx(-x, abs=0.06)  # along the normal, which points left


def test_a_row_across_gives_the_same_direction_as_one_along():
    marks = drawn(FULL, [turned(ends, 94.0) for ends in row(3.0, 1)])
    found = find_roadside(marks, marks | True, canvas(FULL) > 0, FULL)
    assert math.degrees(found.direction) == pytest.approx(94, abs=0.5)


@pytest.mark.parametrize("slant", [60.0, 120.0, 72.0])
def test_separating_lines_of_slanted_rows_do_not_hide_the_entrance_line(slant):
    marks = drawn(FULL, row(2.4, 1, slant))
    found = find_roadside(marks, marks | True, canvas(FULL) > 0, FULL)
    assert math.degrees(found.direction) == pytest.approx(90, abs=0.7)
    assert found.right == pytest.approx(-2.4, abs=0.1)


def test_the_line_is_where_slots_begin_and_not_the_lane_line_beside_it():
    marks = drawn(FULL, [*row(3.0, 1, pitch=2.2), ((2.2, -9.0), (2.2, 9.0))])
    found = find_roadside(marks, marks | True, canvas(FULL) > 0, FULL)
    assert found.right == pytest.approx(-3.0, abs=0.06)


def test_open_slots_begin_where_their_lines_do():
    marks = drawn(FULL, [turned(ends, 3.0) for ends in row(2.5, 1, entrance=False, pitch=2.0)])
    found = find_roadside(marks, marks | True, canvas(FULL) > 0, FULL)
    assert math.degrees(found.direction) == pytest.approx(93, abs=0.7)
    assert found.right == pytest.approx(-2.5, abs=0.15)


@pytest.mark.parametrize("turn", [-8.0, 0.0, 6.0])
def test_a_wall_alone_tells_both(turn):
    ego = ego_of(FULL)
    wall = drawn(FULL, [turned(((-4.2, -9.0), (-4.2, 9.0)), turn)], width=1.0)
    wall[:, :60] |= wall[:, :60].any()
    ground = ~(ego | wall)
    found = find_roadside(ground & False, ground, ego, FULL)
    assert math.degrees(found.direction) == pytest.approx(90 + turn, abs=0.7)
    assert found.left == pytest.approx(3.7, abs=0.1)
    assert found.right is None


def test_bare_ground_and_the_outline_of_the_ego_car_tell_nothing():
    for frame in (FULL, HALF):
        ego = ego_of(frame)
        assert find_roadside(ego & False, ~ego, ego, frame) is None
        assert find_roadside(ego & False, ego & False, ego, frame) is None
        assert find_roadside(ego | True, ego | True, ego & False, frame) is None


def test_strokes_in_all_directions_tell_nothing():
    segments = []
    for angle in RNG.uniform(0, 180, 24):
        middle = RNG.uniform(-4.5, 4.5, 2)
        segments.append(middle + turned([(-0.6, 0), (0.6, 0)], angle))
    marks = drawn(FULL, segments)
    assert find_roadside(marks, marks | True, canvas(FULL) > 0, FULL) is None


@pytest.mark.parametrize("size", [(8, 8), (8, 300), (300, 8)])
def test_tiny_frames_are_judged_too(size):
    frame = Frame(*size, 20.0)
    full = canvas(frame) > -1
    full[size[1] // 2 :] = False
    find_roadside(full, ~full, full & False, frame)
