"""Other ways to solve the Poisson equation of a blend than the one that ships, to be held against it.

Each takes what `pavemark.compose.poisson.solve` takes and returns f at the pixels of the domain, but for the two that
cannot: fast transforms solve on a rectangle, and OpenCV takes pictures.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pyamg
import scipy.fft
import scipy.sparse as sparse
from scipy.sparse.linalg import LinearOperator, cg, splu

from pavemark.compose import poisson

LIMIT = 2000
"""Iterations allowed: without a preconditioner a line of paint takes some 70, a large area some hundreds."""

Preconditioner = Callable[[sparse.csr_matrix], LinearOperator]


def multigrid(matrix: sparse.csr_matrix) -> LinearOperator:
    """One V-cycle of algebraic multigrid (Ruge and Stüben, 1987; PyAMG), which is near the inverse of the matrix."""
    return pyamg.ruge_stuben_solver(matrix).aspreconditioner(cycle="V")


def iterative(
    domain: np.ndarray,
    a: np.ndarray,
    b: np.ndarray,
    guidance: np.ndarray,
    boundary: np.ndarray,
    tolerance: float,
    preconditioner: Preconditioner | None = None,
    limit: int = LIMIT,
) -> np.ndarray:
    """Conjugate gradients (Hestenes and Stiefel, 1952), channel by channel, from nought.

    Parameters
    ----------
    domain, a, b, guidance, boundary : ndarray
        See `pavemark.compose.poisson.solve`.
    tolerance : float
        Of the residual, as a share of the right side, in the Euclidean norm.
    preconditioner : callable or None
        From the matrix to what is near its inverse, such as `multigrid`.
    limit : int
        Iterations allowed.

    Returns
    -------
    ndarray (N, C) float64

    Raises
    ------
    numpy.linalg.LinAlgError
        When the tolerance is not met within the limit; the residual that was reached is told.
    """
    equations = poisson.system(domain, a, b, guidance, boundary)
    matrix = equations.matrix
    near = None if preconditioner is None else preconditioner(matrix)
    change = np.empty_like(equations.source)
    for channel, right in enumerate(equations.source.T):
        change[:, channel], lacking = cg(matrix, right, rtol=tolerance, atol=0.0, maxiter=limit, M=near)
        if lacking:
            reached = np.linalg.norm(right - matrix @ change[:, channel]) / np.linalg.norm(right)
            raise np.linalg.LinAlgError(
                f"conjugate gradients did not converge: residual {reached:.1e} of the right side after {limit} "
                f"iterations, {tolerance:.1e} is wanted"
            )
    return _given(boundary, equations) + change


def whole(domain: np.ndarray, a: np.ndarray, b: np.ndarray, guidance: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """A general sparse factor (SuperLU) of the whole five-point matrix: one call of scipy."""
    equations = poisson.system(domain, a, b, guidance, boundary)
    return _given(boundary, equations) + splu(equations.matrix.tocsc()).solve(equations.source)


def refined(
    domain: np.ndarray, a: np.ndarray, b: np.ndarray, guidance: np.ndarray, boundary: np.ndarray, steps: int = 4
) -> np.ndarray:
    """The solution to the last bit of float64: residuals in extended precision, solved for again and again.

    Iterative refinement (Wilkinson, 1963). Where long double is no longer than double, as on some ARM machines, it is
    about as exact as float64 alone.

    Returns
    -------
    ndarray (N, C) longdouble
    """
    equations = poisson.system(domain, a, b, guidance, boundary)
    factor = splu(equations.matrix.tocsc())
    exact = equations.source.astype(np.longdouble)
    result = np.zeros_like(exact)
    for _ in range(steps):
        result += factor.solve((exact - product(equations, result)).astype(np.float64))
    return _given(boundary, equations).astype(np.longdouble) + result


def product(equations: poisson.System, vector: np.ndarray) -> np.ndarray:
    """The matrix times columns (N, C), in the precision of the columns, which scipy's own product need not keep."""
    result = equations.degree[:, None].astype(vector.dtype) * vector
    np.subtract.at(result, equations.start, vector[equations.end])
    np.subtract.at(result, equations.end, vector[equations.start])
    return result


def fast(domain: np.ndarray, a: np.ndarray, b: np.ndarray, guidance: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """The equation on the domain's bounding rectangle, by sine transforms (Buneman's fast Poisson solver's heirs).

    Exact where the domain is that rectangle. Where it is not, the guidance beside the domain is the plate's own
    gradient, and the pixels of the plate there are free to move, which they should not.

    Returns
    -------
    ndarray (H, W, C) float64
        f everywhere: the boundary's beside the rectangle.
    """
    equations = poisson.system(domain, a, b, guidance, boundary)
    rows, columns = (np.flatnonzero(domain.any(axis)) for axis in (1, 0))
    window = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    source = np.zeros_like(boundary)
    source[domain] = equations.source
    height, width = source[window].shape[:2]
    # Eigenvalues of the five-point matrix with nought beside the rectangle.
    down, across = (2 - 2 * np.cos(np.pi * np.arange(1, size + 1) / (size + 1)) for size in (height, width))
    modes = scipy.fft.dstn(source[window], type=1, axes=(0, 1)) / (down[:, None] + across)[..., None]
    result = boundary.copy()
    result[window] += scipy.fft.idstn(modes, type=1, axes=(0, 1))
    return result


def seamless(domain: np.ndarray, plain: np.ndarray, plate: np.ndarray) -> np.ndarray:
    """OpenCV's seamless cloning of a picture of plain paint over ground into the plate.

    Parameters
    ----------
    domain : ndarray (H, W) bool
    plain, plate : ndarray (H, W, 3) uint8

    Returns
    -------
    ndarray (H, W, 3) uint8
    """
    rows, columns = (np.flatnonzero(domain.any(axis)) for axis in (1, 0))
    # It places the mask's bounding box by its middle, rounded down.
    middle = (int(columns[0] + columns[-1] + 1) // 2, int(rows[0] + rows[-1] + 1) // 2)
    return cv2.seamlessClone(plain, plate, 255 * domain.astype(np.uint8), middle, cv2.NORMAL_CLONE)


def _given(boundary: np.ndarray, equations: poisson.System) -> np.ndarray:
    return boundary.reshape(-1, boundary.shape[2])[equations.pixels]
