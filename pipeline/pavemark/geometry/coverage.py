"""Exact area coverage: how much of each pixel a polygon covers.

The boundary integral over each pixel is computed edge by edge (Green's theorem) and summed along the rows, so every
case, line ends, joins, slivers narrower than a pixel, is exact to rounding, in time proportional to the outline.
"""

from __future__ import annotations

import numpy as np
import shapely

from pavemark.ground import Frame

_ROUNDING = 1e-9


def coverage(shape: shapely.Geometry, frame: Frame) -> np.ndarray:
    """Share of each pixel that a polygon covers.

    Parameters
    ----------
    shape : Polygon or MultiPolygon
        World, metres; shells anticlockwise, holes clockwise, as `outline` gives them.
    frame : Frame

    Returns
    -------
    ndarray (H, W), float64
        0 to 1.
    """
    result = np.zeros((frame.height, frame.width))
    rings = shapely.get_rings(shapely.get_parts(shape))
    if len(rings) == 0:
        return result
    coordinates, ring = shapely.get_coordinates(rings, return_index=True)
    uv = frame.to_image(coordinates)
    inner = ring[1:] == ring[:-1]
    start, end = uv[:-1][inner], uv[1:][inner]

    box_low = np.floor(uv.min(0)).astype(np.int64)
    box_high = np.ceil(uv.max(0)).astype(np.int64)
    u0, v0 = np.maximum(box_low, 0)
    u1, v1 = np.minimum(box_high, (frame.width, frame.height))
    if u1 <= u0 or v1 <= v0:
        return result
    window = _accumulate(start - (u0, v0), end - (u0, v0), u1 - u0, v1 - v0)
    result[v0:v1, u0:u1] = window
    return result


def _accumulate(start: np.ndarray, end: np.ndarray, width: int, height: int) -> np.ndarray:
    """Coverage (height, width) from directed edges (N, 2) in window pixels.

    A piece of edge within one pixel, of height dv and mean position u, covers dv·(1 - u) of its own pixel and dv of
    every pixel to its right. Left of the window a piece counts whole; above, below and right of it, not at all.
    """
    piece_start, piece_end = _pieces(start, end, width, height)
    dv = piece_end[:, 1] - piece_start[:, 1]
    mean = (piece_start + piece_end) / 2
    row = np.floor(mean[:, 1]).astype(np.int64)
    column = np.floor(mean[:, 0]).astype(np.int64)
    counted = (row >= 0) & (row < height) & (column < width) & (dv != 0)
    row, column, dv, u = row[counted], column[counted], dv[counted], mean[counted, 0]
    left = column < 0
    own = np.where(left, dv, dv * (1 - (u - column)))
    cell = row * (width + 1) + np.where(left, 0, column)
    # One column more than the window takes what lies to the right of its last pixel.
    change = np.bincount(np.concatenate([cell, cell + 1]), np.concatenate([own, dv - own]), height * (width + 1))
    total = change[: height * (width + 1)].reshape(height, width + 1)[:, :width]
    np.cumsum(total, axis=1, out=total)
    # Rounding along a row leaves some 1e-16 a piece behind the shape; such pixels are outside, or inside.
    total[total < _ROUNDING] = 0.0
    total[total > 1 - _ROUNDING] = 1.0
    return total


def _pieces(start: np.ndarray, end: np.ndarray, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges cut at every grid line of the window, so that each piece lies within one pixel."""
    cuts = [np.zeros(len(start)), np.ones(len(start))]
    edges = [np.arange(len(start))] * 2
    delta = end - start
    for axis, size in ((0, width), (1, height)):
        low = np.clip(np.ceil(np.minimum(start[:, axis], end[:, axis])), 0, size + 1).astype(np.int64)
        high = np.clip(np.floor(np.maximum(start[:, axis], end[:, axis])), -1, size).astype(np.int64)
        count = np.maximum(high - low + 1, 0)
        edge = np.repeat(np.arange(len(start)), count)
        line = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(low, count)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (line - start[edge, axis]) / delta[edge, axis]
        crossed = np.isfinite(t) & (t > 0) & (t < 1)
        cuts.append(t[crossed])
        edges.append(edge[crossed])
    t, edge = np.concatenate(cuts), np.concatenate(edges)
    # One key, edges two apart as t ends at 1, sorts faster than two; stable, so that ties fall the same everywhere.
    order = np.argsort(2 * edge + t, kind="stable")
    t, edge = t[order], edge[order]
    same = edge[1:] == edge[:-1]
    first, last, of = t[:-1][same], t[1:][same], edge[1:][same]
    return start[of] + delta[of] * first[:, None], start[of] + delta[of] * last[:, None]
