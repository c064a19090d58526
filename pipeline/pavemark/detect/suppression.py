"""Of points found twice, the more confident."""

from __future__ import annotations

import numpy as np

APART = 0.5
"""Metres by which two marking points are apart at least: no slot is so narrow. A cell or less of the usual grids."""


def strongest(points: np.ndarray, confidence: np.ndarray, apart: float = APART) -> np.ndarray:
    """Which points have no more confident one beside them that is kept.

    Parameters
    ----------
    points : ndarray (N, 2)
        Metres, u right and v down.
    confidence : ndarray (N,)
    apart : float
        Metres within which one of two points is left out.

    Returns
    -------
    ndarray (M,) int64
        Their positions, the most confident first; of equally confident points the upper first, then the left.
    """
    order = np.lexsort((points[:, 0], points[:, 1], -confidence))
    left = np.ones(len(points), bool)
    kept = []
    for k in order.tolist():
        if left[k]:
            kept.append(k)
            left &= np.hypot(*(points - points[k]).T) >= apart
    return np.array(kept, np.int64)
