"""Elastic deformation: a smooth random displacement of the ground plane (the paper's curvature domain).

The classical recipe smooths white noise on the pixel grid with a Gaussian and multiplies by alpha. The same field,
without a grid of pixels: a cubic B-spline with random coefficients, of equal variance and correlation length. It is
defined everywhere on the plane, independent of any frame, and its derivatives are exact, so that directions of
marking points follow too.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from pavemark.scene import Curvature

PERIOD = 64
"""Coefficients a side; beyond them the field repeats."""

STEEPEST = 0.6
"""Largest allowed norm of the displacement's gradient: below 1 the map is one-to-one, so no outline crosses itself."""

_PIXEL = 1 / 60
# The variance of a cubic B-spline sum of unit coefficients, averaged over the plane: (∫B³²)² = 0.479365².
_SPLINE_VARIANCE = 0.479365**2


def displace(curvature: Curvature | None, points: np.ndarray) -> np.ndarray:
    """Where the elastic field moves points.

    Parameters
    ----------
    curvature : Curvature or None
        None is the exact identity.
    points : ndarray (..., 2)
        World, metres.

    Returns
    -------
    ndarray (..., 2), float64
    """
    points = np.asarray(points, np.float64)
    if curvature is None:
        return points
    coefficients, spacing = _field(curvature)
    return points + _evaluate(coefficients, points / spacing, (0, 0))


def jacobian(curvature: Curvature | None, points: np.ndarray) -> np.ndarray:
    """Derivative (..., 2, 2) of the displaced position by the position, float64."""
    points = np.asarray(points, np.float64)
    identity = np.broadcast_to(np.eye(2), (*points.shape[:-1], 2, 2))
    if curvature is None:
        return identity.copy()
    coefficients, spacing = _field(curvature)
    by_x = _evaluate(coefficients, points / spacing, (1, 0)) / spacing
    by_y = _evaluate(coefficients, points / spacing, (0, 1)) / spacing
    return identity + np.stack([by_x, by_y], -1)


@lru_cache(maxsize=4)
def _field(curvature: Curvature) -> tuple[np.ndarray, float]:
    """Coefficients (PERIOD, PERIOD, 2) in metres and their spacing in metres."""
    # White noise U(-1, 1) a pixel, smoothed with sigma s pixels: variance 1/3 · 1/(4πs²), covariance exp(-r²/4s²).
    # Two cubic B-splines of spacing h have the covariance's variance 2h²/3; equal to 2s² for h = √3·s.
    spacing = math.sqrt(3) * curvature.sigma
    deviation = curvature.alpha * _PIXEL * math.sqrt(1 / 3 / (4 * math.pi)) / (curvature.sigma / _PIXEL)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(curvature.seed)))
    noise = rng.standard_normal((PERIOD, PERIOD, 2))
    coefficients = noise * (deviation / math.sqrt(_SPLINE_VARIANCE))
    steepest = _steepest(coefficients) / spacing
    if steepest > STEEPEST:
        coefficients *= STEEPEST / steepest
    coefficients.setflags(write=False)
    return coefficients, spacing


def _steepest(coefficients: np.ndarray) -> float:
    """Largest Frobenius norm of the gradient, per unit of spacing, at the nodes and half-way between them."""
    square = np.zeros((2 * PERIOD, 2 * PERIOD))
    for order in ((1, 0), (0, 1)):
        rows = _at_halves(coefficients, order[0], axis=0)
        square += (_at_halves(rows, order[1], axis=1) ** 2).sum(-1)
    return float(np.sqrt(square.max()))


def _at_halves(coefficients: np.ndarray, order: int, axis: int) -> np.ndarray:
    """The spline or its derivative along one axis, at every node and half-way to the next: twice the length."""
    weights = _WEIGHTS[order](np.array([0.0, 0.5])).T
    shifted = [np.roll(coefficients, 1 - i, axis) for i in range(4)]
    halves = [sum(weight[k] * part for weight, part in zip(weights, shifted, strict=True)) for k in (0, 1)]
    return np.concatenate(halves, axis)


def _evaluate(coefficients: np.ndarray, at: np.ndarray, order: tuple[int, int]) -> np.ndarray:
    """The spline (order 0) or its first derivative (order 1) along each axis, at positions in units of spacing."""
    cell = np.floor(at)
    x, y = np.moveaxis(at - cell, -1, 0)
    nodes = (cell.astype(np.int64)[..., None] + _NEAR) % PERIOD
    near = coefficients[nodes[..., 0, :, None], nodes[..., 1, None, :]]
    return np.einsum("...i,...j,...ijk->...k", _WEIGHTS[order[0]](x), _WEIGHTS[order[1]](y), near)


def _values(t: np.ndarray) -> np.ndarray:
    """Weights (..., 4) of the four nearest coefficients at the share t of the way from one node to the next."""
    return np.stack([(1 - t) ** 3, (3 * t - 6) * t * t + 4, ((3 - 3 * t) * t + 3) * t + 1, t**3], -1) / 6


def _slopes(t: np.ndarray) -> np.ndarray:
    return np.stack([-((1 - t) ** 2), (3 * t - 4) * t, (2 - 3 * t) * t + 1, t * t], -1) / 2


_NEAR = np.arange(-1, 3)
_WEIGHTS = (_values, _slopes)
