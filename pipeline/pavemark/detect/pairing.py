"""Slots from directed marking points, by the geometric rules of DMPR-PS (Huang, Zhang, Shen, Zhao; ICME 2019)."""

from __future__ import annotations

import math

import numpy as np

ENTRANCES = ((2.116, 3.316), (3.880, 6.667))
"""Metres between the two points of a slot that is entered at its short side, and at its long one."""

ALONG, ASIDE = 0.0976 + 0.1384, 0.2850 + 0.1384
"""Radians by which a direction may be off the entrance line, and off the normal to it: what labels and detections of
the published detector are off together."""

BETWEEN = 0.8
"""Cosine of the turn at a third point above which the way from one point to the other leads by it."""

BOTH, LEFT, RIGHT, NEITHER = 3, 1, 2, 0
"""On which side of a line from a point to another the point allows a slot, as bits."""


def paired(
    points: np.ndarray, directions: np.ndarray, l_shaped: np.ndarray, confidence: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Slots that points form.

    Two points form a slot when they are an entrance apart, no third point lies between, and their directions and shapes
    say that the slot lies on the same side. The published rule knows points alone that are there or not; here they are
    so with a confidence, and so is a slot: as confident as the less confident of its points, times the doubt that there
    is a third point between.

    Parameters
    ----------
    points : ndarray (N, 2)
        Metres, u right and v down.
    directions : ndarray (N, 2)
        Unit vectors in the same axes.
    l_shaped : ndarray (N,) bool
    confidence : ndarray (N,)
        0 to 1.

    Returns
    -------
    slots : ndarray (M, 2) int64
        Positions of p1 and p2; the slot lies to the left of p1 → p2 as seen. The most confident first.
    slot_confidence : ndarray (M,) float64
        More than nought.
    """
    found = []
    way = points[None] - points[:, None]
    length = np.hypot(way[..., 0], way[..., 1])
    apart = np.any([(least <= length) & (length <= most) for least, most in ENTRANCES], 0)
    sides = _sides(way, directions, l_shaped)
    # Seen from the other point the line runs the other way: what is left of it there is right of it here.
    agreed = sides & (((sides & LEFT) * RIGHT) | ((sides & RIGHT) // RIGHT)).T
    for i, j in np.argwhere(np.triu(apart & ((agreed == LEFT) | (agreed == RIGHT)), 1)).tolist():
        sure = min(confidence[i], confidence[j]) * (1 - _between(i, j, way, length, confidence))
        if sure > 0:
            found.append((-sure, (i, j) if agreed[i, j] == LEFT else (j, i)))
    found.sort()
    slots = np.array([slot for _, slot in found], np.int64).reshape(-1, 2)
    return slots, np.array([-sure for sure, _ in found], np.float64)


def _sides(way: np.ndarray, directions: np.ndarray, l_shaped: np.ndarray) -> np.ndarray:
    """(N, N) int: on which side of the line from i to j the point i allows a slot."""
    # With v down a positive turn is clockwise as seen: to the right.
    turn = np.arctan2(
        way[..., 0] * directions[:, None, 1] - way[..., 1] * directions[:, None, 0],
        (way * directions[:, None]).sum(-1),
    )
    along = np.abs(turn) < ALONG
    left, right = np.abs(turn + math.pi / 2) < ASIDE, np.abs(turn - math.pi / 2) < ASIDE
    # A T points along the entrance line where the slot's own line is the bar; an L that does has its other arm right.
    stem = np.select([along, left, right], [BOTH, LEFT, RIGHT], NEITHER)
    corner = np.select([along, left], [RIGHT, LEFT], NEITHER)
    return np.where(l_shaped[:, None], corner, stem)


def _between(i: int, j: int, way: np.ndarray, length: np.ndarray, confidence: np.ndarray) -> float:
    """How confidently a third point lies between two."""
    with np.errstate(invalid="ignore"):
        cosine = (way[i] * way[:, j]).sum(-1) / (length[i] * length[:, j])
    # Neither point lies between itself and the other: there the cosine is no number.
    third = cosine > BETWEEN
    return float(confidence[third].max(initial=0.0))
