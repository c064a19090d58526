"""A contact sheet: strips of pictures, a strip for each thing that is shown, a column for each view of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np

LARGEST = 3000
"""Pixels of the sheet's longer side."""

PAPER, INK = (24, 24, 24), (235, 235, 235)

_GAP, _LINE = 6, 19
_HEAD = 2 * _LINE


class Strip(Protocol):
    """One thing and its views, side by side."""

    title: str
    size: tuple[int, int]
    """Width and height of each view in pixels, at their own scale."""

    def tiles(self, scale: float) -> Sequence[np.ndarray]:
        """The views (H, W, 3) uint8 RGB, enlarged or reduced as `scaled` does it. Called once."""
        ...


def spread(there: Sequence, most: int) -> list:
    """At most so many of them, evenly spread, the first and the last among them."""
    return [there[k] for k in np.linspace(0, len(there) - 1, min(most, len(there))).round().astype(int)]


def drawn(strips: Sequence[Strip], columns: Sequence[str]) -> np.ndarray:
    """Draw a sheet.

    Parameters
    ----------
    strips : sequence of Strip
        At least one. Their views are asked for one after the other, so that they need not be in memory together.
    columns : sequence of str
        What the views are.

    Returns
    -------
    ndarray (H, W, 3) uint8
        RGB, at most `LARGEST` pixels a side.
    """
    width, height = (max(strip.size[side] for strip in strips) for side in (0, 1))
    across, scale = max(
        ((across, _fitting(len(strips), across, len(columns), width, height)) for across in range(1, len(strips) + 1)),
        key=lambda choice: choice[1],
    )
    box = (math.ceil(width * scale), math.ceil(height * scale))
    long = len(columns) * (box[0] + _GAP) + 2 * _GAP
    down = math.ceil(len(strips) / across)
    sheet = np.full((down * (box[1] + _HEAD + _GAP), across * long, 3), PAPER, np.uint8)
    for k, strip in enumerate(strips):
        top, left = k // across * (box[1] + _HEAD + _GAP), k % across * long + _GAP
        # A name may be wider than its pictures, and is what one looks for.
        text(sheet[top : top + _LINE, left : left + long - 2 * _GAP], strip.title, (2, 14), INK)
        # A smaller picture among larger ones fills its box all the same.
        own = _even(min(box[0] / strip.size[0], box[1] / strip.size[1]))
        for column, (name, tile) in enumerate(zip(columns, strip.tiles(own), strict=True)):
            x = left + column * (box[0] + _GAP)
            text(sheet[top + _LINE : top + _HEAD, x : x + box[0]], name, (2, 13), INK)
            sheet[top + _HEAD : top + _HEAD + tile.shape[0], x : x + tile.shape[1]] = tile
    return sheet


def scaled(image: np.ndarray, scale: float) -> np.ndarray:
    """A picture enlarged, its pixels square, or reduced."""
    size = (math.ceil(image.shape[1] * scale), math.ceil(image.shape[0] * scale))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)


def text(tile: np.ndarray, line: str, at: tuple[int, int], colour: tuple[int, int, int]) -> None:
    """Write on a picture, in place, from the lower left end of the line."""
    for ink, width in ((PAPER, 3), (colour, 1)):
        cv2.putText(tile, line, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, ink, width, cv2.LINE_AA)


def _fitting(count: int, across: int, columns: int, width: int, height: int) -> float:
    """The scale at which so many strips in a row fill the sheet."""
    down = math.ceil(count / across)
    wide = (LARGEST / across - (columns + 2) * _GAP) / (columns * width)
    high = (LARGEST / down - _HEAD - _GAP) / height
    return _even(min(wide, high))


def _even(scale: float) -> float:
    """The scale at most so large at which pixels stay square: a whole one where it enlarges."""
    return float(min(math.floor(scale), 4)) if scale >= 1 else scale
