"""sRGB both ways (IEC 61966-2-1). Display values are 8-bit levels 0 to 255, as float where they are not yet rounded."""

from __future__ import annotations

import numpy as np

CAST = 1.3
"""How far a channel of a grey ground may leave its luminance by the colour of the light."""


def to_linear(levels: np.ndarray) -> np.ndarray:
    """Linear light (..., float64), 0 to 1, of display levels (...), 0 to 255, whole or not."""
    share = np.asarray(levels) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def to_display(linear: np.ndarray) -> np.ndarray:
    """Display levels 0 to 255, not rounded, of linear light (..., float) from 0 to 1.

    Examples
    --------
    >>> import numpy as np
    >>> to_display(to_linear(np.array([0, 1, 10, 118, 255], np.uint8))).round(9)
    array([  0.,   1.,  10., 118., 255.])
    """
    curve = 1.055 * np.power(np.maximum(linear, 0.0031308), 1 / 2.4) - 0.055
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, curve)


def within_gamut(colour: np.ndarray, most: float) -> np.ndarray:
    """Colours (..., 3) scaled down, hue kept, until no channel exceeds `most`; negative light is none."""
    colour = np.maximum(colour, 0.0)
    peak = np.maximum(np.maximum(colour[..., 0], colour[..., 1]), colour[..., 2])
    return colour * (most / np.maximum(peak, most))[..., None]


def lit_grey(ground: np.ndarray) -> np.ndarray:
    """What a grey ground of the same luminance would send back in the same light.

    Paint hides a hue of the ground, a green floor or red brick, but not that of the light. Which is which no picture
    tells; channels within CAST of the luminance are put down to the light, and a stronger hue is cut down to that, in
    proportion.

    Parameters
    ----------
    ground : ndarray (..., 3) float
        Linear light, above 0.

    Returns
    -------
    ndarray (..., 3) float
        Linear light.
    """
    luminance = (ground @ LUMINANCE.astype(ground.dtype))[..., None]
    tint = np.log(ground / luminance)
    most = np.log(CAST)
    kept = np.exp(tint * np.minimum(1.0, most / np.maximum(np.abs(tint).max(-1, keepdims=True), most)))
    return kept * luminance / (kept @ LUMINANCE.astype(ground.dtype))[..., None]


def quantise(levels: np.ndarray) -> np.ndarray:
    """Display levels (..., float) → uint8: rounded to nearest (halves to even, so without bias), clipped."""
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


LINEAR = to_linear(np.arange(256))
"""Linear light (256,) float64 of each 8-bit display level."""
LINEAR.setflags(write=False)

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Weights of linear R, G, B (Rec. 709)."""
LUMINANCE.setflags(write=False)
