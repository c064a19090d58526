"""Where the sun stands: one sun an image, whichever effects ask for it."""

from __future__ import annotations

import math

import attrs

from pavemark.light import Sun
from pavemark.randomize.streams import Stage, stream, uniform
from pavemark.records import interval


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    azimuth : tuple of float
        Degrees anticlockwise from the picture's right.
    elevation : tuple of float
        Degrees above the horizon.
    angle : tuple of float
        Degrees across: 0.53 in clear air, more in haze.
    """

    azimuth: tuple[float, float] = attrs.field(default=(-180.0, 180.0), validator=interval(-360.0, 360.0))
    elevation: tuple[float, float] = attrs.field(default=(12.0, 60.0), validator=interval(3.0, 90.0))
    angle: tuple[float, float] = attrs.field(default=(0.53, 2.0), validator=interval(0.0, 28.0))


def sample(job_seed: int, index: int, ranges: Ranges) -> Sun:
    """Draw the sun of an image."""
    rng = stream(job_seed, index, Stage.SUN)
    return Sun(
        azimuth=math.radians(uniform(rng, ranges.azimuth)),
        elevation=math.radians(uniform(rng, ranges.elevation)),
        angle=math.radians(uniform(rng, ranges.angle)),
    )
