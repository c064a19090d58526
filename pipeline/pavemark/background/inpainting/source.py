"""What an inpainter may look at, and what it may change."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import distance_transform_edt


def filled(
    image: np.ndarray,
    hole: np.ndarray,
    keep_out: np.ndarray,
    propose: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> np.ndarray:
    """Fill a hole with what a function proposes, and let it change nothing else.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
    hole, keep_out : ndarray (H, W) bool
    propose : callable
        (image, hole) → image (H, W, 3) uint8. It is called only when there is something to fill.

    Returns
    -------
    ndarray (H, W, 3) uint8

    Raises
    ------
    ValueError
        When there is something to fill and no pixel to fill it from.
    """
    result = image.copy()
    wanted = hole & ~keep_out
    if not wanted.any():
        return result
    if (hole | keep_out).all():
        raise ValueError("no pixel is left to fill the hole from")
    result[wanted] = propose(image, wanted)[wanted]
    return result


def mirrored(array: np.ndarray, margin: int) -> np.ndarray:
    """An array (H, W, …) with a mirrored margin of so many pixels on each side."""
    return np.pad(array, ((margin, margin), (margin, margin)) + ((0, 0),) * (array.ndim - 2), mode="symmetric")


def within_margin(array: np.ndarray, margin: int) -> np.ndarray:
    """The array without the margin that `mirrored` gave it."""
    return array[margin : array.shape[0] - margin, margin : array.shape[1] - margin]


def neutral(image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
    """The image with what is kept out replaced by the nearest pixel that may be looked at.

    For backends that know no forbidden sources: the black of the ego car cannot bleed into a hole beside it.
    """
    if not keep_out.any():
        return image
    row, column = distance_transform_edt(hole | keep_out, return_distances=False, return_indices=True)
    result = image.copy()
    result[keep_out] = image[row, column][keep_out]
    return result
