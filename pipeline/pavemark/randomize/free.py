"""Where a row finds free ground: moved across the roadside as little as possible, until its slots are empty."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.ground import Frame
from pavemark.plate import Plate
from pavemark.randomize.car import Car
from pavemark.randomize.row import Row

MOVES = np.array(sorted((0.15 * np.arange(-8, 9)).tolist(), key=abs))
"""Metres by which an entrance line is moved, the least first."""

NEAREST = 0.2
"""Metres from the car's box to a line that was moved, at least: nineteen real ones of twenty are further off."""

STEP = 0.25
"""Metres between the points at which a slot's floor is looked at along the row; across it they are twice as far."""

FREE = 0.95
"""Share of the seen floor of a slot that is ground where nothing stands in it."""


def moved(row: Row, plate: Plate, car: Car) -> tuple[Row, np.ndarray]:
    """The row where it has free ground, and where its slots may start there.

    Parameters
    ----------
    row : Row
        Without slots.
    plate : Plate
    car : Car

    Returns
    -------
    row : Row
    starts : ndarray (N,)
        Metres from the row's origin; none where no move helps.
    """
    clearance = float((np.asarray(row.origin) - (car.x, 0.0)) @ row.normal) - car.reach(row.normal)
    moves = MOVES[(MOVES == 0) | (clearance + MOVES >= NEAREST)]
    starts, free = _free_starts(row, moves, plate)
    helps = free.any(1)
    if not helps.any():
        return row, np.empty(0)
    best = int(helps.argmax())
    return shifted(row, float(moves[best])), starts[free[best]]


def shifted(row: Row, metres: float) -> Row:
    """The row moved along its normal."""
    x, y = np.asarray(row.origin) + metres * row.normal
    return attrs.evolve(row, origin=(float(x), float(y)))


def _free_starts(row: Row, moves: np.ndarray, plate: Plate) -> tuple[np.ndarray, np.ndarray]:
    """Places (N,) along the row, and whether a slot that starts there after each move is seen and empty (M, N)."""
    shape, frame = row.shape, plate.frame
    width = math.ceil(shape.entrance / STEP)
    reach = math.hypot(*frame.size) / 2 + float(np.hypot(*row.origin))
    along = np.arange(-reach, reach + shape.entrance, STEP)
    inwards = np.linspace(0.0, shape.depth, max(2, round(shape.depth / STEP / 2)))
    lines = np.asarray(row.origin) + moves[:, None, None, None] * row.normal + along[:, None, None] * row.along
    uv = frame.to_image(lines + inwards[:, None] * row.inwards)
    inside = frame.contains(uv)
    u, v = (np.clip(np.floor(uv[..., k]).astype(int), 0, side - 1) for k, side in enumerate(plate.ground.shape[::-1]))
    ground = plate.ground[v, u] & inside

    def over_a_slot(count: np.ndarray) -> np.ndarray:
        total = np.cumsum(np.pad(count, ((0, 0), (1, 0))), 1)
        return total[:, width:] - total[:, :-width]

    empty = over_a_slot(ground.sum(2)) >= FREE * over_a_slot(inside.sum(2))
    entrance = over_a_slot(ground[:, :, 0]) == width
    return along[: len(along) + 1 - width], empty & entrance


def seen_part(row: Row, frame: Frame) -> tuple[float, float] | None:
    """The piece of the entrance line's axis that lies in the frame, metres from the row's origin."""
    half = np.array(frame.size) / 2
    origin, along = np.asarray(row.origin), row.along
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = np.sort([(-half - origin) / along, (half - origin) / along], axis=0)
    flat = along == 0
    if (flat & (np.abs(origin) > half)).any():
        return None
    near, far = float(np.where(flat, -np.inf, low).max()), float(np.where(flat, np.inf, high).min())
    return (near, far) if near < far else None
