"""How well markings are found: precision, recall and F1 at a tolerance of a few pixels."""

from __future__ import annotations

import attrs
import numpy as np
from scipy.ndimage import distance_transform_edt

TOLERANCE = 3.0
"""Pixels: masks drawn by hand are not truer than that."""


@attrs.frozen
class Found:
    """How found markings compare with the true ones.

    Attributes
    ----------
    precision : float
        Share of the found pixels that have a true one within the tolerance; 1 when nothing was found.
    recall : float
        Share of the true pixels that have a found one within the tolerance; 1 when there are none.
    """

    precision: float
    recall: float

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        total = self.precision + self.recall
        return 2 * self.precision * self.recall / total if total else 0.0


def compare(found: np.ndarray, true: np.ndarray, seen: np.ndarray | None = None, tolerance: float = TOLERANCE) -> Found:
    """Compare found markings with true ones.

    Parameters
    ----------
    found, true : ndarray (H, W) bool
    seen : ndarray (H, W) bool or None
        Where to compare: the rest counts for nothing. None: everywhere.
    tolerance : float
        Pixels, Euclidean.

    Examples
    --------
    >>> line = np.zeros((9, 9), bool); line[4] = True
    >>> compare(np.roll(line, 2, 0), line).f1
    1.0
    """
    if seen is not None:
        found, true = found & seen, true & seen
    return Found(_near(found, true, tolerance), _near(true, found, tolerance))


def _near(these: np.ndarray, those: np.ndarray, tolerance: float) -> float:
    """Share of the pixels of one set that lie near the other."""
    if not these.any():
        return 1.0
    if not those.any():
        return 0.0
    return float((distance_transform_edt(~those)[these] <= tolerance).mean())
