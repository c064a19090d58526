"""Filling a large image in crops at native scale: where they lie, and how their fills become one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pavemark.colour import quantise

CONTEXT = 64
"""Pixels around a hole's pixel that one crop shows on every side, but for the image's own border."""

SHARPNESS = 8
"""Power of the depth in a crop that is its fill's weight. The mean of two textures has less contrast than either: most
pixels are to come from one crop, with a passage of some 20 to 60 px between two."""


def windows(hole: np.ndarray, side: int) -> list[tuple[slice, slice]]:
    """Where crops lie so that each pixel of a hole is in one with its context.

    Parameters
    ----------
    hole : ndarray (H, W) bool
    side : int
        Largest height and width of a crop, more than twice `CONTEXT`.

    Returns
    -------
    list of (slice, slice)
        Rows and columns; never beyond the image.
    """
    left = hole.copy()
    found = []
    while left.any():
        top = _start(_first(left.any(axis=1)), hole.shape[0], side)
        columns = left[_inner(top, hole.shape[0], side)].any(axis=0)
        corner = (top, _start(_first(columns), hole.shape[1], side))
        covered = left[_inners(corner, hole.shape, side)]
        corner = tuple(
            _centred(begin, covered.any(axis=1 - axis), hole.shape[axis], side) for axis, begin in enumerate(corner)
        )
        left[_inners(corner, hole.shape, side)] = False
        found.append(tuple(slice(begin, min(begin + side, end)) for begin, end in zip(corner, hole.shape, strict=True)))
    return found


def filled_in_crops(
    image: np.ndarray, hole: np.ndarray, side: int, fill: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Fill a hole crop by crop.

    The crops' fills are weighted by how deep a pixel lies in each: the weights add up to one and vary smoothly, so
    that no crop's border shows.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
    hole : ndarray (H, W) bool
    side : int
        See `windows`.
    fill : callable
        (image, hole) of a crop → float (h, w, 3), levels from 0 to 255.

    Returns
    -------
    ndarray (H, W, 3) uint8
        Outside the hole it is the image.

    Raises
    ------
    ValueError
        When a crop shows nothing but hole.
    """
    total = np.zeros(image.shape)
    weights = np.zeros((*hole.shape, 1))
    for window in windows(hole, side):
        if hole[window].all():
            raise ValueError(f"{hole[window].shape[1]}×{hole[window].shape[0]} px are nothing but hole")
        down, across = (_depth(part, length) for part, length in zip(window, hole.shape, strict=True))
        weight = (down[:, None] * across)[..., None] ** SHARPNESS
        total[window] += weight * fill(image[window], hole[window])
        weights[window] += weight
    result = image.copy()
    result[hole] = quantise(total[hole] / weights[hole])
    return result


def _first(there: np.ndarray) -> int:
    return int(np.argmax(there))


def _start(first: int, length: int, side: int) -> int:
    return min(max(first - CONTEXT, 0), max(length - side, 0))


def _inner(start: int, length: int, side: int) -> slice:
    """The pixels of a crop that have their context in it."""
    return slice(start and start + CONTEXT, length if start + side >= length else start + side - CONTEXT)


def _inners(corner: tuple[int, ...], shape: tuple[int, ...], side: int) -> tuple[slice, ...]:
    return tuple(_inner(start, length, side) for start, length in zip(corner, shape, strict=True))


def _centred(start: int, covered: np.ndarray, length: int, side: int) -> int:
    """The crop's start, moved so that what it covers lies in its middle: the context is then the same on both sides."""
    first, last = _first(covered), len(covered) - 1 - _first(covered[::-1])
    middle = _inner(start, length, side).start + (first + last + 1) // 2
    return min(max(middle - side // 2, 0), max(length - side, 0))


def _depth(part: slice, length: int) -> np.ndarray:
    """How far inside a crop its rows (columns) lie, from 0 to 1; beyond the image's own border there is nothing."""
    count = part.stop - part.start
    inside = np.arange(count) + 0.5
    before = inside if part.start else np.full(count, count)
    after = inside[::-1] if part.stop < length else np.full(count, count)
    return np.minimum(before, after) / count
