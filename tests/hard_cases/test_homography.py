"""Homographies from points that lie badly."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hard_cases import EPS, STEADY
from pavemark.ground import WORST_CONDITION, homography, project

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
INSIDE = np.array([[0.5, 0.5], [0.1, 0.8], [0.9, 0.2]])

TILTED = np.array([[1.1, 0.2, 3.0], [-0.1, 0.9, 2.0], [0.2, 0.3, 1.0]])
"""A map of condition 17 that takes the unit square to a quadrilateral about one wide."""

AMPLIFIED = 64 * EPS
"""What a condition number of 1 may cost: some eight rounded operations on the way, each of a few terms."""

# Corners of a square of side 1, each moved by at most 0.2: always convex. From one such to another, equations have
# condition numbers up to 16 and maps up to 31, both where all corners are moved as far as they may.
quadrilaterals = arrays(np.float64, (4, 2), elements=st.floats(-0.2, 0.2)).map(lambda moves: UNIT + moves)
seeds = st.integers(0, 2**32 - 1)


def off(found, source, target):
    """Largest distance from the target points, as a share of how far these are apart."""
    return np.abs(project(found, source) - target).max() / np.ptp(target, axis=0).max()


def condition(source, target):
    """The condition number that a refusal tells."""
    with pytest.raises(ValueError, match="condition number") as refusal:
        homography(source, target)
    return float(re.search(r"condition number (\S+):", str(refusal.value))[1])


@settings(STEADY, max_examples=100)
@given(quadrilaterals, quadrilaterals, st.integers(-6, 7), st.integers(-6, 7))
def test_without_noise_points_are_met_to_1e9_of_their_spread_at_any_scale(source, target, metres, pixels):
    source, target = source * 10.0**metres, target * 10.0**pixels
    # 1e-9 is 140 times what conditions of 16 and 31 may cost, 64·EPS each.
    assert off(homography(source, target), source, target) < 1e-9


@settings(STEADY, max_examples=50)
@given(seeds)
def test_a_known_map_is_found_again(seed):
    rng = np.random.default_rng(seed)
    true = np.eye(3) + np.array([[0.3, 0.3, 50], [0.3, 0.3, 50], [3e-4, 3e-4, 0]]) * rng.uniform(-1, 1, (3, 3))
    points = np.concatenate([600 * UNIT, rng.uniform(0, 600, (6, 2))])
    others = rng.uniform(0, 600, (20, 2))
    for count in (4, 10):
        found = homography(points[:count], project(true, points[:count]))
        # Coordinates of some 1e3 pixels, and maps of condition below 1e3, leave ten digits of float64's sixteen.
        assert np.abs(project(found, others) - project(true, others)).max() < 1e-7


@settings(STEADY, max_examples=50)
@given(quadrilaterals, quadrilaterals, st.integers(-20, 23), st.integers(-20, 23))
def test_units_do_not_matter(source, target, k, m):
    plain = project(homography(source, target), INSIDE)
    scaled = project(homography(source * 2.0**k, target * 2.0**m), INSIDE * 2.0**k) / 2.0**m
    # Powers of two scale without rounding, normalised coordinates are the same to the bit: what remains are the
    # roundings of taking the scales off again.
    np.testing.assert_allclose(scaled, plain, rtol=0, atol=AMPLIFIED * 10)


@pytest.mark.parametrize("gap", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_nearly_collinear_points_cost_as_many_digits_as_they_are_near_a_line(gap):
    source = np.array([[0, 0], [1, -gap], [2, 0], [0.5, 2]])
    target = project(TILTED, source)
    found = homography(source, target)
    # The equations' condition is that of the triangle of the first three points, 13 / gap here.
    assert off(found, source, target) < AMPLIFIED * 13 / gap
    assert np.abs(project(found, INSIDE) - project(TILTED, INSIDE)).max() < AMPLIFIED * 13 / gap


@pytest.mark.parametrize("gap", [1e-8, 1e-10, 1e-12])
def test_points_nearer_to_a_line_are_refused_with_their_condition_number(gap):
    source = np.array([[0, 0], [1, -gap], [2, 0], [0.5, 2]])
    told = condition(source, project(TILTED, source))
    assert told > WORST_CONDITION
    assert 1 / 30 < told * gap < 30


@pytest.mark.parametrize(
    "source",
    [
        pytest.param([[0, 0], [1, 1], [2, 2], [0, 5]], id="three on a line"),
        pytest.param([[0, 0], [1, 1], [2, 2], [3, 3]], id="all on a line"),
        pytest.param([[0, 0], [1, 0], [1, 0], [0, 1]], id="one of them twice"),
        pytest.param([[4, 4], [4, 4], [4, 4], [4, 4]], id="all the same"),
    ],
)
def test_points_that_determine_nothing_are_refused_with_their_condition_number(source):
    source = np.array(source, float)
    # A singular system, rounded, still has singular values of some EPS.
    assert condition(source, UNIT) > 1e14
    assert condition(UNIT, source) > 1e14


@settings(STEADY, max_examples=50)
@given(quadrilaterals, quadrilaterals, st.lists(st.integers(0, 3), max_size=30))
def test_points_that_come_more_than_once_do_no_harm(source, target, again):
    which = [0, 1, 2, 3, *again]
    # Repeated equations weigh more and ask for the same: the solution is that of the four, as exact as theirs.
    assert off(homography(source[which], target[which]), source, target) < 1e-9


@pytest.mark.parametrize("far", ["source", "target", "both"])
def test_at_1e7_metres_only_the_digits_of_the_coordinates_themselves_are_lost(far):
    near, shift = 10 * UNIT, np.array([1e7, -0.7e7])
    source = near + shift * (far != "target")
    target = 3 * near[[1, 2, 3, 0]] + shift * (far != "source")
    error = np.abs(project(homography(source, target), source) - target).max()
    # Numbers near 1e7 are 1.9e-9 apart, before and after the map, which enlarges three times.
    assert error < 8 * np.spacing(1e7)


def test_metres_of_a_national_grid():
    square = 600 * UNIT
    target = square / 60 + (456_000.0, 5_432_000.0)
    middle = project(homography(square, target), np.array([300.0, 300.0]))
    # Without normalisation the equations would lose all but a few digits.
    assert np.abs(middle - (456_005, 5_432_005)).max() < 8 * np.spacing(5_432_000.0)


def test_squares_of_1e_6_metres():
    tiny = 1e-6 * UNIT
    assert off(homography(tiny, 600 * UNIT), tiny, 600 * UNIT) < AMPLIFIED
    assert off(homography(600 * UNIT, tiny), 600 * UNIT, tiny) < AMPLIFIED


@pytest.mark.parametrize("size", [1e-1, 1e-3, 1e-6])
def test_squares_too_small_for_where_they_lie_are_refused(size):
    # At 1e7 m a square of a millimetre has 500,000 numbers a side, and a map to it is off by some of them.
    for source, target in ((UNIT * size + 1e7, UNIT), (UNIT, UNIT * size + 1e7)):
        assert condition(source, target) == pytest.approx(2e7 / size, rel=0.2)


def rising(w):
    """A map whose vanishing line passes the square's upper side at scale w, the lower side at scale 1."""
    return np.array([[1, 0.1, 2], [0.1, 1, 3], [0, w - 1, 1]])


