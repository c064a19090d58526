"""Brightness: the illumination channel times a factor (the paper's brightness domain)."""

from __future__ import annotations

import numpy as np

from pavemark.colour import within_gamut
from pavemark.scene import Brightness


def apply(image: np.ndarray, brightness: Brightness) -> np.ndarray:
    """Multiply the V of HSV in display space; hue and saturation stay.

    V is the largest channel, so with H and S held it scales all three alike, up to where the largest reaches 255.

    Parameters
    ----------
    image : ndarray (H, W, 3) float32
        Display levels 0 to 255.
    brightness : Brightness

    Returns
    -------
    ndarray (H, W, 3) float32
        Display levels 0 to 255, not rounded.
    """
    return within_gamut(image * np.float32(brightness.factor), np.float32(255))
