"""Domain stops: what wheels roll against at the far end of a slot, two blocks or a bar. No paint, and not labelled.

Detectors that never saw them take their corners and stripes for marking points.
"""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.randomize.colour import on_grey
from pavemark.randomize.row import Row
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within
from pavemark.scene import RGB, Area, Marking, Path

_share = within(0.0, 1.0)

_YELLOW: RGB = (3.2, 2.6, 0.7)
_WHITE: RGB = (3.0, 3.0, 3.0)
"""Ratios of stripes to the floor."""


@attrs.frozen
class Ranges:
    """What may be drawn. Lengths in metres.

    Attributes
    ----------
    rate : float
        Share of the images with slots, other than parallel ones, that have stops in them.
    bar : float
        Of those, share with a bar a slot rather than two blocks.
    striped : float
        Of those, share with yellow or white stripes.
    back : tuple of float
        From a stop to the slot's back line.
    block, bar_length : tuple of float
        Length across the slot of a block, and of a bar.
    deep : tuple of float
        Of both, along the slot.
    track : tuple of float
        Between the middles of two blocks.
    shade : tuple of float
        Reflectance over that of the ground: rubber is dark, concrete light.
    """

    rate: float = attrs.field(default=0.0, validator=_share)
    bar: float = attrs.field(default=0.35, validator=_share)
    striped: float = attrs.field(default=0.4, validator=_share)
    back: tuple[float, float] = attrs.field(default=(0.5, 1.4), validator=interval(0.0, 5.0))
    block: tuple[float, float] = attrs.field(default=(0.3, 0.6), validator=interval(0.05, 2.0))
    bar_length: tuple[float, float] = attrs.field(default=(1.5, 2.2), validator=interval(0.5, 5.0))
    deep: tuple[float, float] = attrs.field(default=(0.12, 0.3), validator=interval(0.05, 1.0))
    track: tuple[float, float] = attrs.field(default=(0.9, 1.4), validator=interval(0.3, 3.0))
    shade: tuple[float, float] = attrs.field(default=(0.15, 0.6), validator=interval(0.02, 20.0))


@attrs.frozen
class Stops:
    """The stops of an image's slots. Lengths in metres.

    Attributes
    ----------
    centres : tuple of float
        From the middle of a slot, across it.
    length, deep : float
        Of each, across the slot and along it.
    back : float
        From its middle to the slot's back line.
    shade : RGB
        Reflectance over that of the ground.
    stripes : RGB or None
        As `shade`.
    stripe : float
        Width of the stripes, and of what lies between them.
    """

    centres: tuple[float, ...]
    length: float
    deep: float
    back: float
    shade: RGB
    stripes: RGB | None
    stripe: float


def sample(rng: np.random.Generator, ranges: Ranges) -> Stops | None:
    """Draw the stops of an image, or none."""
    if not happens(rng, ranges.rate):
        return None
    bar, striped, yellow = rng.random(3) < (ranges.bar, ranges.striped, 0.7)
    track, shade = uniform(rng, ranges.track), uniform(rng, ranges.shade)
    return Stops(
        centres=(0.0,) if bar else (-track / 2, track / 2),
        length=uniform(rng, ranges.bar_length if bar else ranges.block),
        deep=uniform(rng, ranges.deep),
        back=uniform(rng, ranges.back),
        shade=(shade, shade, shade),
        stripes=(_YELLOW if yellow else _WHITE) if striped else None,
        stripe=uniform(rng, (0.1, 0.25)),
    )


def markings(stops: Stops, row: Row) -> tuple[Marking, ...]:
    """The stops of a row, and their stripes on them; none in parallel slots, where wheels roll along the kerb."""
    if row.shape.kind == "parallel":
        return ()
    centres = [(middle, across) for middle in row.middles for across in stops.centres]
    found = [_coat(stops.shade, [_ring(row, stops, *centre, 0.0, stops.length) for centre in centres])]
    if stops.stripes is not None:
        begins = np.arange(stops.stripe / 2, stops.length, 2 * stops.stripe).tolist()
        ends = [min(begin + stops.stripe, stops.length) for begin in begins]
        rings = [_ring(row, stops, *centre, *pair) for centre in centres for pair in zip(begins, ends, strict=True)]
        found.append(_coat(stops.stripes, rings))
    return tuple(found)


def _coat(ratio: RGB, rings: list[Path]) -> Marking:
    return Marking("stop", on_grey(ratio), areas=tuple(map(Area, rings)))


def _ring(row: Row, stops: Stops, middle: float, across: float, begin: float, end: float) -> Path:
    """A rectangle across a slot, square to it: between two distances from one end of a stop."""
    inwards = row.inwards
    sideways = np.array([inwards[1], -inwards[0]])
    centre = np.asarray(row.at(middle, row.shape.depth - stops.back)) + across * sideways
    near, far = -stops.deep / 2, stops.deep / 2
    corners = ((begin, near), (end, near), (end, far), (begin, far))
    points = [centre + (along - stops.length / 2) * sideways + deep * inwards for along, deep in corners]
    return tuple((float(x), float(y)) for x, y in points)
