"""Texture: a former coat, older lines that show below the new ones, a little off them."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.randomize.row import Row, strokes
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within
from pavemark.scene import Marking, Paint, Wear


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of rows with a former coat.
    along, inwards : tuple of float
        Metres by which the old lines lie off the new ones, along the entrance line and across it.
    turn : tuple of float
        Degrees by which they are turned.
    stretch : tuple of float
        Old entrance lengths over the new ones: 1 is the same layout, anything else another one.
    opacity, wear : tuple of float
        What is left of the old paint: see `pavemark.scene.Paint` and `Wear`.
    """

    rate: float = attrs.field(default=0.15, validator=within(0.0, 1.0))
    along: tuple[float, float] = attrs.field(default=(-0.5, 0.5), validator=interval(-5.0, 5.0))
    inwards: tuple[float, float] = attrs.field(default=(-0.3, 0.3), validator=interval(-5.0, 5.0))
    turn: tuple[float, float] = attrs.field(default=(-1.5, 1.5), validator=interval(-20.0, 20.0))
    stretch: tuple[float, float] = attrs.field(default=(0.9, 1.1), validator=interval(0.5, 2.0))
    opacity: tuple[float, float] = attrs.field(default=(0.25, 0.5), validator=interval(0.0, 1.0))
    wear: tuple[float, float] = attrs.field(default=(0.4, 0.75), validator=interval(0.0, 1.0))


@attrs.frozen
class Former:
    """An older coat of a row, in the units of `Ranges` but for `turn` in radians."""

    along: float
    inwards: float
    turn: float
    stretch: float
    opacity: float
    wear: Wear


def sample(rng: np.random.Generator, ranges: Ranges) -> Former | None:
    """Draw the former coat of a row, or none."""
    if not happens(rng, ranges.rate):
        return None
    return Former(
        along=uniform(rng, ranges.along),
        inwards=uniform(rng, ranges.inwards),
        turn=math.radians(uniform(rng, ranges.turn)),
        stretch=uniform(rng, ranges.stretch),
        opacity=uniform(rng, ranges.opacity),
        wear=Wear(uniform(rng, ranges.wear), 0.03, 0.5, 0.5, uniform(rng, (0.05, 0.4)), 1000.0 * rng.random()),
    )


def marking(former: Former, row: Row, paint: Paint) -> Marking:
    """The former coat of a row, as paint below it.

    Parameters
    ----------
    paint : Paint
        The colour of the old paint.
    """
    old = attrs.evolve(
        row,
        origin=row.at(former.along, former.inwards),
        heading=row.heading + former.turn,
        stretches=tuple(tuple(s * former.stretch for s in stretch) for stretch in row.stretches),
    )
    return Marking("former", attrs.evolve(paint, opacity=former.opacity, wear=former.wear), strokes(old))
