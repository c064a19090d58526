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

STEEPEST = 0.9
"""Largest allowed bound of the gradient's norm. Below 1 the map is one-to-one, so no outline crosses itself: the
Jacobian's determinant is at least (1 - STEEPEST/√2)². The norm itself stays about a third below its bound."""

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
def longest_chord(curvature: Curvature, sagitta: float) -> float:
    """How far apart points of a straight line may lie so that the field bends the line nowhere away from their chords.

    Parameters
    ----------
    curvature : Curvature
    sagitta : float
        Metres between chord and bent line that do not count.

    Returns
    -------
    float
        Metres; inf where the field bends nothing.
    """
    coefficients, spacing = _field(curvature)
    # A chord of length h strays from its arc by h²/8 times the second derivative along it.
    bend = _bound(coefficients, (2, 0), (1, 1), (1, 1), (0, 2)) / spacing**2
    return math.sqrt(8 * sagitta / bend) if bend else math.inf


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
    steepest = _bound(coefficients, (1, 0), (0, 1)) / spacing
    if steepest > STEEPEST:
        coefficients *= STEEPEST / steepest
    coefficients.setflags(write=False)
    return coefficients, spacing


def _bound(coefficients: np.ndarray, *orders: tuple[int, int]) -> float:
    """What the Frobenius norm of the derivatives of these orders exceeds nowhere on the plane, per unit of spacing.

    Within a cell each is a polynomial, a mean of its Bézier control points with weights that all of them share (Farin,
    *Curves and Surfaces for CAGD*, 1988), so its norm is at most the largest of the control points.
    """
    square = sum(
        (_control_points(_control_points(coefficients, along_x, 0), along_y, 1) ** 2).sum(-1)
        for along_x, along_y in orders
    )
    return float(np.sqrt(square.max()))


def _control_points(coefficients: np.ndarray, order: int, axis: int) -> np.ndarray:
    """Of the spline or its derivative along one axis, as polynomials of degree 3: three times the length.

    The fourth point of a cell is the first of the next.
    """
    near = [np.roll(coefficients, -k, axis) for k in _NEAR]
    return np.concatenate(
        [sum(weight * part for weight, part in zip(row, near, strict=True)) for row in _CONTROL[order]], axis
    )


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
_CONTROL = (
    np.array(
        [
            [[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0]],
            [[-3, 0, 3, 0], [-1, -4, 5, 0], [0, -5, 4, 1]],
            [[6, -12, 6, 0], [4, -6, 0, 2], [2, 0, -6, 4]],
        ]
    )
    / 6
)
"""Control points of one cell from its four nearest coefficients, for the spline and its first two derivatives."""
