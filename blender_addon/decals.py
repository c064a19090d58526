"""Meshes of the decals.

With one sample a pixel, a decal is the set of pixels that the paint touches, as rectangles: a ray through a pixel's
centre meets exactly one of them, and the paint's coverage of the pixel is its alpha. Under many samples the decal is
the outline itself, with hard edges.
"""

from __future__ import annotations

import bpy
import numpy as np
import shapely
from shapely.geometry import MultiPolygon

from pavemark.ground import Frame

LIFT = 0.001
"""Metres between the ground and the first decal, and between decals, so that their order is never in doubt."""


def pixels(name: str, coverage: np.ndarray, frame: Frame, height: float) -> bpy.types.Mesh:
    """The pixels with any coverage, as rectangles: runs along the rows, joined down the columns where they repeat.

    Parameters
    ----------
    coverage : ndarray (H, W)
        Share of each pixel that is painted.
    height : float
        Metres above the ground.
    """
    covered = np.pad(coverage > 0, ((0, 0), (1, 1))).astype(np.int8)
    step = np.diff(covered, axis=1)
    row, left = np.nonzero(step == 1)
    right = np.nonzero(step == -1)[1]
    # Equal runs in consecutive rows become neighbours in this order, and one rectangle.
    order = np.lexsort((row, right, left))
    row, left, right = row[order], left[order], right[order]
    starts = np.append(True, (np.diff(row) != 1) | (np.diff(left) != 0) | (np.diff(right) != 0))[: len(row)]
    ends = np.append(starts[1:], True)[: len(row)]
    corners = np.stack(
        [
            np.stack([left[starts], row[ends] + 1], -1),
            np.stack([right[starts], row[ends] + 1], -1),
            np.stack([right[starts], row[starts]], -1),
            np.stack([left[starts], row[starts]], -1),
        ],
        axis=1,
    )
    return mesh(name, frame.to_world(corners).reshape(-1, 2), 4, height)


def hard(name: str, outline: MultiPolygon, frame: Frame, height: float) -> bpy.types.Mesh:
    """The outline as triangles, as far as it lies in the frame: the ends of a line that goes on for kilometres would
    lose in float32 what tells where its edges cross the picture."""
    width, depth = frame.size
    seen = shapely.intersection(outline, shapely.box(-width / 2, -depth / 2, width / 2, depth / 2))
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(seen))
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    return mesh(name, corners.reshape(-1, 2), 3, height)


def mesh(name: str, corners: np.ndarray, sides: int, height: float | np.ndarray) -> bpy.types.Mesh:
    """A mesh of separate faces from their corners (faces · sides, 2), metres, one height or one for each."""
    made = bpy.data.meshes.new(name)
    faces = len(corners) // sides
    made.vertices.add(len(corners))
    made.vertices.foreach_set("co", np.insert(corners, 2, height, axis=1).astype(np.float32).ravel())
    made.loops.add(len(corners))
    made.loops.foreach_set("vertex_index", np.arange(len(corners), dtype=np.int32))
    made.polygons.add(faces)
    made.polygons.foreach_set("loop_start", np.arange(faces, dtype=np.int32) * sides)
    made.update(calc_edges=False)
    return made
