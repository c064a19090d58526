"""Markings found without a mask: bright strokes of a line's width, with darker ground on both sides.

A classical detector. For every direction the image is turned so that strokes of that direction lie along the rows;
there the mean over a stretch of stroke is compared with the ground above and below it. The stretch averages out the
texture of paving, the lesser of both sides rejects the steps of shadows and camera seams.
"""

from __future__ import annotations

import cv2
import numpy as np

from pavemark.colour import LINEAR
from pavemark.ground import Frame

FINEST = 60.0
"""Pixels per metre worked at; a finer image is reduced, as lines are 5 pixels wide there already."""

WIDTHS = (0.08, 0.12, 0.18, 0.26)
"""Widths of stroke looked for, in metres."""

GAP, FLANK = 0.04, 0.12
"""Metres between the stroke and the ground compared with it, and the width of that ground."""

STRETCH, DIRECTIONS = 0.8, 16
"""Metres of stroke averaged for the decision that there is one, and the number of directions tried."""

SHORT_STRETCH, SHORT_DIRECTIONS = 0.25, 8
"""The same for the stroke's shape, which ends, bends and meets others."""

CONTRAST, PER_NOISE = 0.16, 1.0
"""Least log ratio of paint to ground, and what is asked in addition per unit of the texture's own contrast."""

SHAPE = 0.35
"""Share of the contrast nearby at which a pixel is paint."""

SURE = 0.3
"""Share of a marking's pixels that must pass the contrast over the whole stretch."""

SLIM, SHORTEST = 3.0, 0.5
"""Least length of a marking in its own widths and in metres."""

EDGE = 0.08
"""Metres from a stroke's core within which its edge lies."""

YELLOW = 0.3
"""Weight of yellowness beside brightness: worn yellow is hardly brighter than concrete, but less blue."""

_UNSEEN = -9.0
# Log light below this linear level, about 8-bit level 25, is camera noise.
_FLOOR = 0.01


