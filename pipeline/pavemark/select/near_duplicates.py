"""Leaving out what looks as something that is kept already looks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from pavemark.select.candidate import Candidate

BLOCK = 1024
"""Images that are compared at a time, with as many at a time of those that are kept: memory does not grow with both."""

_ACROSS = 8 * BLOCK

_SLACK = 1e-5
"""What a cosine of numbers of single precision may be off: nearer to the threshold it is reckoned exactly."""


def distinct(candidates: Sequence[Candidate], embeddings: np.ndarray, distance: float) -> Iterator[Candidate]:
    """Candidates, in their order, less those that lie closer to one that is kept than a distance.

    Parameters
    ----------
    candidates : sequence of Candidate
        No more are looked at, but for one block, than are asked for.
    embeddings : ndarray (N, E) float32
        Of the candidates. One of length nought has the distance 1 to all.
    distance : float
        Cosine distance, 0 to 2: one less the cosine. Two that lie exactly so far apart are both kept.

    Yields
    ------
    Candidate
    """
    kept = _Kept()
    for start in range(0, len(candidates), BLOCK):
        block, seen = candidates[start : start + BLOCK], _normalised(embeddings[start : start + BLOCK])
        free = ~kept.near(seen, distance)
        chosen = np.zeros(len(block), bool)
        within = seen @ seen.T
        for k in np.flatnonzero(free):
            if (
                _far(within[k], distance, chosen)
                or not _near(within[[k]][:, chosen], seen[[k]], seen[chosen], distance).any()
            ):
                chosen[k] = True
                yield block[k]
        kept.add(seen[chosen])


class _Kept:
    """The embeddings of what is kept."""

    def __init__(self) -> None:
        self._parts: list[np.ndarray] = []

    def add(self, seen: np.ndarray) -> None:
        if len(seen):
            # Many small parts are slow to go through, large ones would have to be copied as they grow.
            if self._parts and len(self._parts[-1]) + len(seen) <= _ACROSS:
                seen = np.concatenate([self._parts.pop(), seen])
            self._parts.append(seen)

    def near(self, seen: np.ndarray, distance: float) -> np.ndarray:
        """Which of (N, E) lie too close to one that is kept, bool (N,)."""
        found = np.zeros(len(seen), bool)
        for part in self._parts:
            left = np.flatnonzero(~found)
            found[left] = _near(seen[left] @ part.T, seen[left], part, distance)
        return found


def _far(cosines: np.ndarray, distance: float, which: np.ndarray) -> bool:
    """Whether all of some cosines (M,) are beyond doubt those of images that lie far enough apart."""
    return cosines.max(initial=-2.0, where=which) < 1 - distance - _SLACK


def _near(cosines: np.ndarray, ours: np.ndarray, theirs: np.ndarray, distance: float) -> np.ndarray:
    """Whether each of ours lies too close to one of theirs, bool (N,), their cosines (N, M) being roughly known."""
    nearest = cosines.max(1, initial=-2.0)
    near = nearest > 1 - distance + _SLACK
    for k in np.flatnonzero(~near & (nearest > 1 - distance - _SLACK)):
        for m in np.flatnonzero(cosines[k] > 1 - distance - _SLACK):
            # Sums of matrix products differ from machine to machine; this one does not.
            if max(0.0, 1 - math.fsum(ours[k].astype(float) * theirs[m].astype(float))) < distance:
                near[k] = True
                break
    return near


def _normalised(seen: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(seen.astype(np.float64), axis=1, keepdims=True)
    return (seen / np.where(lengths, lengths, 1)).astype(np.float32)
