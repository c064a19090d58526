"""Domain brightness: the illumination channel of the whole image."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.randomize.streams import happens, uniform
from pavemark.records import interval, within
from pavemark.scene import Brightness


@attrs.frozen
class Ranges:
    """What may be drawn: `rate`, the share of images that are changed; `factor` on the illumination."""

    rate: float = attrs.field(default=0.5, validator=within(0.0, 1.0))
    factor: tuple[float, float] = attrs.field(default=(0.5, 1.5), validator=interval(0.0, 10.0))


def sample(rng: np.random.Generator, ranges: Ranges) -> Brightness | None:
    """Draw the brightness of an image, or none."""
    if not happens(rng, ranges.rate):
        return None
    return Brightness(uniform(rng, ranges.factor))
