"""Domain wet (ours): wet patches and puddles."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.colour import LINEAR
from pavemark.light import Wet
from pavemark.plate import Plate
from pavemark.randomize.eyes import eyes
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within

ASPHALT = 0.2
"""Share of the light that ground sends back, on the mean: so much brighter than the ground is a grey sky."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images with wet ground.
    share, pools, size, darkening : tuple of float
        See `pavemark.light.Wet`.
    sky : tuple of float
        Radiance of the sky over that of a white sheet on the ground.
    around : tuple of float
        Radiance of what stands around, over the sky's.
    skyline : tuple of float
        Degrees up to which it stands.
    """

    rate: float = attrs.field(default=0.0, validator=within(0.0, 1.0))
    share: tuple[float, float] = attrs.field(default=(0.1, 0.9), validator=interval(0.0, 1.0))
    pools: tuple[float, float] = attrs.field(default=(0.0, 0.5), validator=interval(0.0, 1.0))
    size: tuple[float, float] = attrs.field(default=(0.8, 4.0), validator=interval(0.05, 20.0))
    darkening: tuple[float, float] = attrs.field(default=(0.25, 0.55), validator=interval(0.0, 1.0))
    sky: tuple[float, float] = attrs.field(default=(0.5, 1.2), validator=interval(0.0, 20.0))
    around: tuple[float, float] = attrs.field(default=(0.05, 0.4), validator=interval(0.0, 5.0))
    skyline: tuple[float, float] = attrs.field(default=(5.0, 30.0), validator=interval(0.0, 90.0))


def sample(rng: np.random.Generator, ranges: Ranges, plate: Plate) -> Wet | None:
    """Draw where an image's ground is wet, or that none is."""
    if not happens(rng, ranges.rate):
        return None
    ground = LINEAR[plate.image[plate.ground]] if plate.ground.any() else LINEAR[plate.image]
    white = float(np.median(ground)) / ASPHALT
    sky = uniform(rng, ranges.sky) * white
    around = uniform(rng, ranges.around) * sky
    return Wet(
        share=uniform(rng, ranges.share),
        pools=uniform(rng, ranges.pools),
        size=uniform(rng, ranges.size),
        darkening=uniform(rng, ranges.darkening),
        sky=(sky, sky, sky),
        around=(around, around, around),
        skyline=math.radians(uniform(rng, ranges.skyline)),
        eyes=eyes(plate),
        seed=1000.0 * rng.random(),
    )
