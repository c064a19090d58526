"""Markings of a mask as areas on the ground, to be painted anew (the paper's "original" line masks)."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from pavemark.ground import project
from pavemark.scene import Area, Path

ARC_SHARE = 0.01
"""Tolerance of Douglas-Peucker as a share of the contour's length, as in the paper."""

WIDTH_SHARE = 0.25
"""Largest tolerance as a share of the stroke's width: 1 % of the contour of a long line is wider than the line."""

AREA_CHANGE = 0.05
"""Share of its area by which a marking may grow or shrink; a tolerance that does more is halved."""


def areas(markings: np.ndarray, matrix: np.ndarray) -> tuple[Area, ...]:
    """Vectorise a mask.

    Each 4-connected marking becomes one area with its holes. Outlines run along pixel borders: pixel k reaches from k
    to k + 1. They are simplified by Douglas-Peucker at 1 % of the contour's length, or less where that would harm the
    shape (docs/decisions/contours.md), and mapped to the ground by Eq. 1.

    Parameters
    ----------
    markings : ndarray (H, W) bool
    matrix : ndarray (3, 3)
        Homography from image coordinates to world metres; `Frame.matrix` for a picture seen straight from above.

    Returns
    -------
    tuple of Area
        In the order of their uppermost, then leftmost pixel.

    Raises
    ------
    ValueError
        When a marking lies beyond the homography's vanishing line.
    """
    return tuple(traced(shape, matrix) for shape in outlines(markings))


def outlines(markings: np.ndarray) -> list[Polygon]:
    """The exact outlines of a mask's 4-connected regions, along pixel borders, in image coordinates."""
    # Faces of the borders, not a union of runs: that takes minutes where there are many, as in noise or a comb.
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(_borders(markings))))
    column, row = np.floor(shapely.get_coordinates(shapely.point_on_surface(faces))).astype(np.int64).T
    return sorted(faces[markings[row, column]], key=lambda shape: shape.bounds[1::-1])


def _borders(markings: np.ndarray) -> np.ndarray:
    """Straight pieces (N, 2, 2) of a mask's border in image coordinates, cut where it turns and where corners touch."""
    padded = np.pad(markings.astype(np.int8), 1)
    pieces = []
    for turned in (padded, padded.T):
        # Where corners touch, a border goes on straight with the mask on its other side.
        side = np.diff(turned, axis=0)
        change = np.diff(side, axis=1) != 0
        line, start = np.nonzero(change & (side[:, 1:] != 0))
        _, end = np.nonzero(change & (side[:, :-1] != 0))
        pieces.append(np.stack([np.stack([start, line], -1), np.stack([end, line], -1)], 1))
    across, down = pieces
    return np.concatenate([across, down[..., ::-1]]).astype(np.float64)


def tolerance(shape: Polygon) -> float:
    """Tolerance of Douglas-Peucker for an outline, in its own units."""
    width = 2 * shape.area / shape.length
    return min(ARC_SHARE * shape.exterior.length, WIDTH_SHARE * width)


def simplified(shape: Polygon) -> Polygon:
    """The outline with fewer vertices: valid, none of them further than `tolerance` from where it was."""
    # Normalised, a ring begins at its leftmost point, which is a corner and not a step in the middle of a side.
    shape = shape.normalize()
    corners = shapely.points(shapely.get_coordinates(shape))
    largest = epsilon = tolerance(shape)
    while True:
        simple = shape.simplify(epsilon)
        outline = simple.boundary
        shapely.prepare(outline)
        # GEOS drops the point at which a ring begins and ends without regard to what was dropped beside it.
        near = shapely.dwithin(outline, corners, largest).all()
        if near and abs(simple.area - shape.area) <= AREA_CHANGE * shape.area:
            return simple
        epsilon /= 2


def traced(shape: Polygon, matrix: np.ndarray) -> Area:
    """An outline in image coordinates, simplified, as an area of the world."""
    shape = simplified(shape)
    rings = [_ring(project(matrix, shapely.get_coordinates(ring)[:-1])) for ring in (shape.exterior, *shape.interiors)]
    return Area(rings[0], tuple(rings[1:]))


def _ring(points: np.ndarray) -> Path:
    return tuple((float(x), float(y)) for x, y in points)
