"""The geometry stage: the order of its contenders is known from the mathematics."""

import math

import numpy as np
import pytest
import shapely

from pavemark.accuracy import marked, shapes
from pavemark.accuracy.geometry import PROBLEMS, contenders, work
from pavemark.accuracy.maps import NORMALISED, Pairs, errors, estimating
from pavemark.accuracy.work_precision import power
from pavemark.geometry.outline import outline
from pavemark.scene import Marking


def test_chords_are_off_by_the_square_of_their_length():
    made = {setting: shapes.bent_errors(way()) for (_, setting), way in shapes.bending().items()}
    # Where chords are as long as the field's bends, the square does not hold yet.
    short = [step for step in shapes.STEPS if step <= 0.2]
    for measure in ("error", "marking_point"):
        assert power([made[f"{step:g} m"][measure] for step in short], short) == pytest.approx(2.0, abs=0.2)
    assert made["0.05 m"]["error"] < 0.02


def test_marking_points_lie_on_the_lines_of_the_row():
    shape = outline(Marking("slot", marked.FRESH, marked.row(turn=0.3)), None)
    found = marked.marking_points(turn=0.3)
    assert len(found) == 8
    assert shapely.distance(shapely.points(found), shapely.boundary(shape)).max() <= math.hypot(0.05, 0.05) + 1e-9
    assert shapely.contains(shape.buffer(1e-9), shapely.points(found)).all()


def test_simplified_outlines_are_near_the_true_one_and_worse_with_a_larger_tolerance():
    made = {way: shapes.simplified_errors(run()) for way, run in shapes.simplifying().items()}
    # A mask's outline runs along the borders of pixels: it is off by up to 0.71 pixels before anything is simplified.
    assert 0.3 < made["GEOS", "ε=0.25"]["error"] < 0.71 + 0.25
    for family in ("GEOS", "OpenCV"):
        assert made[family, "ε=0.25"]["error"] < made[family, "ε=8"]["error"] <= 8.8
    assert made[shapes.OURS, ""]["error"] < 2
    assert max(shapes.simplified_errors(shapes.drawn()).values()) < 1e-11


@pytest.mark.parametrize(("distance", "least", "most"), [(1e4, 1e-3, 1.0), (1e7, 1.0, 100.0)])
def test_single_precision_far_off_is_worse_than_double(distance, least, most):
    made = {family: shapes.placed_errors(way()) for (family, _), way in shapes.placing(distance).items()}
    # Half a unit in the last place of the coordinate, twice over, in pixels.
    assert made["float64"]["error"] < 60 * distance * 2**-52 * 4
    assert least < made["float32"]["error"] < most
    assert made["float32 from the frame's centre"]["error"] < 1e-3
    assert made["float32"]["error"] <= made["float32"]["marking_point"]


def maps(pairs):
    made = {}
    for (family, _), way in estimating(pairs).items():
        try:
            made[family] = errors(way(), pairs)["marking_point"]
        except ValueError:
            made[family] = float("inf")
    return made


def test_homographies_from_exact_points():
    made = maps(Pairs())
    assert made[NORMALISED] < 1e-10
    assert 1e-7 < made["OpenCV least squares"] < 1e-2  # its points are single precision
    assert all(np.isfinite(list(made.values())))


def test_only_normalised_equations_stand_a_far_origin():
    near, far = maps(Pairs(0.5)), maps(Pairs(0.5, 1e7))
    assert far[NORMALISED] == pytest.approx(near[NORMALISED], rel=0.01)
    assert far["plain DLT"] > 2 * far[NORMALISED]
    assert far["OpenCV least squares"] > 10 * far[NORMALISED]


def test_only_robust_estimators_stand_wrong_pairs():
    made = maps(Pairs(0.5, wrong=3))
    assert made["OpenCV RANSAC"] < 1 < 5 < min(made[NORMALISED], made["OpenCV least squares"])


def test_each_problem_has_one_way_that_ships():
    every = contenders()
    assert [sum(one.ships for one in every if one.problem == name) for name in PROBLEMS] == [1] * len(PROBLEMS)
    assert isinstance(work(every[0]), np.ndarray)
