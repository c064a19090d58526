"""How far a detector is from the truth of an image: the point loss (Zhang, Liu, Gao 2026, Eq. 2)."""

from __future__ import annotations

import math

import numpy as np


def point_loss(points: np.ndarray, size: tuple[int, int], predicted: np.ndarray) -> float:
    """Confidence missed in every cell of a detector's grid, and place missed in those with a marking point.

    ``(1/S²) Σ { (c − ĉ)² + 1[obj] · [(x − x̂)² + (y − ŷ)²] }`` over the cells, S² their number.

    Parameters
    ----------
    points : ndarray (N, 2)
        True marking points, image coordinates in pixels, u right and v down. A point on the border of two cells belongs
        to the right or lower one, one on the picture's own far border to the last. Of several in a cell the one
        nearest to its middle counts, for a detector can find but one; of two as near the upper one, then the left.
    size : tuple of int
        Width and height of the picture, pixels.
    predicted : ndarray (R, C, 3)
        For each cell the confidence, 0 to 1, and the place in the cell, 0 to 1 from its left and upper border.

    Returns
    -------
    float
        The sum is exact before it is rounded, so it is the same on every platform and in any order.

    Raises
    ------
    ValueError
        When a number is not finite, or a point lies outside the picture.
    """
    predicted = np.asarray(predicted, np.float64)
    points = np.asarray(points, np.float64).reshape(-1, 2)
    if predicted.ndim != 3 or predicted.shape[2] != 3 or not predicted.size:
        raise ValueError(f"a prediction of shape {predicted.shape}: (rows, columns, 3) is allowed")
    if not np.isfinite(predicted).all():
        row, column, _ = np.argwhere(~np.isfinite(predicted))[0]
        raise ValueError(f"the prediction of cell ({row}, {column}) is not finite: finite numbers are allowed")
    outside = ~((points >= 0) & (points <= size)).all(1)
    if outside.any():
        u, v = points[outside][0]
        raise ValueError(f"a point at ({u:g}, {v:g}) px: within the picture of {size[0]}×{size[1]} is allowed")
    terms = predicted[..., 0] ** 2
    for (row, column), place in _truth(points, size, predicted.shape[:2]).items():
        confidence, *found = predicted[row, column]
        terms[row, column] = math.fsum(
            [(1 - confidence) ** 2, *((a - b) ** 2 for a, b in zip(place, found, strict=True))]
        )
    return math.fsum(terms.ravel()) / terms.size


def _truth(
    points: np.ndarray, size: tuple[int, int], grid: tuple[int, int]
) -> dict[tuple[int, int], tuple[float, ...]]:
    """The place in its cell of the point that counts, by cell."""
    rows, columns = grid
    chosen: dict[tuple[int, int], tuple] = {}
    for u, v in points.tolist():
        x, y = u / size[0] * columns, v / size[1] * rows
        cell = min(int(y), rows - 1), min(int(x), columns - 1)
        place = x - cell[1], y - cell[0]
        key = ((place[0] - 0.5) ** 2 + (place[1] - 0.5) ** 2, v, u, place)
        if cell not in chosen or key < chosen[cell]:
            chosen[cell] = key
    return {cell: key[3] for cell, key in chosen.items()}
