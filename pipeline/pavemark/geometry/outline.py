"""The outline of a marking: the union of its strokes and areas after the curvature, as one polygon."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon

from pavemark.geometry.elastic import displace, longest_chord
from pavemark.scene import Area, Curvature, Marking, Path

STEP = 0.05
"""Most metres between the points of a path that is to be bent."""

SAGITTA = 1 / 3000
"""Most metres between such a path's chords and the path as it is bent: 0.02 px at 60 px/m."""

MITRE_LIMIT = 5.0
"""Corners sharper than about 23° are cut off, as paint machines do."""

_GRID = 2.0**-36
"""Metres, 1.5e-11. Where sides all but coincide, GEOS is sure of a difference only on a grid; on this one every
coordinate up to 1e5 m is exact in float64."""


# Asked for by the renderer and by the labels, one after the other.
@lru_cache(maxsize=16)
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
    strokes = [(path, stroke) for stroke in marking.strokes if len(path := _distinct(stroke.path, stroke.closed)) > 1]
    lines = bend([LineString(_ring(path) if stroke.closed else path) for path, stroke in strokes], curvature)
    bands = [_band(line, stroke.width / 2) for line, (_, stroke) in zip(lines, strokes, strict=True)]
    return polygons(shapely.union_all([*bands, *(_filled(area, curvature) for area in marking.areas)]))


def polygons(shape: shapely.Geometry) -> MultiPolygon:
    """The areal parts of any geometry, with shells anticlockwise."""
    if isinstance(shape, Polygon):
        parts = [shape]
    else:
        parts = [part for part in shapely.get_parts(shape) if isinstance(part, Polygon)]
    kept = [shapely.geometry.polygon.orient(part) for part in parts if part.area > 0]
    return MultiPolygon(kept)


def bend(shapes: Sequence[shapely.Geometry], curvature: Curvature | None, step: float | None = None) -> np.ndarray:
    """Lines or polygons (world, metres) as they lie after the curvature.

    Returns
    -------
    ndarray (N,) of the same kinds of geometry
        With points every `step` metres, or where None STEP or closer, so that straight sides can bend; the shapes
        themselves without a curvature.
    """
    straight = np.array(shapes, dtype=object)
    if curvature is None:
        return straight
    if step is None:
        step = min(STEP, longest_chord(curvature, SAGITTA))
    return shapely.transform(shapely.segmentize(straight, step), lambda points: displace(curvature, points))


def _band(line: LineString, reach: float) -> shapely.Geometry:
    """What lies within `reach` metres beside a line."""
    # Where a line turns straight back, GEOS divides by zero on the way to a mitre that it then cuts off.
    with np.errstate(divide="ignore", invalid="ignore"):
        band = shapely.buffer(line, reach, cap_style="flat", join_style="mitre", mitre_limit=MITRE_LIMIT)
    if line.is_simple:
        return band
    # It may also lose a side of a line that runs back on itself, but none of a straight piece.
    points = shapely.get_coordinates(line)
    pieces = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    return shapely.union_all([band, *shapely.buffer(pieces, reach, cap_style="flat")])


def _filled(area: Area, curvature: Curvature | None) -> shapely.Geometry:
    """The ring without its holes, each mended by itself: a hole may share a side with the ring, or cross it."""
    rings = (_distinct(ring, closed=True) for ring in (area.ring, *area.holes))
    bent = bend([Polygon(ring) if len(ring) > 2 else Polygon() for ring in rings], curvature)
    shell, *holes = map(polygons, shapely.make_valid(bent))
    return shapely.difference(shell, shapely.union_all(holes), grid_size=_GRID) if holes else shell


def _ring(path: np.ndarray) -> np.ndarray:
    """A closed path; between two points there is nothing to enclose."""
    return np.concatenate([path, path[:1]]) if len(path) > 2 else path


def _distinct(path: Path, closed: bool) -> np.ndarray:
    """A path (N, 2) without points that repeat the one before; the last comes before the first if it is closed."""
    points = np.asarray(path, np.float64).reshape(-1, 2)
    moves = np.any(points != np.roll(points, 1, axis=0), axis=1)
    if not closed:
        moves[0] = True
    return points[moves]
