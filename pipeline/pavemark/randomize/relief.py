"""Domain relief (ours): paint that stands up from the ground, under the image's sun."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from pavemark.light import Relief, Sun
from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images whose paint is raised.
    height : tuple of float
        Metres: thermoplastic is laid on 2 to 5 mm thick.
    left : tuple of float
        Share of the light that does not come from the sun.
    """

    rate: float = attrs.field(default=0.0, validator=within(0.0, 1.0))
    height: tuple[float, float] = attrs.field(default=(0.002, 0.006), validator=interval(0.0005, 0.05))
    left: tuple[float, float] = attrs.field(default=(0.25, 0.5), validator=interval(0.0, 1.0))


def sample(rng: np.random.Generator, ranges: Ranges, sun: Callable[[], Sun]) -> Relief | None:
    """Draw the relief of an image's paint, or none; the sun is asked for only where there is some."""
    if not happens(rng, ranges.rate):
        return None
    height = uniform(rng, ranges.height)
    # Thermoplastic runs out at its rim, as far as it is high to twice that.
    return Relief(height, height * uniform(rng, (1.0, 2.0)), sun(), uniform(rng, ranges.left))
