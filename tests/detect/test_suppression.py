"""Points that are found twice are told once."""

import numpy as np
import pytest

from pavemark.detect.suppression import APART, strongest


def test_the_more_confident_of_two_stays():
    points = np.array([[0.0, 0.0], [0.3, 0.3], [5.0, 0.0]])
    assert strongest(points, np.array([0.4, 0.6, 0.5])).tolist() == [1, 2]


def test_a_point_left_out_leaves_none_out():
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.8, 0.0]])
    assert strongest(points, np.array([0.9, 0.8, 0.7])).tolist() == [0, 2]


def test_just_apart_is_apart():
    points = np.array([[0.0, 0.0], [APART, 0.0], [0.0, APART - 1e-9]])
    assert strongest(points, np.ones(3)).tolist() == [0, 1]


@pytest.mark.parametrize("seed", range(3))
def test_ties_are_broken_by_place_whatever_the_order(seed):
    points = np.array([[1.0, 1.0], [1.2, 0.9], [0.9, 0.9], [3.0, 3.0], [3.0, 3.0]])
    order = np.random.default_rng(seed).permutation(5)
    kept = points[order][strongest(points[order], np.full(5, 0.5))]
    assert kept.tolist() == [[0.9, 0.9], [3.0, 3.0]]


def test_no_points():
    assert strongest(np.zeros((0, 2)), np.zeros(0)).shape == (0,)
