"""How much brighter than its ground a real marking is: reflectance ratios in linear light."""

from __future__ import annotations

import cv2
import numpy as np

from pavemark.colour import LINEAR, lit_grey
from pavemark.ground import Frame
from pavemark.scene import RGB

LEAST_AREA = 0.03
"""Square metres of paint below which a marking tells nothing."""

BESIDE = 0.25
"""Metres beyond the marking's soft edge where the ground is measured."""

DARKEST, BRIGHTEST = 12, 250
"""8-bit levels between which a camera's answer still follows the light."""


def reflectance_ratios(
    image: np.ndarray, markings: np.ndarray, hole: np.ndarray, ground: np.ndarray, frame: Frame
) -> tuple[RGB, ...]:
    """Measure the former markings of an image.

    Every pixel of paint is compared with the ground nearby, so that a marking that runs from light into shadow is not
    misjudged; the median over the marking's pixels is its ratio.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display sRGB, as taken.
    markings, hole, ground : ndarray (H, W) bool
        The mask; the mask with its soft edge, as inpainted; where paint may lie.
    frame : Frame

    Returns
    -------
    tuple of RGB
        Per channel, one for each 8-connected marking that is large enough and neither saturated nor lost in the dark,
        in the order of their uppermost, then leftmost pixel.
    """
    linear = LINEAR.astype(np.float32)[image]
    usable = ground & (image.max(2) < BRIGHTEST)
    lit = usable & (image.min(2) > DARKEST)
    paint = markings & usable
    # Gaussian-weighted mean of the bare ground around each pixel, of a reach that clears the marking's soft edge.
    bare = (lit & ~hole).astype(np.float32)
    reach = BESIDE * frame.scale
    nearby = cv2.GaussianBlur(bare, (0, 0), reach)
    beside = cv2.GaussianBlur(linear * bare[..., None], (0, 0), reach)
    # A hundredth of the weight: fewer ground pixels than that are too far off to stand for the ground here.
    known = paint & (nearby > 0.01)
    ratio = np.zeros_like(linear)
    ratio[known] = linear[known] / lit_grey(beside[known] / nearby[known, None])

    _, label, statistics, _ = cv2.connectedComponentsWithStats(markings.astype(np.uint8), connectivity=8)
    core = cv2.erode(markings.astype(np.uint8), np.ones((3, 3), np.uint8), borderType=cv2.BORDER_REPLICATE) > 0
    found = []
    for number in range(1, len(statistics)):
        x, y, width, height, area = statistics[number]
        if area < LEAST_AREA * frame.scale**2:
            continue
        box = np.s_[y : y + height, x : x + width]
        inside = label[box] == number
        # The core is free of the soft edge, where the mask is wide enough to have one.
        measured = inside & known[box] & core[box]
        if measured.sum() < 0.2 * area:
            measured = inside & known[box]
        if measured.sum() >= 0.2 * area:
            found.append(tuple(float(value) for value in np.median(ratio[box][measured], 0)))
    return tuple(found)
