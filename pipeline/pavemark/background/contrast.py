"""Contrast that differs from place to place, made even: paint too pale for its floor stands out as other paint does."""

from __future__ import annotations

import cv2
import numpy as np

TILE = 5.0
"""Metres a side of what is made even together: a slot's length, so that lines and much bare ground are in it."""

LIMIT = 4.0
"""How many times as strong contrast may become: beyond that the grain of bare ground looks painted."""


def evened(image: np.ndarray, scale: float, limit: float = LIMIT) -> np.ndarray:
    """The picture with the contrast of its lightness made even, tile by tile; hues stay.

    Contrast-limited adaptive histogram equalisation (Zuiderveld, Graphics Gems IV, 1994) of CIELAB's L*.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display RGB, of any size.
    scale : float
        Pixels per metre.
    limit : float
        How many times as strong contrast may become, above 1.

    Returns
    -------
    ndarray (H, W, 3) uint8
    """
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB)
    tiles = tuple(max(1, round(side / scale / TILE)) for side in image.shape[1::-1])
    lab[..., 0] = cv2.createCLAHE(limit, tiles).apply(lab[..., 0])
    return cv2.cvtColor(lab, cv2.COLOR_LAB2RGB)
