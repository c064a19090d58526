"""The pairing finds the labelled slots from points, directions and shapes, and none that the rules forbid."""

import math
import tracemalloc

import numpy as np
import pytest

from pavemark.detect.pairing import paired
from pavemark.labels.truth import truth
from scenes import row

EVERYWHERE = np.ones((600, 600), bool)


def marks(true):
    """Points in metres, directions, and whether an L."""
    points = np.array([mark.point for mark in true.marks]).reshape(-1, 2) / 60
    directions = np.array([mark.direction for mark in true.marks]).reshape(-1, 2)
    return points, directions, np.array([mark.shape == "L" for mark in true.marks], bool)


@pytest.mark.parametrize(("entrance", "n"), [(2.6, 3), (2.3, 1), (6.0, 1)])
@pytest.mark.parametrize("heading", [-90.0, 0.0, 61.0, 180.0])
def test_the_labelled_slots_are_found(entrance, n, heading):
    x, y = -math.cos(math.radians(heading)) * n * entrance / 2, -math.sin(math.radians(heading)) * n * entrance / 2
    true = truth(row(n=n, start=(x, y), heading=heading, entrance=entrance), EVERYWHERE)
    slots, sure = paired(*marks(true), np.ones(n + 1))
    assert sorted(map(tuple, slots.tolist())) == sorted(slot.entrance for slot in true.slots)
    assert (sure == 1).all()


@pytest.mark.parametrize(("kind", "angle"), [("perpendicular", 90.0), ("slanted", 67.0)])
def test_in_any_order_of_the_points(kind, angle):
    true = truth(row(n=2, kind=kind, angle=angle, start=(0.0, 2.6)), EVERYWHERE)
    points, directions, l_shaped = marks(true)
    order = np.array([2, 0, 1])
    slots, _ = paired(points[order], directions[order], l_shaped[order], np.ones(3))
    found = {tuple(order[slot]) for slot in slots}
    assert found == {(0, 1), (1, 2)}


def line(*lengths, shape=False, direction=(0.0, -1.0)):
    """Points along a line that runs right, with slots above it."""
    points = np.array([(x, 5.0) for x in np.cumsum([1.0, *lengths])])
    return points, np.tile(np.array(direction), (len(points), 1)), np.full(len(points), shape)


@pytest.mark.parametrize(
    ("length", "found"), [(2.0, 0), (2.2, 1), (3.3, 1), (3.4, 0), (3.8, 0), (3.9, 1), (6.6, 1), (6.7, 0)]
)
def test_entrances_have_certain_lengths(length, found):
    assert len(paired(*line(length), np.ones(2))[0]) == found


def test_a_slot_lies_to_the_left():
    above, _ = paired(*line(2.5), np.ones(2))
    below, _ = paired(*line(2.5, direction=(0.0, 1.0)), np.ones(2))
    assert above.tolist() == [[0, 1]] and below.tolist() == [[1, 0]]


def test_points_that_look_to_different_sides_are_no_slot():
    points, directions, l_shaped = line(2.5)
    directions[1] *= -1
    assert len(paired(points, directions, l_shaped, np.ones(2))[0]) == 0


def test_two_that_point_along_the_line_say_no_side():
    points, directions, l_shaped = line(2.5)
    directions[:] = [[1.0, 0.0], [-1.0, 0.0]]
    assert len(paired(points, directions, l_shaped, np.ones(2))[0]) == 0


def test_a_point_between_makes_a_slot_as_doubtful_as_it_is_sure():
    points, directions, l_shaped = line(2.5, 2.5)
    slots, sure = paired(points, directions, l_shaped, np.array([0.9, 1.0, 0.8]))
    assert slots.tolist() == [[0, 1], [1, 2]]
    slots, sure = paired(points, directions, l_shaped, np.array([0.9, 0.1, 0.8]))
    assert slots.tolist() == [[0, 2], [0, 1], [1, 2]]
    np.testing.assert_allclose(sure, [0.8 * 0.9, 0.1, 0.1])


def test_an_l_is_no_l_the_other_way():
    points, directions, _ = line(2.5)
    # An L that stands above the line at p2 has its other arm to the right: beyond the slot.
    directions = np.array([[0.0, -1.0], [-1.0, 0.0]])
    assert paired(points, directions, np.array([True, True]), np.ones(2))[0].tolist() == [[0, 1]]
    assert len(paired(points, np.array([[1.0, 0.0], [0.0, -1.0]]), np.array([True, True]), np.ones(2))[0]) == 0


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_points(count):
    slots, sure = paired(np.zeros((count, 2)), np.ones((count, 2)), np.zeros(count, bool), np.ones(count))
    assert slots.shape == (0, 2) and sure.shape == (0,)


def test_many_points_need_little_memory():
    """A car park of 100 rows seen at once: no array of all pairs, whose length alone would take 500 MB."""
    across, down = np.meshgrid(np.arange(40) * 2.5, np.arange(200) * 8.0)
    points = np.stack([across.ravel(), down.ravel()], 1)
    along = np.tile([0.0, -1.0], (len(points), 1))
    tracemalloc.start()
    slots, confidence = paired(points, along, np.zeros(len(points), bool), np.ones(len(points)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(slots) == 200 * 39 and (confidence == 1).all()
    assert peak < 50e6


def test_points_at_one_place_are_no_slot():
    points, directions, l_shaped = line(2.5, 0.0)
    slots, _ = paired(points, directions, l_shaped, np.array([0.9, 0.8, 0.7]))
    assert slots.tolist() == [] or all(i != j for i, j in slots)
