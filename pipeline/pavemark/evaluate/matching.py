"""Which of the things found are there: the rule of the paper (Zhang, Liu, Gao 2026, Eq. 3)."""

from __future__ import annotations

import numpy as np

from pavemark.evaluate.found import Marks
from pavemark.ground import Frame

TOLERANCE = 10.0
"""Pixels at 60 px/m, which are 1/6 m on the ground."""

SCALE = 60.0
"""Pixels per metre at which tolerances are told."""

NONE = -1


def radius(frame: Frame, tolerance: float = TOLERANCE) -> float:
    """A tolerance in pixels of a picture: as many metres at every scale."""
    return tolerance * frame.scale / SCALE


def matched(marks: Marks, truth: np.ndarray, radius: float) -> np.ndarray:
    """Match what was found with what is there, each at most once.

    The most confident chooses first, and takes the nearest truth that is free and nearer than `radius`: points by their
    distance, pairs by that of both ends together, ``‖(p1g − p1d, p2g − p2d)‖₂`` (Eq. 3), in their order. Of equally
    confident ones that lie further up in `Marks.order` choose first; of truths as near the leftmost is taken, then
    the uppermost. So the order in which either is given does not matter, and what is found above a confidence is
    matched as if the rest had not been found.

    Parameters
    ----------
    marks : Marks
        N things found.
    truth : ndarray (T, 2) or (T, 4)
        Where those that are there lie, as `Marks.places`.
    radius : float
        Pixels. A distance of just as much is too far.

    Returns
    -------
    ndarray (N,) int64
        For each thing found the position of its truth, or NONE.
    """
    truths = np.full(len(marks.confidence), NONE)
    if not (len(truths) and len(truth)):
        return truths
    truth = np.asarray(truth, np.float64)
    positions = np.lexsort(truth.T[::-1])
    apart = distances(marks.places, truth[positions])
    for one in marks.order():
        nearest = apart[one].argmin()
        if apart[one, nearest] < radius:
            truths[one] = positions[nearest]
            apart[:, nearest] = np.inf
    return truths


def distances(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How far each of (N, d) lies from each of (T, d): (N, T)."""
    return np.sqrt(((one[:, None] - other[None]) ** 2).sum(-1))