@pytest.mark.parametrize("w", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_a_horizon_close_to_the_points_costs_as_many_digits_as_it_is_near(w):
    target = project(rising(w), UNIT)
    found = homography(UNIT, target)
    # The points next to the horizon are moved off to 1 / w, and w is the small difference of numbers near 1.
    assert off(found, UNIT, target) < AMPLIFIED * 10 / w
    # Whoever asks for points on the ground side of it gets them: scales are positive there.
    assert ((np.column_stack([UNIT, np.ones(4)]) @ found[2]) > 0).all()


@pytest.mark.parametrize("w", [1e-8, 1e-10, 1e-12])
def test_a_horizon_through_the_points_is_refused_with_the_condition_number(w):
    assert condition(UNIT, project(rising(w), UNIT)) > WORST_CONDITION


def test_points_on_and_beyond_the_horizon_are_refused():
    horizon = np.array([[1, 0, 0], [0, 1, 0], [0, 0.01, -1]], float)
    for beyond in ([[0, 0], [0, 200]], [[0, 0], [0, 100]], [[0, 100]], [[0, np.nan]]):
        with pytest.raises(ValueError, match="vanishing line"):
            project(horizon, np.array(beyond, float))
    behind = np.array([[0, 0], [5, 50]])
    # All on one side of it, a map and its negative are the same map.
    np.testing.assert_array_equal(project(horizon, behind), project(-horizon, behind))


@settings(STEADY, max_examples=50)
@given(quadrilaterals, quadrilaterals)
def test_mirrored_order_is_a_map_that_turns_the_plane_over(source, target):
    mirrored = target[[0, 3, 2, 1]]
    found = homography(source, mirrored)
    assert off(found, source, mirrored) < 1e-9
    # The determinant's sign is that of the orientation, as the scale is positive at all points.
    assert np.linalg.det(found) < 0 < np.linalg.det(homography(source, target))


@settings(STEADY, max_examples=50)
@given(quadrilaterals, quadrilaterals)
def test_two_corners_exchanged_are_refused(source, target):
    # A convex quadrilateral is mapped to one that crosses itself only by way of infinity.
    with pytest.raises(ValueError, match=r"vanishing line|condition number"):
        homography(source, target[[0, 2, 1, 3]])
