"""The outline of a marking: the union of its strokes and areas after the curvature, as one polygon."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon

from pavemark.geometry.elastic import displace
from pavemark.scene import Area, Curvature, Marking, Path, Stroke

STEP = 0.05
"""Metres between the points of a path that is to be bent: the chord's sagitta stays below 0.02 px at 60 px/m."""

MITRE_LIMIT = 5.0
"""Corners sharper than about 23° are cut off, as paint machines do."""


def outline(marking: Marking, curvature: Curvature | None) -> MultiPolygon:
    """The painted region of a marking on the ground.

    Parameters
    ----------
    marking : Marking
    curvature : Curvature or None
        Bends centre lines and rings; stroke widths stay.

    Returns
    -------
    MultiPolygon
        World, metres; valid, shells anticlockwise and holes clockwise; empty for paint without area.
    """
    parts = [_stroked(stroke, curvature) for stroke in marking.strokes]
    parts += [_filled(area, curvature) for area in marking.areas]
    return polygons(shapely.union_all(parts))


def polygons(shape: shapely.Geometry) -> MultiPolygon:
    """The areal parts of any geometry, with shells anticlockwise."""
    if isinstance(shape, Polygon):
        parts = [shape]
    else:
        parts = [part for part in shapely.get_parts(shape) if isinstance(part, Polygon)]
    kept = [shapely.geometry.polygon.orient(part) for part in parts if part.area > 0]
    return MultiPolygon(kept)


def bend(path: Path | np.ndarray, curvature: Curvature | None, closed: bool = False) -> np.ndarray:
    """A path as it lies after the curvature.

    Returns
    -------
    ndarray (N, 2), float64
        Metres. Points are added every STEP so that the path can bend; a closed path repeats its first point.
    """
    points = np.asarray(path, np.float64)
    if closed:
        points = np.concatenate([points, points[:1]])
    if curvature is None:
        return points
    return displace(curvature, shapely.get_coordinates(shapely.segmentize(shapely.linestrings(points), STEP)))


def _stroked(stroke: Stroke, curvature: Curvature | None) -> shapely.Geometry:
    path = _distinct(stroke.path, stroke.closed)
    if len(path) < 2:
        return Polygon()
    line = shapely.linestrings(bend(path, curvature, stroke.closed))
    return shapely.buffer(line, stroke.width / 2, cap_style="flat", join_style="mitre", mitre_limit=MITRE_LIMIT)


def _filled(area: Area, curvature: Curvature | None) -> shapely.Geometry:
    shell, *holes = (_distinct(ring, closed=True) for ring in (area.ring, *area.holes))
    if len(shell) < 3:
        return Polygon()
    bent = [bend(ring, curvature, closed=True) for ring in (shell, *(hole for hole in holes if len(hole) > 2))]
    return shapely.make_valid(Polygon(bent[0], bent[1:]))


def _distinct(path: Path, closed: bool) -> np.ndarray:
    """A path (N, 2) without points that repeat the one before; the last comes before the first if it is closed."""
    points = np.asarray(path, np.float64).reshape(-1, 2)
    moves = np.any(points != np.roll(points, 1, axis=0), axis=1)
    if not closed:
        moves[0] = True
    return points[moves]
