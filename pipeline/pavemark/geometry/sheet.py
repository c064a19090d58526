"""What a marking's paint has to know of its geometry, pixel by pixel: coverage, distance to the edge, tyres."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
import shapely

from pavemark.geometry.coverage import coverage
from pavemark.ground import Frame
from pavemark.scene import Tyres

COVERAGE, EDGE, TYRES = 0, 1, 2
"""The channels of a sheet."""


def sheet(shape: shapely.Geometry, frame: Frame, tyres: Tyres | None, edges: bool) -> np.ndarray:
    """The sheet of one marking.

    Parameters
    ----------
    shape : MultiPolygon
        The marking's outline, world metres.
    frame : Frame
    tyres : Tyres or None
        Tracks to be marked where wheels wear the paint.
    edges : bool
        Whether the distance to the outline is called for.

    Returns
    -------
    ndarray (H, W, 4), float32
        Share of the pixel covered; metres from the pixel's centre to the outline, inside (0 without `edges`);
        exposure to tyres, 0 to 1; unused.
    """
    result = np.zeros((frame.height, frame.width, 4), np.float32)
    result[..., COVERAGE] = coverage(shape, frame)
    if edges:
        result[..., EDGE] = _edge_distance(result[..., COVERAGE], frame)
    if tyres is not None:
        result[..., TYRES] = _exposure(tyres, frame)
    return result


def _edge_distance(share: np.ndarray, frame: Frame) -> np.ndarray:
    """Metres to the outline, within a third of a pixel: to the nearest pixel that is less than half covered."""
    inside = (share >= 0.5).astype(np.uint8)
    # Beyond the frame's border paint goes on as it is at the border, else wear would follow the frame.
    padded = cv2.copyMakeBorder(inside, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_5)[1:-1, 1:-1]
    return np.maximum(distance - 0.5, 0) / frame.scale


# The markings of a scene share its tyres.
@lru_cache(maxsize=2)
def _exposure(tyres: Tyres, frame: Frame) -> np.ndarray:
    """1 in the middle of a track, fading over its border."""
    lines = [shapely.linestrings(track) for track in tyres.tracks if len(track) > 1]
    bands = shapely.union_all([shapely.buffer(line, tyres.width / 2, cap_style="flat") for line in lines])
    parts = [part for part in shapely.get_parts(bands) if part.geom_type == "Polygon"]
    area = shapely.MultiPolygon([shapely.geometry.polygon.orient(part) for part in parts])
    sigma = tyres.width / 4 * frame.scale
    return cv2.GaussianBlur(coverage(area, frame), (0, 0), sigma) if parts else np.zeros((frame.height, frame.width))
