"""Domain glare (ours): rows of lamps under a ceiling, mirrored in a smooth floor."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.light import Glare, Tube
from pavemark.plate import Plate
from pavemark.randomize.eyes import eyes
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within

_FAR = 14.0
"""Metres from the frame's middle up to which lamps hang: farther ones are mirrored at the frame's rim at most."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images with glare.
    ceiling, length, gap, rows : tuple of float
        Metres: how high lamps hang, how long they are, how far apart in a row, and how far row from row.
    radiance : tuple of float
        Linear light, 1 the picture's white.
    roughness, reflectance : tuple of float
        See `pavemark.light.Glare`.
    """

    rate: float = attrs.field(default=0.0, validator=within(0.0, 1.0))
    ceiling: tuple[float, float] = attrs.field(default=(2.4, 3.6), validator=interval(1.0, 20.0))
    length: tuple[float, float] = attrs.field(default=(0.6, 2.4), validator=interval(0.05, 20.0))
    gap: tuple[float, float] = attrs.field(default=(1.0, 5.0), validator=interval(0.1, 20.0))
    rows: tuple[float, float] = attrs.field(default=(4.0, 8.0), validator=interval(1.0, 30.0))
    radiance: tuple[float, float] = attrs.field(default=(15.0, 60.0), validator=interval(0.0, 1000.0))
    roughness: tuple[float, float] = attrs.field(default=(0.12, 0.35), validator=interval(0.01, 1.0))
    reflectance: tuple[float, float] = attrs.field(default=(0.03, 0.06), validator=interval(0.0, 1.0))


def sample(rng: np.random.Generator, ranges: Ranges, plate: Plate) -> Glare | None:
    """Draw the lamps that an image's floor mirrors, or none."""
    if not happens(rng, ranges.rate):
        return None
    ceiling, length, gap, rows = (uniform(rng, getattr(ranges, n)) for n in ("ceiling", "length", "gap", "rows"))
    brightness, tint = uniform(rng, ranges.radiance), rng.normal(0.0, 0.04, 2)
    radiance = tuple(float(brightness * math.exp(part)) for part in (tint[0], 0.0, tint[1]))
    # Rows run along the aisle or across it, hardly ever askew; lamps stand in line from row to row.
    turn = float(rng.choice([0.0, np.pi / 2]) + rng.normal(0.0, 0.03))
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    start = rng.random(2)
    places = [
        i * along + j * across
        for i in _spread(length + gap, start[0])
        for j in _spread(rows, start[1])
        if i * i + j * j < _FAR**2
    ]
    tubes = tuple(Tube((float(x), float(y), ceiling), length, 0.15, turn, radiance) for x, y in places)
    return Glare(tubes, uniform(rng, ranges.roughness), uniform(rng, ranges.reflectance), eyes(plate))


def _spread(step: float, start: float) -> np.ndarray:
    """Numbers a step apart, up to _FAR either way."""
    return np.arange(start * step - step * math.ceil(_FAR / step), _FAR, step)
