"""Images at the scale of a detector, which learnt and looks at one scale alone."""

from __future__ import annotations

import cv2
import numpy as np

ALIKE = 0.01
"""Share by which an image's scale may differ from a detector's: less than what a car's own calibration leaves open."""


def size_at(size: tuple[int, int], scale: float, wanted: float) -> tuple[int, int]:
    """Width and height of an image at another scale: whole pixels, at least one; the same where the scales are ALIKE.

    Parameters
    ----------
    size : tuple of int
        Width and height.
    scale, wanted : float
        Pixels per metre that the image has, and that it is to have.
    """
    factor = wanted / scale
    if abs(factor - 1) <= ALIKE:
        return size
    return max(1, round(size[0] * factor)), max(1, round(size[1] * factor))


def scaled(image: np.ndarray, scale: float, wanted: float) -> np.ndarray:
    """An image (H, W, C) uint8 at another scale, of the size that `size_at` tells; itself where that is its own."""
    height, width = image.shape[:2]
    size = size_at((width, height), scale, wanted)
    if size == (width, height):
        return image
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if wanted < scale else cv2.INTER_LINEAR)
