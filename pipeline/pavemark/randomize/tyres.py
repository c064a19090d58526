"""Texture: the tracks of wheels, along the aisle and into slots, where paint wears and rubber stays."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.randomize.row import Row
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within
from pavemark.scene import Path, Tyres

_POINTS = 9
"""Points of a track into a slot: its arc of a few metres is then true to a centimetre."""

_MOST = 4
"""Cars at most whose tracks show."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images with tracks.
    track : tuple of float
        Metres between the wheels of an axle.
    width : tuple of float
        Metres across a tyre.
    aisle : tuple of float
        Metres from the entrance line to the middle of the car that drives along.
    """

    rate: float = attrs.field(default=0.5, validator=within(0.0, 1.0))
    track: tuple[float, float] = attrs.field(default=(1.4, 1.65), validator=interval(0.5, 3.0))
    width: tuple[float, float] = attrs.field(default=(0.16, 0.24), validator=interval(0.05, 1.0))
    aisle: tuple[float, float] = attrs.field(default=(1.5, 3.0), validator=interval(0.5, 10.0))


@attrs.frozen
class Car:
    """Where a car drove: along the aisle, or in a quarter turn into the slot number `place` · (number of slots)."""

    parks: bool
    place: float
    aisle: float
    track: float


@attrs.frozen
class Traffic:
    """The cars that left tracks, and the width of their tyres in metres."""

    cars: tuple[Car, ...]
    width: float


def sample(rng: np.random.Generator, ranges: Ranges) -> Traffic | None:
    """Draw the traffic of an image, or none."""
    if not happens(rng, ranges.rate):
        return None
    cars = tuple(
        Car(bool(rng.random() < 0.7), rng.random(), uniform(rng, ranges.aisle), uniform(rng, ranges.track))
        for _ in range(1 + int(rng.random() * _MOST))
    )
    return Traffic(cars, uniform(rng, ranges.width))


def tyres(traffic: Traffic, rows: tuple[Row, ...]) -> Tyres:
    """The tracks of the traffic beside and into the rows, of which there is at least one."""
    tracks = []
    for number, car in enumerate(traffic.cars):
        row = rows[number % len(rows)]
        if car.parks:
            tracks += _into(row, car)
        else:
            tracks += _past(row, car)
    return Tyres(tuple(tracks), traffic.width)


def _past(row: Row, car: Car) -> list[Path]:
    first, last = row.stretches[0][0] - 10.0, row.stretches[-1][-1] + 10.0
    paths = []
    for side in (-0.5, 0.5):
        ends = np.array([row.at(first), row.at(last)]) - (car.aisle + side * car.track) * row.normal
        paths.append(_path(ends))
    return paths


def _into(row: Row, car: Car) -> list[Path]:
    """A car that turns from the aisle into a slot and stops at its end: a Bézier curve, then straight."""
    middle = row.middles[int(car.place * len(row.middles))]
    # Cars enter slanted slots in the direction in which they lean.
    way = 1.0 if row.inwards @ row.along >= 0 else -1.0
    inwards = row.inwards if row.shape.kind != "parallel" else 0.5 * row.normal + way * math.sqrt(0.75) * row.along
    gate = np.asarray(row.at(middle))
    start = gate - car.aisle * row.normal - 5.0 * way * row.along
    bend = gate - car.aisle * row.normal - 1.0 * way * row.along
    t = np.linspace(0.0, 1.0, _POINTS)[:, None]
    arc = (1 - t) ** 2 * start + 2 * t * (1 - t) * bend + t**2 * (gate + 0.5 * inwards)
    centre = np.concatenate([arc, [gate + 0.8 * row.shape.depth * inwards]])
    heading = np.gradient(centre, axis=0)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    left = np.stack([-heading[:, 1], heading[:, 0]], 1) * car.track / 2
    return [_path(centre + left), _path(centre - left)]


def _path(points: np.ndarray) -> Path:
    return tuple((float(x), float(y)) for x, y in points)
