import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pavemark.ground import Frame, homography, project

SQUARE = np.array([[0.0, 0.0], [600.0, 0.0], [600.0, 600.0], [0.0, 600.0]])


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_known_map_is_found_again(seed):
    rng = np.random.default_rng(seed)
    true = np.eye(3) + np.array([[0.3, 0.3, 50], [0.3, 0.3, 50], [3e-4, 3e-4, 0]]) * rng.uniform(-1, 1, (3, 3))
    points = np.concatenate([SQUARE, rng.uniform(0, 600, (6, 2))])
    others = rng.uniform(0, 600, (20, 2))
    for count in (4, 10):
        found = homography(points[:count], project(true, points[:count]))
        # Coordinates of some 1e3 pixels, and maps of condition below 1e3, leave ten digits of float64's sixteen.
        assert np.abs(project(found, others) - project(true, others)).max() < 1e-7


def test_far_off_coordinates_cost_no_digits():
    # Metres in a national grid: without normalisation the equations lose all but a few digits.
    target = SQUARE / 60 + (456_000.0, 5_432_000.0)
    middle = project(homography(SQUARE, target), np.array([300.0, 300.0]))
    assert np.abs(middle - (456_005, 5_432_005)).max() < 1e-8


def test_more_points_average_their_errors():
    rng = np.random.default_rng(1)
    source = rng.uniform(0, 600, (400, 2))
    noisy = source + rng.normal(0, 0.5, source.shape)
    assert np.abs(project(homography(source, noisy), SQUARE) - SQUARE).max() < 0.5


@pytest.mark.parametrize(
    "source",
    [
        [[0, 0], [1, 1], [2, 2], [0, 5]],
        [[0, 0], [1, 1], [2, 2], [3, 3]],
        [[0, 0], [1, 0], [1, 0], [0, 1]],
        [[4, 4], [4, 4], [4, 4], [4, 4]],
    ],
)
def test_points_that_determine_nothing_are_refused_with_the_condition_number(source):
    source = np.array(source, float)
    with pytest.raises(ValueError, match="condition number"):
        homography(source, SQUARE)
    with pytest.raises(ValueError, match="condition number"):
        homography(SQUARE, source)


def test_too_few_points_and_no_numbers_are_refused():
    with pytest.raises(ValueError, match="four pairs"):
        homography(SQUARE[:3], SQUARE[:3])
    with pytest.raises(ValueError, match="finite"):
        homography(SQUARE, SQUARE * np.nan)


def test_points_beyond_the_horizon_are_refused():
    tilted = np.array([[1, 0, 0], [0, 1, 0], [0, 0.01, -1]], float)
    project(tilted, np.array([[0, 0], [5, 50]]))
    with pytest.raises(ValueError, match="vanishing line"):
        project(tilted, np.array([[0, 0], [0, 200]]))


def test_the_matrix_of_a_frame_is_its_map():
    frame = Frame(96, 300, 1 / 0.044)
    points = np.random.default_rng(0).uniform(0, 300, (9, 2))
    assert np.allclose(project(frame.matrix, points), frame.to_world(points), rtol=0, atol=1e-12)
    corners = np.array([[0, 0], [96, 0], [96, 300], [0, 300]])
    found = homography(corners, frame.to_world(corners))
    assert np.allclose(found / found[2, 2], frame.matrix, rtol=0, atol=1e-12)
