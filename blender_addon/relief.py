"""Meshes of paint that stands up from the ground."""

from __future__ import annotations

import bpy
import numpy as np
import shapely

from pavemark.ground import Frame
from pavemark.light import Relief

from .decals import mesh

BEYOND = 1.0
"""Metres beyond the frame from which raised paint may still cast a shadow into it."""


def raised(name: str, shape: shapely.Geometry, frame: Frame, relief: Relief) -> bpy.types.Mesh | None:
    """Paint with a slope along its outline, as triangles; None where none is near the frame."""
    width, depth = (side / 2 + BEYOND for side in frame.size)
    near = shapely.intersection(shape, shapely.box(-width, -depth, width, depth))
    flat = near.buffer(-relief.bevel)
    triangles = [*_triangles(flat), *_triangles(near.difference(flat))]
    if not triangles:
        return None
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3].reshape(-1, 2)
    inwards = shapely.distance(shapely.boundary(near), shapely.points(corners))
    return mesh(name, corners, 3, relief.height * np.minimum(inwards / relief.bevel, 1.0))


def _triangles(shape: shapely.Geometry) -> np.ndarray:
    polygons = shapely.MultiPolygon([part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"])
    return shapely.get_parts(shapely.constrained_delaunay_triangles(polygons))
