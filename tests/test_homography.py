import numpy as np
import pytest

from pavemark.ground import Frame, homography, project

SQUARE = np.array([[0.0, 0.0], [600.0, 0.0], [600.0, 600.0], [0.0, 600.0]])


def test_more_points_average_their_errors():
    rng = np.random.default_rng(1)
    source = rng.uniform(0, 600, (400, 2))
    noisy = source + rng.normal(0, 0.5, source.shape)
    assert np.abs(project(homography(source, noisy), SQUARE) - SQUARE).max() < 0.5


def test_too_few_points_and_no_numbers_are_refused():
    with pytest.raises(ValueError, match="four pairs"):
        homography(SQUARE[:3], SQUARE[:3])
    with pytest.raises(ValueError, match="finite"):
        homography(SQUARE, SQUARE * np.nan)


def test_the_matrix_of_a_frame_is_its_map():
    frame = Frame(96, 300, 1 / 0.044)
    points = np.random.default_rng(0).uniform(0, 300, (9, 2))
    assert np.allclose(project(frame.matrix, points), frame.to_world(points), rtol=0, atol=1e-12)
    corners = np.array([[0, 0], [96, 0], [96, 300], [0, 300]])
    found = homography(corners, frame.to_world(corners))
    assert np.allclose(found / found[2, 2], frame.matrix, rtol=0, atol=1e-12)
