"""Ground and markings of the judges' own: what is painted is known exactly, and nobody has to bring an image."""

from __future__ import annotations

import math

import cv2
import numpy as np

from pavemark.colour import quantise
from pavemark.ground import Frame
from pavemark.light import Caster, Shadows, Sun
from pavemark.plate import Plate
from pavemark.scene import (
    Area,
    Blend,
    Chips,
    Cracks,
    Curvature,
    Dirt,
    Grain,
    Marking,
    Paint,
    Path,
    Scene,
    Stroke,
    Wear,
)

TONE = 96
"""Display level of the ground, of asphalt in daylight."""

FRESH = Paint(rgb=(210.0, 210.0, 205.0), ratio=(2.4, 2.4, 2.3))
WORN = Paint(
    rgb=(210.0, 210.0, 205.0),
    ratio=(2.4, 2.4, 2.3),
    grain=Grain(size=0.02, contrast=0.2, seed=1.0),
    wear=Wear(amount=0.2, edge=0.03, edge_amount=0.4, tyre_amount=0.0, size=0.15, seed=2.0),
    chips=Chips(size=0.04, share=0.1, seed=3.0),
    cracks=Cracks(size=0.4, width=0.005, seed=4.0),
    dirt=Dirt(size=0.6, strength=0.3, seed=5.0),
)

BENT = Curvature(alpha=150.0, sigma=0.4, seed=1)

ENTRANCE, DEPTH, WIDTH = 2.43, 4.8, 0.1
"""Metres along a slot's entrance, along its separating lines, and across a line of paint. The first is no multiple of
the lengths that lines are cut into, or marking points would be met by chance."""


def asphalt(frame: Frame, texture: float = 0.0, seed: int = 0) -> Plate:
    """Bare ground: grain of two sizes, `texture` levels each, under light that falls off by a third from left to right.

    Without texture it is one even tone.
    """
    rng = np.random.default_rng(seed)
    image = np.full((frame.height, frame.width, 3), float(TONE))
    if texture:
        fine = rng.normal(0.0, texture, image.shape[:2])
        coarse = cv2.GaussianBlur(rng.normal(0.0, 1.0, image.shape[:2]), (0, 0), 4.0)
        grain = fine + texture * coarse / coarse.std()
        light = np.linspace(7 / 6, 5 / 6, frame.width)[None, :, None]
        image = (image + grain[..., None]) * light * (1.02, 1.0, 0.97)
    image = quantise(image)
    ground = np.ones(image.shape[:2], bool)
    return Plate("asphalt", frame, image, ground, ~ground, image)


def scattered(frame: Frame, paint: Paint, count: int = 12, seed: int = 7) -> Scene:
    """Bent lines of paint of all directions and widths, ends and crossings among them, colours absolute."""
    rng = np.random.default_rng(seed)
    reach = min(frame.size)
    strokes = []
    for _ in range(count):
        start, turn = rng.uniform(-0.4 * reach, 0.4 * reach, 2), rng.uniform(0, 2 * np.pi)
        end = start + rng.uniform(0.1, 0.6) * reach * np.array((np.cos(turn), np.sin(turn)))
        strokes.append(Stroke((_point(start), _point(end)), rng.uniform(0.08, 0.2)))
    marking = Marking("slot", paint, tuple(strokes))
    return Scene(0, asphalt(frame).ref, (marking,), curvature=BENT, blend=Blend("alpha"))


def shaded(frame: Frame, left: float) -> Shadows:
    """A tree and a pole beside the frame, in the sun: dappled shadow, and a straight one that grows softer."""
    reach = min(frame.size) / 2
    things = (
        Caster("tree", (-1.7 * reach, 0.4 * reach), (0.9 * reach, 0.9 * reach, 1.3 * reach)),
        Caster("pole", (-1.3 * reach, -0.5 * reach), (0.06 * reach, 0.06 * reach, 1.2 * reach)),
    )
    return Shadows((left, left, left), sun=Sun(azimuth=2.9, elevation=0.6), casters=things)


def row(slots: int = 3, turn: float = 0.0) -> tuple[Stroke, ...]:
    """The lines of a row of closed slots around the origin: its outline, and a line between each two slots.

    Parameters
    ----------
    slots : int
    turn : float
        Radians, anticlockwise.
    """
    corner = np.array((-slots * ENTRANCE / 2, -DEPTH / 2))
    across, along = np.array((ENTRANCE, 0.0)), np.array((0.0, DEPTH))
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])

    def path(*points: np.ndarray) -> Path:
        return tuple(_point(rotation @ point) for point in points)

    far = corner + slots * across
    lines = [Stroke(path(corner, far, far + along, corner + along), WIDTH, closed=True)]
    for k in range(1, slots):
        lines.append(Stroke(path(corner + k * across, corner + k * across + along), WIDTH))
    return tuple(lines)


def marking_points(slots: int = 3, turn: float = 0.0) -> np.ndarray:
    """Where lines of `row` meet: (2 · slots + 2, 2), metres."""
    x, y = np.meshgrid(np.arange(slots + 1) * ENTRANCE - slots * ENTRANCE / 2, (-DEPTH / 2, DEPTH / 2))
    points = np.stack([x.ravel(), y.ravel()], -1)
    return points @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])


def block(width: float, height: float) -> Area:
    """A filled rectangle around the origin, metres."""
    x, y = width / 2, height / 2
    return Area(((-x, -y), (x, -y), (x, y), (-x, y)))


def _point(point: np.ndarray) -> tuple[float, float]:
    return float(point[0]), float(point[1])
