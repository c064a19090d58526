"""The inpainting judge's picture: what was there, the hole, and what each method made of it, pixel for pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pavemark.accuracy.cases import Case

WINDOW = 180
"""Pixels a side of what is shown of an image."""

_GAP, _HEAD = 4, 18
_PAPER, _INK = (24, 24, 24), (235, 235, 235)


def grid(fills: Sequence[tuple[Case, Mapping[str, np.ndarray]]], methods: Sequence[str]) -> np.ndarray:
    """Draw a row an image: truth, hole, and each method's fill.

    Parameters
    ----------
    fills : sequence of (Case, mapping)
        At least one; the fill (H, W, 3) uint8 by method, where there is one.
    methods : sequence of str
        The columns.

    Returns
    -------
    ndarray (h, w, 3) uint8
        Each picture is a window of at most 180×180 pixels where most of the hole is, at native scale.
    """
    windows = [window(case.hole.mask, WINDOW) for case, _ in fills]
    width = max(columns.stop - columns.start for _, columns in windows)
    columns = ("truth", "hole", *methods)
    rows = []
    for (case, made), where in zip(fills, windows, strict=True):
        truth = case.plate.source
        marked = truth.copy()
        marked[case.hole.mask] = 255
        tiles = [truth, marked, *(made.get(method, np.full_like(truth, _PAPER)) for method in methods)]
        rows.append(np.hstack([_framed(tile[where], width) for tile in tiles]))
        rows.append(np.full((_HEAD, rows[-1].shape[1], 3), _PAPER, np.uint8))
        _text(rows[-1], case.plate.name, _GAP)
    head = np.full((_HEAD, rows[0].shape[1], 3), _PAPER, np.uint8)
    for k, name in enumerate(columns):
        _text(head, name, _GAP + k * (width + _GAP))
    return np.vstack([head, *rows])


def window(hole: np.ndarray, side: int) -> tuple[slice, slice]:
    """The rows and columns of the window, at most `side` pixels a side, that holds most of a hole's pixels."""
    size = [min(side, length) for length in hole.shape]
    total = np.pad(hole.astype(np.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    down, right = size
    inside = total[down:, right:] - total[:-down, right:] - total[down:, :-right] + total[:-down, :-right]
    top, left = np.unravel_index(np.argmax(inside), inside.shape)
    return slice(int(top), int(top) + down), slice(int(left), int(left) + right)


def _framed(tile: np.ndarray, width: int) -> np.ndarray:
    right = width - tile.shape[1] + _GAP // 2
    return cv2.copyMakeBorder(tile, 0, 0, _GAP // 2, right, cv2.BORDER_CONSTANT, value=_PAPER)


def _text(strip: np.ndarray, text: str, left: int) -> None:
    cv2.putText(strip, text, (left, 13), cv2.FONT_HERSHEY_SIMPLEX, 0.4, _INK, 1, cv2.LINE_AA)