def find_markings(image: np.ndarray, ground: np.ndarray, frame: Frame) -> np.ndarray:
    """Find white and yellow lines.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display sRGB.
    ground : ndarray (H, W) bool
        Where to look; the rest is neither marking nor compared with.
    frame : Frame

    Returns
    -------
    ndarray (H, W) bool
        Areas wider than about 0.3 m (bars of a zebra crossing) are not found; glossy reflections and the bodywork of
        parked cars can be taken for paint. A mask by hand, or by a trained network, is better.
    """
    height, width = ground.shape
    reduction = min(1.0, FINEST / frame.scale)
    size = (max(8, round(width * reduction)), max(8, round(height * reduction)))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    seen = (cv2.resize(ground.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.99).astype(np.float32)
    strokes = _strokes(cv2.GaussianBlur(_brightness(small), (0, 0), 0.8), seen, frame.scale * reduction)
    found = cv2.resize(strokes.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR) > 0.5
    return found & ground


def _brightness(image: np.ndarray) -> np.ndarray:
    """Log of red and green light, raised where blue lacks: (H, W) float32."""
    light = LINEAR.astype(np.float32)[image] + np.float32(_FLOOR)
    warm = np.log((light[..., 0] + light[..., 1]) / 2)
    return warm + np.float32(YELLOW) * (warm - np.log(light[..., 2]))


def _strokes(brightness: np.ndarray, seen: np.ndarray, scale: float) -> np.ndarray:
    """Which pixels (H, W) belong to a stroke, at `scale` pixels per metre."""
    contrast = _contrast(brightness, seen, STRETCH * scale, DIRECTIONS, scale)
    shape = _contrast(brightness, seen, SHORT_STRETCH * scale, SHORT_DIRECTIONS, scale)
    speckle = np.abs(brightness - cv2.medianBlur(brightness, 5))
    # 1.25 makes a standard deviation of a mean absolute one.
    noise = 1.25 * cv2.GaussianBlur(speckle, (0, 0), 0.4 * scale)
    sure = contrast > CONTRAST + PER_NOISE * noise
    reach = 2 * int(0.15 * scale) + 1
    nearby = cv2.dilate(np.where(sure, contrast, 0).astype(np.float32), np.ones((reach, reach), np.uint8))
    painted = (nearby > 0) & (shape > SHAPE * nearby) & ((contrast > 0.4 * SHAPE * nearby) | sure)

    count, label, statistics, _ = cv2.connectedComponentsWithStats(painted.astype(np.uint8), connectivity=8)
    support = np.bincount(label[sure], minlength=count)
    kept = np.zeros(count, bool)
    for number in range(1, count):
        x, y, width, height, area = statistics[number]
        if support[number] < SURE * area:
            continue
        part = (label[y : y + height, x : x + width] == number).astype(np.uint8)
        inside = cv2.copyMakeBorder(part, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
        across = 2 * cv2.distanceTransform(inside, cv2.DIST_L2, 3).max()
        along = area / across
        kept[number] = along >= SLIM * across and along >= SHORTEST * scale
    return _to_the_edge(kept[label], brightness, seen, scale)


def _to_the_edge(strokes: np.ndarray, brightness: np.ndarray, seen: np.ndarray, scale: float) -> np.ndarray:
    """The strokes, found by their cores, grown to where the light is half-way between paint and ground nearby."""
    core = strokes.astype(np.float32)
    reach = 2 * max(1, round(EDGE * scale)) + 1
    around = cv2.dilate(core, np.ones((reach, reach), np.uint8))
    paint, ground = (
        cv2.GaussianBlur(brightness * part, (0, 0), 2 * EDGE * scale)
        / np.maximum(cv2.GaussianBlur(part, (0, 0), 2 * EDGE * scale), 1e-6)
        for part in (core, seen * (1 - around))
    )
    return (around > 0) & (brightness > (paint + ground) / 2)


def _contrast(brightness: np.ndarray, seen: np.ndarray, stretch: float, directions: int, scale: float) -> np.ndarray:
    """How much brighter than the ground on both sides the best stroke through each pixel is, (H, W) float32."""
    height, width = brightness.shape
    side = int(np.ceil(np.hypot(height, width))) + 2
    best = np.full((height, width), _UNSEEN, np.float32)
    for degrees in np.arange(directions) * (180 / directions):
        turn = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1.0)
        turn[:, 2] += ((side - width) / 2, (side - height) / 2)
        turned = cv2.warpAffine(
            brightness, turn, (side, side), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101
        )
        weight = cv2.warpAffine(seen, turn, (side, side), flags=cv2.INTER_LINEAR)
        contrast = _contrast_along_rows(turned, weight, stretch, scale)
        back = cv2.warpAffine(
            contrast,
            turn,
            (width, height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=_UNSEEN,
        )
        np.maximum(best, back, out=best)
    return best


def _contrast_along_rows(brightness: np.ndarray, weight: np.ndarray, stretch: float, scale: float) -> np.ndarray:
    length, flank = max(1, round(stretch)), max(1, round(FLANK * scale))
    total, count = (cv2.blur(array, (length, 1)) for array in (brightness * weight, weight))
    total_flank, count_flank = (cv2.blur(array, (1, flank)) for array in (total, count))
    mean_flank = total_flank / np.maximum(count_flank, 1e-6)
    best = np.full(brightness.shape, _UNSEEN, np.float32)
    for stroke in WIDTHS:
        core = max(1, round(0.7 * stroke * scale))
        total_core, count_core = (cv2.blur(array, (1, core)) for array in (total, count))
        offset = round((stroke / 2 + GAP + FLANK / 2) * scale)
        sides = [np.roll(mean_flank, shift, 0) for shift in (offset, -offset)]
        counts = [np.roll(count_flank, shift, 0) for shift in (offset, -offset)]
        contrast = total_core / np.maximum(count_core, 1e-6) - np.maximum(*sides)
        # A third of each window must be seen for its mean to count.
        contrast[np.minimum.reduce([count_core, *counts]) < 0.3] = _UNSEEN
        np.maximum(best, contrast, out=best)
    return best
