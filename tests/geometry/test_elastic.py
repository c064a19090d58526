"""The elastic field: exact derivatives, the classical recipe's strength, no folds, no frame."""

import numpy as np
import pytest

from pavemark.geometry.elastic import displace, jacobian
from pavemark.scene import Curvature

USUAL = Curvature(150.0, 0.4, 11)


def points(count=4000, reach=40.0, seed=0):
    return np.random.default_rng(seed).uniform(-reach, reach, (count, 2))


@pytest.mark.parametrize("curvature", [USUAL, Curvature(200.0, 0.1, 3), Curvature(1000.0, 0.02, 4)])
def test_jacobian_against_finite_differences(curvature):
    at = points(500)
    step = 1e-5 * curvature.sigma
    numeric = np.stack(
        [(displace(curvature, at + d) - displace(curvature, at - d)) / (2 * step) for d in step * np.eye(2)], -1
    )
    # Central differences: the third derivative times step², and 1e-14 m of rounding over a step.
    np.testing.assert_allclose(jacobian(curvature, at), numeric, rtol=0, atol=1e-6)


@pytest.mark.parametrize("sigma", [0.3, 0.5, 1.0])
def test_strength_of_the_classical_recipe(sigma):
    # White noise U(-1, 1) a pixel of 1/60 m, smoothed by a Gaussian of sigma px, times alpha:
    # standard deviation alpha · sqrt(1/3 · 1/(4π)) / sigma px for each component.
    expected = 100.0 * np.sqrt(1 / (12 * np.pi)) / (60 * sigma) / 60
    moved = [displace(Curvature(100.0, sigma, seed), at := points(2000, 64 * sigma, seed)) - at for seed in range(8)]
    measured = np.sqrt(np.mean(np.square(moved), axis=(0, 1)))
    # 8 fields of 64² coefficients leave about 1 % of chance.
    np.testing.assert_allclose(measured, expected, rtol=0.04)


def test_smooth_across_cells_and_periods():
    # Nodes lie sqrt(3)·sigma apart; across one, and across the period's seam, the field goes on.
    node = np.sqrt(3) * USUAL.sigma
    for k in (-65, -64, -1, 0, 1, 63, 64):
        at = np.array([[k * node - 1e-9, 0.3], [k * node + 1e-9, 0.3]])
        np.testing.assert_allclose(*displace(USUAL, at), atol=1e-8)
        np.testing.assert_allclose(*jacobian(USUAL, at), atol=1e-6)


def test_a_point_moves_alone_as_in_company():
    at = points(30)
    together = displace(USUAL, at)
    np.testing.assert_array_equal(np.array([displace(USUAL, point) for point in at]), together)
    np.testing.assert_array_equal(displace(USUAL, at.reshape(5, 6, 2)).reshape(-1, 2), together)


def test_seeds_differ_and_repeat():
    at = points(20)
    first = displace(USUAL, at)
    assert np.abs(displace(Curvature(150.0, 0.4, 12), at) - first).min() > 0
    np.testing.assert_array_equal(displace(Curvature(150.0, 0.4, 11), at), first)


def test_axes_are_independent_fields():
    moved = displace(USUAL, points()) - points()
    assert abs(np.corrcoef(moved.T)[0, 1]) < 0.2
