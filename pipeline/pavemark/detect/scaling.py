"""Images at the scale of a detector, which learnt and looks at one scale alone."""

from __future__ import annotations

import cv2
import numpy as np

ALIKE = 0.01
"""Share by which an image's scale may differ from a detector's: less than what a car's own calibration leaves open."""


def scaled(image: np.ndarray, scale: float, wanted: float) -> np.ndarray:
    """An image at another scale.

    Parameters
    ----------
    image : ndarray (H, W, C) uint8
    scale, wanted : float
        Pixels per metre that the image has, and that it is to have.

    Returns
    -------
    ndarray uint8
        The image itself where the two differ by no more than ALIKE. Its sides are whole pixels, at least one: how far
        it was scaled is the ratio of the sides.
    """
    factor = wanted / scale
    if abs(factor - 1) <= ALIKE:
        return image
    height, width = image.shape[:2]
    size = max(1, round(width * factor)), max(1, round(height * factor))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR)
