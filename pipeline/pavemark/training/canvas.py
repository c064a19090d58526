"""What pictures of our own are painted on: a square of ground seen from above, and the noises and shapes laid on it."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np

SIDE = 480
"""Pixels of a view's side."""

_SHIFT = 4
_FINER = 2
_FARTHEST = 30_000.0


def clouds(rng: np.random.Generator, size: float, octaves: int) -> np.ndarray:
    """Smooth fractal noise whose largest features measure `size` pixels: (SIDE, SIDE) float32, unit deviation."""
    total = np.zeros((SIDE, SIDE), np.float32)
    for octave in range(octaves):
        cells = max(2, round(SIDE / size * 2**octave))
        if cells > SIDE:
            break
        # One cell more on each side than are seen: where the noise begins differs from octave to octave.
        grid = rng.standard_normal((cells + 2, cells + 2), np.float32)
        step = SIDE / cells
        enlarge = np.array([[step, 0, -step * rng.random()], [0, step, -step * rng.random()]], np.float32)
        total += 0.6**octave * cv2.warpAffine(grid, enlarge, (SIDE, SIDE), flags=cv2.INTER_CUBIC)
    return total / max(float(total.std()), 1e-6)


def speckle(rng: np.random.Generator) -> np.ndarray:
    """White noise: (SIDE, SIDE) float32, unit deviation."""
    return rng.standard_normal((SIDE, SIDE), np.float32)


def axes(turn: float, centre: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Metres along two perpendicular axes, the first turned by `turn` radians against the rows of pixels."""
    v, u = np.mgrid[0:SIDE, 0:SIDE].astype(np.float32)
    u, v = (u + 0.5 - np.float32(centre[0])) / np.float32(scale), (v + 0.5 - np.float32(centre[1])) / np.float32(scale)
    c, s = np.float32(np.cos(turn)), np.float32(np.sin(turn))
    return c * u + s * v, c * v - s * u


class Stencil:
    """Shapes cut out of a sheet: how much of each pixel they cover.

    Drawn at twice the resolution, so that edges are soft to a quarter of a pixel's area.
    """

    def __init__(self) -> None:
        self._sheet = np.zeros((SIDE * _FINER, SIDE * _FINER), np.uint8)

    def polygon(self, points: np.ndarray) -> None:
        """Cut out a polygon (N, 2), image coordinates in pixels."""
        cv2.fillPoly(self._sheet, [_fixed(points * _FINER)], 255, cv2.LINE_8, _SHIFT)

    def line(self, points: np.ndarray, width: float, closed: bool = False) -> None:
        """Cut out a line of straight pieces (N, 2) with square ends and full corners."""
        ring = np.concatenate([points, points[:1]]) if closed else points
        for start, end in pairwise(ring):
            self.polygon(stroke(start, end, width, closed or len(ring) > 2))

    def picture(self, mask: np.ndarray, matrix: np.ndarray) -> None:
        """Cut out a picture (h, w) uint8, laid down by an affine map (2, 3) from its pixels to the view's."""
        matrix = np.asarray(matrix, np.float64) * _FINER
        laid = cv2.warpAffine(mask, matrix, self._sheet.shape[::-1], flags=cv2.INTER_AREA)
        np.maximum(self._sheet, laid, out=self._sheet)

    def coverage(self) -> np.ndarray:
        """(SIDE, SIDE) float32, 0 to 1."""
        return cv2.resize(self._sheet, (SIDE, SIDE), interpolation=cv2.INTER_AREA).astype(np.float32) / 255


def stroke(start: np.ndarray, end: np.ndarray, width: float, longer: bool = False) -> np.ndarray:
    """The four corners of a straight stroke; `longer` by half its width at both ends, so that corners are full."""
    along = end - start
    along = along / max(float(np.hypot(*along)), 1e-9)
    across = np.array([-along[1], along[0]]) * width / 2
    ends = along * width / 2 if longer else np.zeros(2)
    return np.array([start - ends + across, end + ends + across, end + ends - across, start - ends - across])


def fill(image: np.ndarray, polygon: np.ndarray, colour: np.ndarray) -> None:
    """Paint a polygon (N, 2) on an image in place; a mask takes a number for colour."""
    value = float(colour) if image.ndim == 2 else tuple(float(part) for part in colour)
    cv2.fillPoly(image, [_fixed(polygon)], value, cv2.LINE_8, _SHIFT)


def _fixed(points: np.ndarray) -> np.ndarray:
    # cv2 counts from the centre of the first pixel, and in 16 bits beyond the binary point once clipped.
    return np.rint((np.clip(points, -_FARTHEST, _FARTHEST) - 0.5) * (1 << _SHIFT)).astype(np.int32)
