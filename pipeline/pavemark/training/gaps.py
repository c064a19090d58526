"""Ground with gaps, whose truth is known: what the inpainter trains on.

A gap is shaped as the widened strokes of markings are, and lies on bare ground of a view of our own. What is no ground
is replaced as the inpainting backends do it, so no car is ever seen.
"""

from __future__ import annotations

import itertools

import attrs
import cv2
import numpy as np

from pavemark.background.inpainting.source import neutral
from pavemark.background.plates import SOFT_EDGE
from pavemark.colour import quantise
from pavemark.training.canvas import SIDE
from pavemark.training.pool import GROUND, MARKING

SCALE = 48.0
"""Pixels per metre of the views, about; a patch is a view magnified by 0.5 to 1.4."""

LEAST = 0.01
"""Share of a patch that has to be gap with a truth."""

_TRIES = 12


@attrs.frozen(eq=False)
class Patch:
    """A piece of a view with gaps.

    Attributes
    ----------
    image : ndarray (S, S, 3) uint8
        The truth, display sRGB. Where there is no ground it shows the nearest that is known.
    gap : ndarray (S, S) bool
        What is to be filled.
    judged : ndarray (S, S) bool
        The gap but for the view's own markings: what lies below those nobody knows.
    """

    image: np.ndarray
    gap: np.ndarray
    judged: np.ndarray


def sample(rng: np.random.Generator, pool: np.ndarray, side: int) -> Patch:
    """Draw a patch.

    Parameters
    ----------
    rng : Generator
    pool : ndarray (N, SIDE, SIDE, 4) uint8
        As `pavemark.training.pool.drawn` returns it, painted or bare.
    side : int
        Pixels a side of the patch, at most half of SIDE.
    """
    # Some views are nearly all car or wall: after so many tries the patch with the most gap is taken.
    best = None
    for _ in range(_TRIES):
        magnified = float(np.exp(rng.uniform(np.log(0.5), np.log(1.4))))
        piece = _piece(rng, pool, side, magnified)
        ground, marking = piece[..., 3] & GROUND > 0, piece[..., 3] & MARKING > 0
        radius = max(2, round(SOFT_EDGE * SCALE * magnified))
        own = cv2.dilate(marking.astype(np.uint8), np.ones((2 * radius + 1, 2 * radius + 1), np.uint8)) > 0
        strokes = shapes(rng, side, magnified)
        judged = strokes & ground & ~own
        if best is None or judged.sum() > best[3].sum():
            best = piece, ground, own, judged, strokes
        if judged.mean() > LEAST and ground.mean() > 0.7:
            break
    piece, ground, own, judged, strokes = best
    gap = (strokes | own) & ground
    image = neutral(taken(rng, piece[..., :3]), gap, ~ground) if (ground & ~gap).any() else piece[..., :3]
    return Patch(image, gap, judged)


def _piece(rng: np.random.Generator, pool: np.ndarray, side: int, magnified: float) -> np.ndarray:
    """A square of a view (side, side, 4), magnified, flipped, turned by quarters."""
    view = pool[int(rng.integers(len(pool)))]
    length = min(SIDE, round(side / magnified))
    top, left = rng.integers(0, SIDE - length + 1, 2)
    square = np.ascontiguousarray(view[top : top + length, left : left + length])
    how = cv2.INTER_AREA if magnified < 1 else cv2.INTER_LINEAR
    colour = cv2.resize(square[..., :3], (side, side), interpolation=how)
    bits = cv2.resize(square[..., 3], (side, side), interpolation=cv2.INTER_NEAREST)
    piece = np.rot90(np.dstack([colour, bits]), int(rng.integers(4)))
    return np.ascontiguousarray(piece[:, ::-1] if rng.random() < 0.5 else piece)


