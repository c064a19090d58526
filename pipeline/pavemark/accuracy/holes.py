"""The self-made hole: the marking's own hole, moved to bare ground of the same image, where the truth is known.

What an inpainter makes of a real marking nobody can check, for nobody knows the ground below it. A hole of the same
shape on bare ground beside it asks the same of the inpainter, and what it should have found is in the picture.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from scipy import fft

from pavemark.background.plates import SOFT_EDGE
from pavemark.ground import Frame

MARGIN = 0.08
"""Metres that a self-made hole keeps from the soft edge of the real markings: no trace of paint is in the truth."""

ENOUGH = 0.7
"""Share of the hole that must find bare ground for it to be moved only; else it is turned and mirrored too."""

LEAST = 64
"""Pixels below which a hole tells nothing."""

MOST = 0.5
"""Share of the bare ground that a hole may take: something must be left to fill it from."""


@attrs.frozen
class Move:
    """Where a mask is moved: mirrored left to right, then turned by quarters anticlockwise, then shifted in pixels."""

    mirrored: bool = False
    quarters: int = 0
    down: int = 0
    right: int = 0

    def apply(self, array: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
        """An array (h, w, …), moved, as it lies in a picture of `shape` (H, W); zero where nothing comes to lie.

        Examples
        --------
        >>> Move(right=1).apply(np.array([[1, 2], [3, 4]]), (2, 3))
        array([[0, 1, 2],
               [0, 3, 4]])
        """
        turned = _turned(array, self.mirrored, self.quarters)
        moved = np.zeros((*shape, *array.shape[2:]), array.dtype)
        source, target = [], []
        for start, length, size in zip((self.down, self.right), turned.shape, shape, strict=False):
            low, high = max(0, start), min(size, start + length)
            if low >= high:
                return moved
            target.append(slice(low, high))
            source.append(slice(low - start, high - start))
        moved[tuple(target)] = turned[tuple(source)]
        return moved


@attrs.frozen(eq=False)
class Hole:
    """A self-made hole.

    Attributes
    ----------
    mask : ndarray (H, W) bool
        What is to be filled: bare ground.
    keep_out : ndarray (H, W) bool
        What the inpainter must not look at: what is not ground, and the real markings with their soft edge, for they
        would be taken off together with the hole.
    move : Move
        How the hole of the marking became this one.
    share : float
        Share of the marking's hole that found bare ground, 0 to 1; the rest of it is cut off.
    """

    mask: np.ndarray
    keep_out: np.ndarray
    move: Move
    share: float


def around(marking: np.ndarray, frame: Frame) -> np.ndarray:
    """A marking (H, W) with its soft edge, as a plate's hole is made, but for what lies off the ground."""
    return _widened(marking, max(2, round(SOFT_EDGE * frame.scale)))


def self_made_hole(marking: np.ndarray, own: np.ndarray, ground: np.ndarray, frame: Frame) -> Hole | None:
    """Move the hole of a marking to bare ground, as much of it as finds room.

    All shifts are tried at once, by correlation. The largest hole wins, of equal ones the uppermost, then leftmost;
    mirrored and turned ones count only where a shift alone finds too little room.

    Parameters
    ----------
    marking : ndarray (h, w) bool
        The marking whose hole is moved: the image's own, or another's where it has none.
    own : ndarray (H, W) bool
        The image's own markings, which the hole keeps off.
    ground : ndarray (H, W) bool
        Ground, painted or bare.
    frame : Frame
        Of the image.

    Returns
    -------
    Hole or None
        None where no move leaves at least 64 pixels of hole and as much bare ground beside it.

    Examples
    --------
    A line down the middle of a small picture is moved into the upper left corner, soft edge and all:

    >>> line = np.zeros((60, 60), bool)
    >>> line[10:50, 30:34] = True
    >>> hole = self_made_hole(line, line, np.ones((60, 60), bool), Frame(60, 60, 30.0))
    >>> hole.move
    Move(mirrored=False, quarters=0, down=-6, right=-26)
    >>> bool((hole.mask & around(line, Frame(60, 60, 30.0))).any())
    False
    """
    painted = around(own, frame)
    bare = ground & ~_widened(painted, max(1, round(MARGIN * frame.scale)))
    shape = around(marking, frame)
    found = _best(shape, bare, ((False, 0),))
    if found is None or found[1] < ENOUGH * shape.sum():
        every = [(mirrored, quarters) for mirrored in (False, True) for quarters in range(4)]
        found = _best(shape, bare, every)
    if found is None:
        return None
    move, area = found
    return Hole(move.apply(shape, bare.shape) & bare, ~ground | painted, move, float(area / shape.sum()))


def _best(shape: np.ndarray, bare: np.ndarray, turns) -> tuple[Move, int] | None:
    """The move that lays most of a shape on bare ground, and how many of its pixels."""
    most = MOST * bare.sum()
    side = max(shape.shape)
    size = [fft.next_fast_len(length + side - 1, real=True) for length in bare.shape]
    spectrum = fft.rfft2(bare.astype(np.float64), size)
    best = None
    for mirrored, quarters in turns:
        turned = _turned(shape, mirrored, quarters)
        height, width = turned.shape
        there = spectrum * fft.rfft2(turned[::-1, ::-1].astype(np.float64), size)
        area = np.rint(fft.irfft2(there, size)[: bare.shape[0] + height - 1, : bare.shape[1] + width - 1])
        area[area > most] = 0
        down, right = np.unravel_index(np.argmax(area), area.shape)
        found = int(area[down, right])
        if found >= LEAST and (best is None or found > best[1]):
            best = Move(mirrored, quarters, int(down) - height + 1, int(right) - width + 1), found
    return best


def _turned(array: np.ndarray, mirrored: bool, quarters: int) -> np.ndarray:
    return np.rot90(array[:, ::-1] if mirrored else array, quarters)


def _widened(mask: np.ndarray, radius: int) -> np.ndarray:
    return cv2.dilate(mask.astype(np.uint8), np.ones((2 * radius + 1, 2 * radius + 1), np.uint8)) > 0
