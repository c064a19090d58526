"""A slot from three points: the two marking points of its entrance, and how deep it is."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.errors import InputError
from pavemark.randomize import row
from pavemark.randomize.shape import Shape
from pavemark.scene import Marking, Paint, Point, Scene, Slot

NEAR = 0.15
"""Metres within which a click means a marking point that is there."""

RIGHT_ANGLE = math.radians(8.0)
"""Separating lines within it of a right angle are meant to be at one; it is what a hand is off by."""

LEG = 0.4
"""Metres of the strokes at the marking points of a "corner" outline."""


def snapped(scene: Scene | None, point: Point) -> Point:
    """The marking point near a click, or the click itself."""
    there = [corner for slot in (scene.slots if scene else ()) for corner in slot.corners[:2]]
    nearest = min(there, key=lambda corner: math.dist(corner, point), default=None)
    return nearest if nearest is not None and math.dist(nearest, point) < NEAR else point


def with_slot(scene: Scene, points: tuple[Point, Point, Point], outline: str, line: float, paint: Paint) -> Scene:
    """A scene with one more slot, a marking of its own on top.

    Parameters
    ----------
    points : tuple of 3 Point
        The ends of the entrance line in either order, and a point of the back line. World, metres.
    outline : str
        As in `pavemark.scene.Slot`.
    line : float
        Metres across its lines.
    paint : Paint

    Raises
    ------
    InputError
        When the points make no slot.
    """
    (first, second), behind = (np.array(snapped(scene, point)) for point in points[:2]), np.array(points[2])
    entrance = second - first
    length, side = float(np.hypot(*entrance)), _cross(entrance, behind - first)
    if length < 0.5 or abs(side) < 0.5 * length:
        raise InputError("New slot", "entrance and depth of at least 0.5 m are allowed")
    if side < 0:  # the slot lies to the left of p1 → p2
        first, second, entrance = second, first, -entrance
    middle = behind - (first + second) / 2
    angle = math.atan2(_cross(entrance, middle), float(entrance @ middle))
    depth = float(np.hypot(*middle))
    if abs(angle - math.pi / 2) < RIGHT_ANGLE:
        depth, angle = depth * math.sin(angle), math.pi / 2
    kind = "parallel" if length > depth else "perpendicular"
    shape = Shape(
        kind=kind if angle == math.pi / 2 else "slanted",
        outline=outline,
        family=kind,
        entrance=length,
        depth=depth,
        angle=angle,
        line=line,
        leg=LEG,
        separator=depth,
        back=outline == "closed",
        tee=0.0,
    )
    made = row.Row(shape, _point(first), math.atan2(entrance[1], entrance[0]), ((0.0, length),))
    (slot,) = row.slots(made)
    corners = (_point(first), _point(second), *slot.corners[2:])
    slots = [*scene.slots, attrs.evolve(slot, corners=corners)]
    return attrs.evolve(
        scene,
        markings=(*scene.markings, Marking("slot", paint, row.strokes(made))),
        slots=tuple(_joined(slot, slots) for slot in slots),
    )


def _joined(slot: Slot, slots: list[Slot]) -> Slot:
    """The slot with T marks where another one shares its marking point: there the entrance line goes on."""
    others = [corner for other in slots if other is not slot for corner in other.corners[:2]]
    marks = tuple(
        "T" if any(math.dist(corner, other) < 1e-3 for other in others) else mark
        for corner, mark in zip(slot.corners[:2], slot.marks, strict=True)
    )
    return attrs.evolve(slot, marks=marks)


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _point(point: np.ndarray) -> Point:
    return float(point[0]), float(point[1])
