"""Where a slot may lie: a found probability of ground, cleaned up, and its regions as polygons."""

from __future__ import annotations

import math

import attrs
import cv2
import numpy as np

from pavemark.background.contours import outlines, traced
from pavemark.ground import Frame
from pavemark.scene import Area

SURE = 0.5
"""Probability from which a pixel is ground."""

SPECK = 0.1
"""Square metres below which a piece of ground is no place, and a hole in it no thing that stands there."""

SLIVER = 0.2
"""Metres: strips of ground narrower than this, between two cars or a car and its shadow's edge, are no place either."""


@attrs.frozen
class Region:
    """A piece of free ground.

    Attributes
    ----------
    polygon : Area
        Its outline with its holes, world metres, simplified as the paper does.
    area_m2 : float
        Square metres before that.
    """

    polygon: Area
    area_m2: float


def free_ground(probability: np.ndarray, markings: np.ndarray, ego: np.ndarray, frame: Frame) -> np.ndarray:
    """Clean up a found probability of ground.

    Holes are judged before pieces: a piece is as large as it is without them.

    Parameters
    ----------
    probability : ndarray (H, W) float32
        Of ground, 0 to 1.
    markings : ndarray (H, W) bool
        Paint lies on the ground, whatever the probability says of it.
    ego : ndarray (H, W) bool
        Where the ego car stands: never ground.
    frame : Frame

    Returns
    -------
    ndarray (H, W) bool
        Ground without holes and pieces of less than SPECK and strips narrower than SLIVER. The ego car counts as
        something that stands there, whatever its size.
    """
    found = ((probability >= SURE) | markings) & ~ego
    least = SPECK * frame.scale**2
    filled = (found | _small(~found, least)) & ~ego
    wide = _without_slivers(filled, max(1, math.floor(SLIVER * frame.scale)))
    return wide & ~_small(wide, least)


def regions(ground: np.ndarray, frame: Frame) -> tuple[Region, ...]:
    """The pieces of free ground as polygons, the largest first.

    Parameters
    ----------
    ground : ndarray (H, W) bool
    frame : Frame

    Returns
    -------
    tuple of Region
        One for each 4-connected piece; Douglas-Peucker at 1 % of the outline's length (`contours.simplified`), mapped
        to the world by Eq. 1.
    """
    shapes = sorted(outlines(ground), key=lambda shape: -shape.area)
    return tuple(Region(traced(shape, frame.matrix), shape.area / frame.scale**2) for shape in shapes)


def _small(mask: np.ndarray, least: float) -> np.ndarray:
    """The 4-connected parts of a mask (H, W) with fewer than `least` pixels."""
    _, label, statistics, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    small = statistics[:, cv2.CC_STAT_AREA] < least
    small[0] = False
    return small[label]


def _without_slivers(ground: np.ndarray, width: int) -> np.ndarray:
    """Ground (H, W) without what is narrower than `width` pixels; what is wider keeps its corners."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    # Beyond the frame's border the ground goes on as it is at the border: a strip that is cut off is not yet narrow.
    padded = cv2.copyMakeBorder(ground.astype(np.uint8), width, width, width, width, cv2.BORDER_REPLICATE)
    core = cv2.morphologyEx(padded, cv2.MORPH_OPEN, disc)
    near = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1)))
    return ((near > 0) & (padded > 0))[width:-width, width:-width]
