"""Domain texture: what time and hand do to the paint of a marking.

One age drives an image: old paint is worn and chipped and cracked and dirty together, and hides less of its ground.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.randomize import former, tyres
from pavemark.randomize.streams import Stage, happens, stream, uniform
from pavemark.records import interval, one_of, within
from pavemark.scene import PATTERNS, Chips, Cracks, Dirt, Grain, Paint, Pattern, Wear

_AGED = 0.7
"""Share of an amount that the age of the image decides; chance decides the rest."""


@attrs.frozen
class GrainRanges:
    """Fine roughness, as `pavemark.scene.Grain`; `rate` is the share of markings that have it."""

    rate: float = attrs.field(default=0.8, validator=within(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.01, 0.05), validator=interval(0.001, 1.0))
    contrast: tuple[float, float] = attrs.field(default=(0.03, 0.2), validator=interval(0.0, 1.0))


@attrs.frozen
class WearRanges:
    """Paint rubbed off, as `pavemark.scene.Wear`; the amounts follow the age."""

    rate: float = attrs.field(default=0.8, validator=within(0.0, 1.0))
    amount: tuple[float, float] = attrs.field(default=(0.0, 0.15), validator=interval(0.0, 1.0))
    edge: tuple[float, float] = attrs.field(default=(0.01, 0.04), validator=interval(0.001, 1.0))
    edge_amount: tuple[float, float] = attrs.field(default=(0.0, 0.25), validator=interval(0.0, 1.0))
    tyre_amount: tuple[float, float] = attrs.field(default=(0.0, 0.3), validator=interval(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.02, 0.4), validator=interval(0.005, 2.0))


@attrs.frozen
class ChipsRanges:
    """Flakes broken out, as `pavemark.scene.Chips`; the share follows the age."""

    rate: float = attrs.field(default=0.4, validator=within(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.01, 0.06), validator=interval(0.005, 1.0))
    share: tuple[float, float] = attrs.field(default=(0.01, 0.06), validator=interval(0.0, 1.0))


@attrs.frozen
class CracksRanges:
    """A network of cracks, as `pavemark.scene.Cracks`; the width follows the age."""

    rate: float = attrs.field(default=0.3, validator=within(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.1, 0.6), validator=interval(0.02, 5.0))
    width: tuple[float, float] = attrs.field(default=(0.001, 0.01), validator=interval(0.0005, 0.1))


@attrs.frozen
class DirtRanges:
    """Dust and rubber, as `pavemark.scene.Dirt`; the strength follows the age."""

    rate: float = attrs.field(default=0.6, validator=within(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.2, 2.0), validator=interval(0.01, 10.0))
    strength: tuple[float, float] = attrs.field(default=(0.05, 0.5), validator=interval(0.0, 1.0))


@attrs.frozen
class PatternRanges:
    """A regular pattern, as `pavemark.scene.Pattern`; angle in radians."""

    rate: float = attrs.field(default=0.1, validator=within(0.0, 1.0))
    kinds: tuple[str, ...] = attrs.field(default=PATTERNS, validator=one_of(*PATTERNS))
    size: tuple[float, float] = attrs.field(default=(0.05, 0.4), validator=interval(0.01, 5.0))
    angle: tuple[float, float] = attrs.field(default=(0.0, math.pi), validator=interval(-7.0, 7.0))
    strength: tuple[float, float] = attrs.field(default=(0.1, 0.4), validator=interval(0.0, 1.0))

    @kinds.validator
    def _some(self, attribute: attrs.Attribute, value: tuple[str, ...]) -> None:
        if not value:
            raise ValueError("kinds is empty: at least one pattern is allowed")


@attrs.frozen
class FadeRanges:
    """Paint that no longer hides all of its ground: `pavemark.scene.Paint.opacity`; it falls with the age."""

    rate: float = attrs.field(default=0.8, validator=within(0.0, 1.0))
    opacity: tuple[float, float] = attrs.field(default=(0.75, 1.0), validator=interval(0.05, 1.0))


@attrs.frozen
class Ranges:
    """What may be drawn: a table an effect, and `age`, 0 fresh to 1 old."""

    age: tuple[float, float] = attrs.field(default=(0.0, 1.0), validator=interval(0.0, 1.0))
    grain: GrainRanges = attrs.field(factory=GrainRanges)
    wear: WearRanges = attrs.field(factory=WearRanges)
    chips: ChipsRanges = attrs.field(factory=ChipsRanges)
    cracks: CracksRanges = attrs.field(factory=CracksRanges)
    dirt: DirtRanges = attrs.field(factory=DirtRanges)
    pattern: PatternRanges = attrs.field(factory=PatternRanges)
    fade: FadeRanges = attrs.field(factory=FadeRanges)
    former: former.Ranges = attrs.field(factory=former.Ranges)
    tyres: tyres.Ranges = attrs.field(factory=tyres.Ranges)


def sample_age(job_seed: int, index: int, ranges: Ranges) -> float:
    """Draw the age of an image's paint, 0 fresh to 1 old."""
    return uniform(stream(job_seed, index, Stage.TEXTURE, 0), ranges.age)


