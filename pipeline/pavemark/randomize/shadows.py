"""Domain shadows (ours): what stands outside the frame and shades it, under the sun or a lamp."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from pavemark.ground import Frame
from pavemark.light import CASTERS, Caster, Lamp, Shadows, Sun
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, one_of, within

_SIZES: dict[str, tuple[tuple[float, float], ...]] = {
    "tree": ((3.0, 7.0), (3.0, 7.0), (4.0, 11.0)),
    "pole": ((0.1, 0.3), (0.1, 0.3), (3.0, 9.0)),
    "car": ((3.9, 5.0), (1.7, 2.0), (1.4, 2.0)),
    "roof": ((5.0, 16.0), (4.0, 6.0), (2.3, 4.0)),
}
"""Length, width and height in metres."""

_ROUND = {"tree", "pole"}

_TRIES = 200
"""Draws of a caster, before an image does without it: low things shade the frame from close by only."""

_MOST = 3
"""Casters of an image."""

_NEAR = 8.0
"""Metres beyond the frame's corners up to which things cast shadows: those of farther ones have lost their shape."""

_WITHIN = 0.8
"""Share of the frame, about its middle, in which the middle of a shadow ends."""

_LAMP = ((4.0, 9.0), (0.05, 0.25), (6.0, 14.0))
"""Height and radius of a lamp, and how far off the frame's middle it may hang: metres."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images with shadows of things outside the frame.
    lamp : float
        Share of those that a lamp casts, and not the sun.
    kinds : tuple of str
    left : tuple of float
        Share of the light that is left where its source is hidden.
    blue : tuple of float
        By how much more of its blue is left under the sun, and less of its red: the sky is blue.
    """

    rate: float = attrs.field(default=0.0, validator=within(0.0, 1.0))
    lamp: float = attrs.field(default=0.2, validator=within(0.0, 1.0))
    kinds: tuple[str, ...] = attrs.field(default=CASTERS, validator=one_of(*CASTERS))
    left: tuple[float, float] = attrs.field(default=(0.25, 0.55), validator=interval(0.0, 1.0))
    blue: tuple[float, float] = attrs.field(default=(0.0, 0.2), validator=interval(0.0, 1.0))

    @kinds.validator
    def _some(self, attribute: attrs.Attribute, value: tuple[str, ...]) -> None:
        if not value:
            raise ValueError("kinds is empty: at least one kind of caster is allowed")


def sample(rng: np.random.Generator, ranges: Ranges, frame: Frame, sun: Callable[[], Sun]) -> Shadows | None:
    """Draw the shadows of an image, or none; the sun is asked for only where it casts them."""
    if not happens(rng, ranges.rate):
        return None
    left, blue = uniform(rng, ranges.left), uniform(rng, ranges.blue)
    lamp = _lamp(rng) if happens(rng, ranges.lamp) else None
    shining = sun() if lamp is None else None
    count = 1 + int(rng.random() * _MOST)
    casters = tuple(filter(None, (_caster(rng, ranges.kinds, frame, shining or lamp) for _ in range(count))))
    if not casters:
        return None
    tint = (1 - blue, 1.0, 1 + blue) if lamp is None else (1.0, 1.0, 1.0)
    return Shadows(tuple(min(1.0, left * part) for part in tint), shining, lamp, casters)


def _lamp(rng: np.random.Generator) -> Lamp:
    height, radius, away = (uniform(rng, interval) for interval in _LAMP)
    turn = uniform(rng, (-np.pi, np.pi))
    return Lamp((float(away * np.cos(turn)), float(away * np.sin(turn)), height), radius)


def _caster(rng: np.random.Generator, kinds: tuple[str, ...], frame: Frame, source: Sun | Lamp) -> Caster | None:
    """Something that stands outside the frame and whose shadow reaches into it; None where none was found."""
    for _ in range(_TRIES):
        kind = kinds[int(rng.random() * len(kinds))]
        length, width, height = (uniform(rng, interval) for interval in _SIZES[kind])
        # A shadow that only grazes the frame's rim costs as much as one that shows.
        tip = _WITHIN * (rng.random(2) - 0.5) * frame.size
        turn, seed = uniform(rng, (-np.pi, np.pi)), int(rng.integers(2**31))
        foot = _foot(source, tip, height)
        if foot is None:
            continue
        reach = np.hypot(length, width) / 2 if kind not in _ROUND else max(length, width) / 2
        near = np.hypot(*foot) < np.hypot(*frame.size) / 2 + _NEAR
        if near and (np.abs(foot) > np.asarray(frame.size) / 2 + reach).any():
            return Caster(kind, (float(foot[0]), float(foot[1])), (length, width, height), turn, seed)
    return None


def _foot(source: Sun | Lamp, tip: np.ndarray, height: float) -> np.ndarray | None:
    """Where something of a height stands whose shadow ends at `tip` (2,); None where it would outgrow the lamp."""
    if isinstance(source, Sun):
        towards = np.array([np.cos(source.azimuth), np.sin(source.azimuth)])
        return tip + towards * height / np.tan(source.elevation)
    x, y, lamp = source.place
    if height > 0.9 * (lamp - source.radius):
        return None
    return (x, y) + (tip - (x, y)) * (1 - height / lamp)
