"""What detectors learn from: mirrored and moved labels lie where the pixels do, and mean what they meant."""

import math

import attrs
import numpy as np
import pytest

from pavemark.labels.truth import truth
from pavemark.training.detectors import lessons
from pavemark.training.detectors.lessons import Lesson, at_scale, augmented, mirrored, noise
from scenes import row

EVERYWHERE = np.ones((600, 600), bool)


def labelled(**options):
    """The labels that the scene of a row of slots has."""
    true = truth(row(**options), EVERYWHERE)
    return Lesson(
        np.zeros((600, 600, 3), np.uint8),
        np.array([mark.point for mark in true.marks]),
        np.array([mark.direction for mark in true.marks]),
        np.array([mark.shape == "L" for mark in true.marks]),
        np.array([slot.entrance for slot in true.slots]),
    )


def told(lesson):
    """Points with directions and shapes, and slots by their points, in no order."""
    rows = np.round(np.column_stack([lesson.points, lesson.directions, lesson.l_shaped]), 6) + 0.0
    return sorted(rows.tolist()), sorted(rows[lesson.slots].tolist())


def angles(lesson):
    return np.degrees(np.arctan2(lesson.directions[:, 1], lesson.directions[:, 0])) % 360


@pytest.mark.parametrize("n", [1, 3])
def test_a_row_in_the_mirror_is_the_row_that_is_drawn_the_other_way(n):
    """Slots above a line seen in a mirror that exchanges top and bottom are slots below it."""
    up = labelled(n=n, start=(-3.0, 1.0), heading=0.0, entrance=2.0)
    down = labelled(n=n, start=(-3.0 + 2.0 * n, -1.0), heading=180.0, entrance=2.0)
    assert told(mirrored(up, 1)) == told(down)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("angle", [60.0, 90.0, 120.0])
def test_slanted_arms_are_exact_in_the_mirror(angle, axis):
    lesson = labelled(n=2, kind="slanted", angle=angle, start=(-2.0, -1.0), heading=15.0)
    there = mirrored(lesson, axis)
    line, lean = 15.0, 15.0 + angle
    # A mirror that exchanges left and right takes an angle to 180 less it, the other to its negative; rows that are
    # read backwards then run the other way. Angles in the picture run clockwise.
    seen = (lambda degrees: degrees - 180) if axis == 0 else (lambda degrees: degrees)
    first, middle, last = angles(there)
    # What was p1 is now p2 and points along the entrance line, to what was p2.
    assert math.isclose(first, seen(line) % 360, abs_tol=1e-6)
    assert math.isclose(middle, seen(lean) % 360, abs_tol=1e-6)
    assert math.isclose(last, seen(lean) % 360, abs_tol=1e-6)


def test_twice_mirrored_is_as_before():
    lesson = labelled(n=3, start=(-3.0, 1.0), heading=20.0, entrance=2.0)
    for axis in (0, 1):
        assert told(mirrored(mirrored(lesson, axis), axis)) == told(lesson)


def test_without_slots_the_other_arm_stands_at_a_right_angle():
    lesson = Lesson(
        np.zeros((40, 60, 3), np.uint8),
        np.array([[10.0, 5.0], [20.0, 7.0]]),
        np.array([[0.0, -1.0], [0.6, 0.8]]),
        np.array([True, False]),
    )
    there = mirrored(lesson, 0)
    # An L that points up has its other arm to the right; in the mirror the other arm is to the left, and first.
    np.testing.assert_allclose(there.directions, [[-1, 0], [-0.6, 0.8]])
    np.testing.assert_allclose(there.points, [[50, 5], [40, 7]])
    assert there.slots is None


def test_points_alone_stay_points_alone():
    lesson = Lesson(np.zeros((40, 60, 3), np.uint8), np.array([[10.0, 5.0]]))
    there = augmented(mirrored(lesson, 1), (64, 48), np.random.default_rng(0), noise(0))
    assert there.directions is None and there.l_shaped is None and there.slots is None


def test_pixels_and_points_move_together(monkeypatch):
    """A white dot is found by its brightness where the point is said to be, to a fraction of a pixel."""
    monkeypatch.setattr(lessons, "spoilt", lambda image, rng, grain: image)
    points = np.array([[31.5, 20.5], [80.5, 60.5]])
    image = np.zeros((90, 120, 3), np.uint8)
    rows, columns = np.mgrid[:90, :120] + 0.5
    for u, v in points:
        image[np.hypot(columns - u, rows - v) < 4] = 255
    compared = 0
    for seed in range(20):
        there = augmented(Lesson(image, points), (128, 96), np.random.default_rng(seed), noise(0))
        assert there.image.shape == (96, 128, 3)
        rows, columns = np.mgrid[:96, :128] + 0.5
        for u, v in there.points:
            weight = there.image[..., 0] * (np.hypot(columns - u, rows - v) < 9.0)
            if 9 < u < 119 and 9 < v < 87:
                compared += 1
                assert abs((weight * columns).sum() / weight.sum() - u) < 0.1
                assert abs((weight * rows).sum() / weight.sum() - v) < 0.1
    assert compared > 30


def test_what_leaves_the_picture_takes_its_slots_along():
    lesson = labelled(n=3, start=(-3.0, 1.0), heading=0.0, entrance=2.0)
    cut = lessons._within(attrs.evolve(lesson, image=lesson.image[:, :400]))
    assert len(cut.points) == 3 and len(cut.directions) == len(cut.l_shaped) == 3
    np.testing.assert_array_equal(cut.points[cut.slots], lesson.points[lesson.slots[:2]])


def test_another_scale_takes_the_points_along():
    lesson = Lesson(np.zeros((41, 60, 3), np.uint8), np.array([[60.0, 41.0]]))
    there = at_scale(lesson, 60.0, 20.0)
    assert there.image.shape == (14, 20, 3)
    np.testing.assert_allclose(there.points, [[20, 14]], rtol=1e-12)
    assert at_scale(lesson, 60.0, 60.3) is lesson
