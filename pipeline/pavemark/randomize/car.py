"""Where the car stands in a plate: the box around which real layouts are measured."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.plate import Plate

HALF_WIDTH, HALF_LENGTH = 0.93, 1.71
"""Metres: the box that hides the car in the images from which the layout was fitted."""

_BAND = 0.5
"""Metres above and below the frame's middle in which the car's sides are looked for."""


@attrs.frozen
class Car:
    """The box of the car, its length along the world's Y.

    Attributes
    ----------
    x : float
        Metres, of its centre; its Y is 0.
    half_width, half_length : float
        Metres.
    sides : tuple of int
        Where there is ground to see beside it: -1 left, 1 right.
    """

    x: float
    half_width: float
    half_length: float
    sides: tuple[int, ...]

    def reach(self, normal: np.ndarray) -> float:
        """Metres from the box's centre to its farthest point along a unit vector (2,)."""
        return self.half_width * abs(float(normal[0])) + self.half_length * abs(float(normal[1]))


def find_car(plate: Plate) -> Car:
    """The car of a plate.

    It covers the frame's centre; or, in a half-view, the middle of the left or right border, and then only its near
    side is known. Where neither is covered, the camera's car is taken to stand at the centre, unseen.
    """
    frame, ground = plate.frame, plate.ground
    width, height = frame.size
    band = max(1, round(_BAND * frame.scale))
    middle = frame.height // 2
    covered = ground[max(0, middle - band) : middle + band].mean(0) < 0.5
    centre = frame.width // 2
    if covered.all():
        return Car(0.0, width / 2, height / 2, ())
    if covered[centre]:
        left = _run(covered[centre::-1])
        right = _run(covered[centre:])
        x = (right - left) / 2 / frame.scale
        return Car(x, (left + right - 1) / 2 / frame.scale, _half_length(ground[:, centre], frame.scale), (-1, 1))
    for line, sign in ((covered, -1), (covered[::-1], 1)):
        seen = _run(line)
        if seen:
            column = ground[:, 0 if sign < 0 else -1]
            edge = sign * (width / 2 - seen / frame.scale)
            return Car(edge + sign * HALF_WIDTH, HALF_WIDTH, _half_length(column, frame.scale), (-sign,))
    return Car(0.0, HALF_WIDTH, HALF_LENGTH, (-1, 1))


def _run(covered: np.ndarray) -> int:
    """Number of covered pixels (N,) before the first that is not."""
    return len(covered) if covered.all() else int(np.argmin(covered))


def _half_length(column: np.ndarray, scale: float) -> float:
    """Half the covered length through the middle of a column (H,), metres."""
    middle = len(column) // 2
    return (_run(~column[middle::-1]) + _run(~column[middle:]) - 1) / 2 / scale
