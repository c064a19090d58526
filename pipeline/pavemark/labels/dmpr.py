"""Labels as DMPR-PS reads them: the points and slots of ps2.0 as JSON, with direction and shape of each point."""

from __future__ import annotations

import json

from pavemark.labels.ps2 import pixel, slot_rows, visible
from pavemark.labels.truth import MarkingPoint, Truth

ARM = 50.0
"""Pixels from a marking point to the second point that tells its direction."""


def encode(truth: Truth) -> str:
    """The JSON text of an image.

    `marks`: [x, y, x_dir, y_dir, shape] for each visible marking point, pixels as in ps2.0, shape 0 for T and 1 for
    L. `slots`: [i, j, type, angle] as in ps2.0.
    """
    return json.dumps({"marks": [_mark(mark) for mark in visible(truth)], "slots": slot_rows(truth)}) + "\n"


def _mark(mark: MarkingPoint) -> list[float]:
    x, y = pixel(mark.point)
    dx, dy = mark.direction
    numbers = (x, y, x + ARM * dx, y + ARM * dy)
    return [*(round(number, 4) for number in numbers), 0 if mark.shape == "T" else 1]
