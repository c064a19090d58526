"""Slots from directed marking points, by the geometric rules of DMPR-PS (Huang, Zhang, Shen, Zhao; ICME 2019)."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

ENTRANCES = ((2.116, 3.316), (3.880, 6.667))
"""Metres between the two points of a slot that is entered at its short side, and at its long one."""

ALONG, ASIDE = 0.0976 + 0.1384, 0.2850 + 0.1384
"""Radians by which a direction may be off the entrance line, and off the normal to it: what labels and detections of
the published detector are off together."""

BETWEEN = 0.8
"""Cosine of the turn at a third point above which the way from one point to the other leads by it."""

WIDER = 1 + 1e-9
"""Of who is near: last bits of a distance are not the tree's to decide."""

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
    if not len(points):
        return np.empty((0, 2), np.int64), np.empty(0)
    tree = cKDTree(points)
    near = tree.query_pairs(ENTRANCES[-1][1] * WIDER, output_type="ndarray")
    way = points[near[:, 1]] - points[near[:, 0]]
    length = np.hypot(*way.T)
    apart = np.any([(least <= length) & (length <= most) for least, most in ENTRANCES], 0)
    near, way, length = near[apart], way[apart], length[apart]
    here, there = (
        _sides(sign * way, directions[end], l_shaped[end]) for sign, end in zip((1, -1), near.T, strict=True)
    )
    # Seen from the other point the line runs the other way: what is left of it there is right of it here.
    agreed = here & (((there & LEFT) * RIGHT) | ((there & RIGHT) // RIGHT))
    for k in np.flatnonzero((agreed == LEFT) | (agreed == RIGHT)).tolist():
        i, j = near[k].tolist()
        # On a way that turns so little the third point is nearer to each than they are to each other.
        others = np.array(tree.query_ball_point(points[i], length[k] * WIDER))
        third = _between(points[i], points[j], points[others])
        sure = min(confidence[i], confidence[j]) * (1 - confidence[others[third]].max(initial=0.0))
        if sure > 0:
            found.append((-sure, (i, j) if agreed[k] == LEFT else (j, i)))
    found.sort()
    slots = np.array([slot for _, slot in found], np.int64).reshape(-1, 2)
    return slots, np.array([-sure for sure, _ in found], np.float64)


def _sides(way: np.ndarray, directions: np.ndarray, l_shaped: np.ndarray) -> np.ndarray:
    """(N,) int: on which side of the lines (N, 2) that run from them points allow a slot."""
    # With v down a positive turn is clockwise as seen: to the right.
    turn = np.arctan2(
        way[:, 0] * directions[:, 1] - way[:, 1] * directions[:, 0],
        (way * directions).sum(-1),
    )
    along = np.abs(turn) < ALONG
    left, right = np.abs(turn + math.pi / 2) < ASIDE, np.abs(turn - math.pi / 2) < ASIDE
    # A T points along the entrance line where the slot's own line is the bar; an L that does has its other arm right.
    stem = np.select([along, left, right], [BOTH, LEFT, RIGHT], NEITHER)
    corner = np.select([along, left], [RIGHT, LEFT], NEITHER)
    return np.where(l_shaped, corner, stem)


def _between(one: np.ndarray, other: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,) bool: which points lie between two."""
    first, then = points - one, other - points
    with np.errstate(invalid="ignore"):
        cosine = (first * then).sum(-1) / (np.hypot(*first.T) * np.hypot(*then.T))
    # Neither point lies between itself and the other: there the cosine is no number.
    return cosine > BETWEEN
