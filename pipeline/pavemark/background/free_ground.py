"""Where a slot may lie: a found probability of ground, cleaned up, and its regions as polygons."""

from __future__ import annotations

import math

import attrs
import cv2
import numpy as np

from pavemark.background.contours import outlines, traced
from pavemark.ground import Frame
from pavemark.scene import Area

IMPROBABLE, DOUBTED = 0.4, 0.8
"""Probabilities of ground below which something stands there, and below which it may reach as far: chosen on the demo
images, whose ground is known. One threshold either overlooks half of every car or takes a seam for a wall."""

SPECK = 0.1
"""Square metres below which a piece of ground is no place, and what is improbable no thing that stands there."""

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

    A thing is where ground is improbable on more than a speck, and reaches as far around as ground is doubted. What is
    doubted elsewhere is ground. Things are judged before pieces: a piece is as large as it is without holes.

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
        Ground without things and pieces of less than SPECK and strips narrower than SLIVER. The ego car counts as
        something that stands there, whatever its size.
    """
    least = SPECK * frame.scale**2
    things = _parts((probability < DOUBTED) & ~markings & ~ego, probability < IMPROBABLE, least)
    wide = _without_slivers(~things & ~ego, max(1, math.floor(SLIVER * frame.scale)))
    return _parts(wide, wide, least)


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


def _parts(mask: np.ndarray, core: np.ndarray, least: float) -> np.ndarray:
    """The 4-connected parts of a mask (H, W) that hold at least so many pixels of a core."""
    count, label = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    kept = np.bincount(label[mask & core], minlength=count) >= least
    kept[0] = False
    return kept[label]


def _without_slivers(ground: np.ndarray, width: int) -> np.ndarray:
    """Ground (H, W) without what is narrower than `width` pixels; what is wider keeps its corners."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
    # Beyond the frame's border the ground goes on as it is at the border: a strip that is cut off is not yet narrow.
    padded = cv2.copyMakeBorder(ground.astype(np.uint8), width, width, width, width, cv2.BORDER_REPLICATE)
    core = cv2.morphologyEx(padded, cv2.MORPH_OPEN, disc)
    near = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1)))
    return ((near > 0) & (padded > 0))[width:-width, width:-width]
