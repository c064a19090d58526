"""Labels as in ps2.0: one MATLAB file an image, `marks` and `slots`."""

from __future__ import annotations

import io

import numpy as np
from scipy.io import savemat

from pavemark.labels.truth import MarkingPoint, ParkingSlot, Truth

_HEADER = b"MATLAB 5.0 MAT-file, parking-slot labels".ljust(116)


def encode(truth: Truth) -> bytes:
    """The .mat file of an image.

    `marks` (N, 2) float64 holds the visible marking points in pixels, the centre of the first pixel at 1. `slots`
    (M, 4) int32 holds [i, j, type, angle], see `slot_rows`; whole numbers, because published readers index with
    them. Without slots the arrays are (0, 2) and (0, 4).
    """
    marks = np.array([pixel(mark.point) for mark in visible(truth)], np.float64).reshape(-1, 2)
    slots = np.array(slot_rows(truth), np.int32).reshape(-1, 4)
    stream = io.BytesIO()
    savemat(stream, {"marks": marks, "slots": slots})
    # The first 116 bytes are free text, in which the writer puts the date.
    return _HEADER + stream.getvalue()[len(_HEADER) :]


def pixel(point: tuple[float, float]) -> tuple[float, float]:
    """Image coordinates as ps2.0 counts pixels: the picture reaches from 0.5 to W + 0.5."""
    return point[0] + 0.5, point[1] + 0.5


def visible(truth: Truth) -> list[MarkingPoint]:
    """The marking points that are listed, in the order in which they are numbered."""
    return [mark for mark in truth.marks if mark.visible]


def slot_rows(truth: Truth) -> list[list[int]]:
    """A row [i, j, type, angle] for each slot with both marking points visible.

    i and j number the marking points p1 and p2 from 1. The slot lies to the left of p1 → p2 as seen. Type 1 is
    right-angled, 2 slanted with an acute and 3 with an obtuse angle. The angle is whole degrees, anticlockwise as
    seen from p1 → p2 to the separating line; 90 for type 1.
    """
    seen = (position for position, mark in enumerate(truth.marks) if mark.visible)
    number = {position: n for n, position in enumerate(seen, 1)}
    return [[*(number[mark] for mark in slot.entrance), *_form(slot)] for slot in truth.slots if slot.paired]


def _form(slot: ParkingSlot) -> tuple[int, int]:
    if slot.kind != "slanted":
        return 1, 90
    return (2 if slot.angle < 90 else 3), round(slot.angle)
