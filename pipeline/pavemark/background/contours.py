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
    edges = np.diff(np.pad(markings.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    row, start = np.nonzero(edges == 1)
    _, end = np.nonzero(edges == -1)
    # Regions that touch at a corner only stay apart: a polygon may not meet itself.
    shapes = shapely.get_parts(shapely.union_all(shapely.box(start, row, end, row + 1)))
    return sorted(shapes, key=lambda shape: shape.bounds[1::-1])


def tolerance(shape: Polygon) -> float:
    """Tolerance of Douglas-Peucker for an outline, in its own units."""
    width = 2 * shape.area / shape.length
    return min(ARC_SHARE * shape.exterior.length, WIDTH_SHARE * width)


def simplified(shape: Polygon) -> Polygon:
    """The outline with fewer vertices: valid, none of them further than `tolerance` from where it was."""
    # Normalised, a ring begins at its leftmost point, which is a corner and not a step in the middle of a side.
    shape = shape.normalize()
    largest = epsilon = tolerance(shape)
    while True:
        simple = shape.simplify(epsilon)
        # GEOS drops the point at which a ring begins and ends without regard to what was dropped beside it.
        near = shape.hausdorff_distance(simple) <= largest
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