def sample(job_seed: int, index: int, marking: int, ranges: Ranges, paint: Paint, age: float) -> Paint:
    """Draw the texture of a marking; every effect draws from a stream of its own.

    Parameters
    ----------
    marking : int
        Number of the marking in its image.
    paint : Paint
        Its colour.
    age : float
        0 fresh to 1 old.
    """
    drawn = {}
    for number, (name, effect) in enumerate(_EFFECTS.items()):
        rng = stream(job_seed, index, Stage.TEXTURE, 1, marking, number)
        of = getattr(ranges, name)
        if happens(rng, of.rate):
            drawn[name] = effect(rng, of, age)
    fade = drawn.pop("fade", 1.0)
    return attrs.evolve(paint, opacity=fade, **drawn)


def _aged(rng: np.random.Generator, age: float, interval: tuple[float, float]) -> float:
    low, high = interval
    return low + (high - low) * (_AGED * age + (1 - _AGED) * rng.random())


def _w(rng: np.random.Generator) -> float:
    """A seed for procedural noise: its fourth coordinate."""
    return 1000.0 * rng.random()


def _grain(rng: np.random.Generator, ranges: GrainRanges, age: float) -> Grain:
    return Grain(uniform(rng, ranges.size), uniform(rng, ranges.contrast), _w(rng))


def _wear(rng: np.random.Generator, ranges: WearRanges, age: float) -> Wear:
    return Wear(
        amount=_aged(rng, age, ranges.amount),
        edge=uniform(rng, ranges.edge),
        edge_amount=_aged(rng, age, ranges.edge_amount),
        tyre_amount=_aged(rng, age, ranges.tyre_amount),
        size=uniform(rng, ranges.size),
        seed=_w(rng),
    )


def _chips(rng: np.random.Generator, ranges: ChipsRanges, age: float) -> Chips:
    return Chips(uniform(rng, ranges.size), _aged(rng, age, ranges.share), _w(rng))


def _cracks(rng: np.random.Generator, ranges: CracksRanges, age: float) -> Cracks:
    return Cracks(uniform(rng, ranges.size), _aged(rng, age, ranges.width), _w(rng))


def _dirt(rng: np.random.Generator, ranges: DirtRanges, age: float) -> Dirt:
    return Dirt(uniform(rng, ranges.size), _aged(rng, age, ranges.strength), _w(rng))


def _pattern(rng: np.random.Generator, ranges: PatternRanges, age: float) -> Pattern:
    kind = ranges.kinds[int(rng.random() * len(ranges.kinds))]
    return Pattern(kind, uniform(rng, ranges.size), uniform(rng, ranges.angle), uniform(rng, ranges.strength), _w(rng))


def _fade(rng: np.random.Generator, ranges: FadeRanges, age: float) -> float:
    low, high = ranges.opacity
    return _aged(rng, age, (high, low))


# The order numbers the streams: new effects go to the end.
_EFFECTS = {
    "grain": _grain,
    "wear": _wear,
    "chips": _chips,
    "cracks": _cracks,
    "dirt": _dirt,
    "pattern": _pattern,
    "fade": _fade,
}
