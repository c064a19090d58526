"""Slots follow the lines that were moved by hand."""

import math

import attrs
import numpy as np
import pytest

from pavemark.geometry.follow import Drawn, follow
from pavemark.light import Relief, Sun
from pavemark.scene import Stroke
from scenes import plate, row


def drawn(scene, change=lambda point: point, number=0, width=None):
    """What float32 curves show of a marking, its points moved."""
    marking = scene.markings[number]
    strokes = tuple(
        Stroke(
            tuple(tuple(map(float, np.float32(change(point)))) for point in stroke.path),
            float(np.float32(width or stroke.width)),
            stroke.closed,
        )
        for stroke in marking.strokes
    )
    return Drawn(number, strokes, marking.areas)


def test_what_was_not_moved_stays_the_same_object():
    scene = row(plate(), n=3)
    assert follow(scene, [drawn(scene)]) is scene


@pytest.mark.parametrize("outline", ["closed", "half-closed", "open", "corner"])
def test_a_dragged_marking_point_takes_the_corners_of_both_slots_along(outline):
    scene = row(plate(), n=3, outline=outline)
    shared = scene.slots[0].corners[1]
    away = (-0.25, 0.125)

    def drag(point):
        return np.add(point, away) if math.dist(point, shared) < 1e-6 else point

    moved = follow(scene, [drawn(scene, drag)])
    there = np.add(shared, away)
    assert moved.slots[0].corners[1] == pytest.approx(there, abs=1e-6)
    assert moved.slots[1].corners[0] == pytest.approx(there, abs=1e-6)
    assert moved.slots[2] == scene.slots[2]
    assert moved.slots[0].corners[0] == scene.slots[0].corners[0]
    if outline == "corner":  # its end is not painted: it keeps the direction of the separating line
        assert moved.slots[0].corners[2] == pytest.approx(np.add(scene.slots[0].corners[2], away), abs=1e-6)


def test_a_marking_moved_whole_takes_unpainted_corners_along():
    scene = row(plate(), n=2, outline="corner")
    turn = math.radians(10)
    matrix = 1.1 * np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    moved = follow(scene, [drawn(scene, lambda point: matrix @ point + (0.5, -0.2))])
    for before, after in zip(scene.slots, moved.slots, strict=True):
        assert np.allclose(np.array(before.corners) @ matrix.T + (0.5, -0.2), after.corners, atol=1e-5)


def test_lines_that_are_gone_take_their_slots_with_them():
    scene = attrs.evolve(row(plate(), n=2), relief=Relief(0.003, 0.002, Sun(1.0, 0.5), 0.3))
    assert follow(scene, []).slots == ()
    assert follow(scene, []).markings == ()
    assert follow(scene, []).relief is None


def test_a_copied_marking_has_slots_of_its_own():
    scene = row(plate(), n=2)
    moved = follow(scene, [drawn(scene), drawn(scene, lambda point: np.add(point, (-6.0, 0.0)))])
    assert len(moved.markings) == 2
    assert moved.slots[::2] == scene.slots
    assert np.allclose(np.add(scene.slots[0].corners, (-6.0, 0.0)), moved.slots[1].corners, atol=1e-5)


def test_a_deleted_separating_line_between_two_slots_leaves_what_still_has_a_marking_point():
    scene = row(plate(), n=2, outline="half-closed")
    shown = drawn(scene)
    without = attrs.evolve(shown, strokes=shown.strokes[:1])
    assert len(follow(scene, [without]).slots) == 2


def test_a_changed_width_is_the_markings_own():
    scene = row(plate(), n=1)
    moved = follow(scene, [drawn(scene, width=0.25)])
    assert {stroke.width for stroke in moved.markings[0].strokes} == {0.25}
    assert moved.slots == scene.slots


def test_a_slot_turned_inside_out_is_refused():
    scene = row(plate(), n=1)
    first = scene.slots[0].corners[0]

    def drag(point):
        return np.add(point, (0.0, -6.0)) if math.dist(point, first) < 1e-6 else point

    with pytest.raises(ValueError, match="slot 1: corners turn right"):
        follow(scene, [drawn(scene, drag)])