def taken(rng: np.random.Generator, image: np.ndarray) -> np.ndarray:
    """The image (H, W, 3) uint8 as another camera would have taken it: gains, tone, blur, noise, JPEG."""
    x = image.astype(np.float32) / 255
    x = x ** np.float32(np.exp(rng.normal(0, 0.25)))
    x = x * np.exp(rng.normal(0, 0.25) + rng.normal(0, 0.05, 3)).astype(np.float32)
    if rng.random() < 0.4:
        middle = x.mean((0, 1))
        x = middle + (x - middle) * np.float32(np.exp(rng.normal(0, 0.35)))
    if rng.random() < 0.3:
        x = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.4, 1.4))
    if rng.random() < 0.3:
        x = x + rng.normal(0, rng.uniform(0.003, 0.02), (*x.shape[:2], 1)).astype(np.float32)
    x = quantise(x * 255)
    if rng.random() < 0.5:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(50, 96))]
        x = cv2.imdecode(cv2.imencode(".jpg", x[..., ::-1], quality)[1], cv2.IMREAD_COLOR)[..., ::-1]
    return np.ascontiguousarray(x)


def shapes(rng: np.random.Generator, side: int, magnified: float) -> np.ndarray:
    """Draw gaps (side, side) bool: rows of lines, crossings, zebras, figures, arcs, as wide as widened markings are."""
    sheet = np.zeros((side, side), np.uint8)
    kinds = (_comb, _comb, _line, _line, _zebra, _figure, _arc, _block)
    for _ in range(int(rng.integers(1, 3))):
        width = float(np.exp(rng.uniform(np.log(9), np.log(28)))) * magnified**0.7
        kinds[int(rng.integers(len(kinds)))](rng, sheet, max(4.0, width))
    return sheet > 0


def _axes(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    angle = rng.integers(4) * np.pi / 2 + rng.normal(0, 0.06) if rng.random() < 0.65 else rng.uniform(0, 2 * np.pi)
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, np.array([-along[1], along[0]])


def _stroke(sheet: np.ndarray, start: np.ndarray, end: np.ndarray, width: float) -> None:
    along = end - start
    across = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-6) * width / 2
    corners = np.array([start + across, end + across, end - across, start - across])
    cv2.fillPoly(sheet, [np.rint(corners).astype(np.int32)], 1)


def _line(rng, sheet, width):
    side = len(sheet)
    along, _ = _axes(rng)
    middle, length = rng.uniform(0.1, 0.9, 2) * side, rng.uniform(0.2, 1.5) * side
    _stroke(sheet, middle - along * length / 2, middle + along * length / 2, width)


def _comb(rng, sheet, width):
    side = len(sheet)
    along, across = _axes(rng)
    origin = rng.uniform(0.1, 0.9, 2) * side
    step, depth = rng.uniform(3, 9) * width, rng.uniform(0.2, 1.2) * side
    if rng.random() < 0.7:
        _stroke(sheet, origin - along * side * 1.5, origin + along * side * 1.5, width)
    for number in range(-int(side / step) - 1, int(side / step) + 2):
        foot = origin + along * number * step
        _stroke(sheet, foot, foot + across * depth, width)


def _zebra(rng, sheet, width):
    along, across = _axes(rng)
    origin, depth = rng.uniform(0.1, 0.9, 2) * len(sheet), rng.uniform(0.2, 0.8) * len(sheet)
    step = width * rng.uniform(1.6, 2.5)
    for number in range(int(rng.integers(2, 7))):
        foot = origin + along * number * step
        _stroke(sheet, foot, foot + across * depth, width)


def _figure(rng, sheet, width):
    points = rng.uniform(0.15, 0.85, 2) * len(sheet) + rng.normal(0, 2.5 * width, (int(rng.integers(3, 7)), 2))
    for start, end in itertools.pairwise(points):
        _stroke(sheet, start, end, width * 0.7)


def _arc(rng, sheet, width):
    middle, radius = rng.uniform(-0.2, 1.2, 2) * len(sheet), rng.uniform(0.15, 0.9) * len(sheet)
    start, span = rng.uniform(0, 360), rng.uniform(60, 360)
    centre = tuple(int(x) for x in np.rint(middle))
    cv2.ellipse(sheet, centre, (round(radius), round(radius)), 0, start, start + span, 1, max(1, round(width)))


def _block(rng, sheet, width):
    along, _ = _axes(rng)
    middle = rng.uniform(0.1, 0.9, 2) * len(sheet)
    long, wide = rng.uniform(1.0, 3.5, 2) * width
    _stroke(sheet, middle - along * long / 2, middle + along * long / 2, wide)
