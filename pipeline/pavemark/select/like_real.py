"""Images that together look like all the real ones: of each real image one that looks most like it."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from pavemark.errors import InputError
from pavemark.select.candidate import Candidate

WHOLE = 2**30
"""A cosine of 1. As whole numbers cosines add up exactly, in any order: sums of floating point would differ from
machine to machine, and so would which of two images is chosen."""

BLOCK = 1024
"""Images that are compared with all real ones at a time: memory does not grow with their number."""


def like_real(
    candidates: Sequence[Candidate], embeddings: np.ndarray, real: np.ndarray, cap_per_plate: int | None = None
) -> Iterator[Candidate]:
    """The images that real ones look like, those that stand for most of them first.

    How well a set of images stands for the real ones is the sum, over the real ones, of the cosine to that of the set
    which is most alike (facility location). Whatever adds most to it is next, of equals the first by name; when nothing
    adds to it any more, for each real image has its own, it begins anew among the rest.

    Greedy, for the best set is out of reach, and at least 1 - 1/e of what that adds (Nemhauser, Wolsey, Fisher, 1978).
    What an image adds only becomes less, so that few have to be looked at again for each choice (Minoux, 1978).

    Parameters
    ----------
    candidates : sequence of Candidate
        In any order.
    embeddings : ndarray (N, E) float32
        Of the candidates. One of length nought is at right angles to all.
    real : ndarray (R, E) float32
        Of the real images, by the same detector.
    cap_per_plate : int or None
        Most images of a plate: others of it stand for no real image, for they are not kept.

    Yields
    ------
    Candidate

    Raises
    ------
    InputError
        When there is no real image.
    """
    if not len(real):
        raise InputError("--scores-real", "holds no image: at least one is needed")
    by_name = sorted(range(len(candidates)), key=lambda k: candidates[k].name)
    seen, shown = _directions(np.asarray(embeddings)[by_name]), _directions(real)
    left = np.ones(len(seen), bool)
    plates: Counter[str | None] = Counter()
    first = _first(seen, shown)
    while left.any():
        most = np.full(len(shown), -WHOLE - 1)  # below any cosine: the first of a round adds something
        ahead = [(-int(first[k]), k) for k in np.flatnonzero(left).tolist()]
        heapq.heapify(ahead)
        while ahead:
            _, k = heapq.heappop(ahead)
            plate = candidates[by_name[k]].plate
            if cap_per_plate is not None and plates[plate] >= cap_per_plate:
                left[k] = False
                continue
            alike = _alike(seen[[k]], shown)[0]
            gain = int(np.maximum(alike - most, 0).sum())
            if ahead and (-gain, k) > ahead[0]:
                heapq.heappush(ahead, (-gain, k))  # it adds less than it did, and another may add more
                continue
            if not gain:
                break
            left[k] = False
            plates[plate] += 1
            most = np.maximum(most, alike)
            yield candidates[by_name[k]]


def _first(seen: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """(N,) int64: what images add before one is chosen."""
    blocks = [_alike(seen[start : start + BLOCK], shown).sum(1) for start in range(0, len(seen), BLOCK)]
    return np.concatenate([np.empty(0, np.int64), *blocks]) + len(shown) * (WHOLE + 1)


def _alike(seen: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """(N, R) int64: cosines, 1 being WHOLE."""
    return np.rint(seen @ shown.T * WHOLE).astype(np.int64)


def _directions(embeddings: np.ndarray) -> np.ndarray:
    found = np.asarray(embeddings, np.float64)
    lengths = np.linalg.norm(found, axis=1, keepdims=True)
    return found / np.where(lengths, lengths, 1)
