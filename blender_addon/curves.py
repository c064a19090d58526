"""Markings as curve objects: centre lines with their width, and filled rings, to be edited by hand."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.geometry import interpolate_bezier
from shapely.geometry import Polygon

from pavemark.scene import Area, Marking, Stroke

_CHORDS = 12
"""Of a Bézier's piece: a quarter circle is then true to a thousandth of its radius."""


def strokes(name: str, marking: Marking, height: float) -> bpy.types.Curve:
    """The centre lines: a spline a stroke, the point's radius is half the stroke's width in metres."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    for stroke in marking.strokes:
        spline = _spline(curve, stroke.path, height)
        spline.use_cyclic_u = stroke.closed
        spline.points.foreach_set("radius", np.full(len(stroke.path), stroke.width / 2, np.float32))
    return curve


def areas(name: str, marking: Marking, height: float) -> bpy.types.Curve:
    """The filled shapes: outer rings and holes as closed splines, which Blender fills by the even-odd rule."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "2D"
    curve.fill_mode = "BOTH"
    for area in marking.areas:
        for ring in (area.ring, *area.holes):
            _spline(curve, ring, 0.0).use_cyclic_u = True
    return curve


def read_strokes(curve: bpy.types.Curve, world: Matrix | None = None) -> tuple[Stroke, ...]:
    """The strokes of a curve made by `strokes`, as edited since; float32, so 1e-6 m off within 16 m of the origin.

    Parameters
    ----------
    world : Matrix or None
        Of the curve's object, where that was moved, turned or scaled.
    """
    world = world or Matrix()
    splines = [spline for spline in curve.splines if len(_points(spline)) > 1]
    # A point that hands have added has a radius of 1 m by Blender's default, for which no line of paint is meant.
    radii = [_points(spline)[0].radius for spline in splines]
    meant = next((radius for radius in radii if radius != 1.0), 1.0)
    # Where nothing was scaled, roots of sums would lose the last bit.
    scale = 1.0 if world.to_3x3() == Matrix.Identity(3) else world.median_scale
    return tuple(
        Stroke(_path(spline, world), 2 * (meant if radius == 1.0 else radius) * scale, spline.use_cyclic_u)
        for spline, radius in zip(splines, radii, strict=True)
    )


def read_areas(curve: bpy.types.Curve, world: Matrix | None = None) -> tuple[Area, ...]:
    """The areas of a curve made by `areas`, as edited since; a ring within another is its hole."""
    outer: list[tuple[Polygon, list]] = []
    rings = [_path(spline, world or Matrix()) for spline in curve.splines if len(_points(spline)) > 2]
    for ring in sorted(rings, key=lambda ring: -Polygon(ring).area):
        around = next(
            (holes for polygon, holes in outer if polygon.contains(Polygon(ring).representative_point())), None
        )
        if around is None:
            outer.append((Polygon(ring), []))
        else:
            around.append(ring)
    return tuple(Area(tuple(polygon.exterior.coords[:-1]), tuple(holes)) for polygon, holes in outer)


def _spline(curve: bpy.types.Curve, path: tuple, height: float) -> bpy.types.Spline:
    spline = curve.splines.new("POLY")
    spline.points.add(len(path) - 1)
    points = np.ones((len(path), 4), np.float32)
    points[:, :2] = path
    points[:, 2] = height
    spline.points.foreach_set("co", points.ravel())
    return spline


def _points(spline: bpy.types.Spline) -> bpy.types.bpy_prop_collection:
    return spline.bezier_points if spline.type == "BEZIER" else spline.points


def _path(spline: bpy.types.Spline, world: Matrix) -> tuple[tuple[float, float], ...]:
    # The identity would not change a bit, and most curves are never moved as a whole.
    return tuple((x, y) for x, y, _ in (world @ place for place in _places(spline)))


def _places(spline: bpy.types.Spline) -> list[Vector]:
    """The points of a spline, a Bézier's as its chords: what hands draw with Blender's pen."""
    points = _points(spline)
    if spline.type != "BEZIER":
        return [point.co.to_3d() for point in points]
    knots = [*points, points[0]] if spline.use_cyclic_u else list(points)
    places = [knots[0].co]
    for a, b in pairwise(knots):
        places += interpolate_bezier(a.co, a.handle_right, b.handle_left, b.co, _CHORDS + 1)[1:]
    return places[:-1] if spline.use_cyclic_u else places
