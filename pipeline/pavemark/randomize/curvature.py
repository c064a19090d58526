"""Domain curvature: the elastic deformation of the markings."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.randomize.streams import happens, seed, uniform
from pavemark.records import interval, within
from pavemark.scene import Curvature


@attrs.frozen
class Ranges:
    """What may be drawn: `rate`, the share of images that are bent; `alpha` and `sigma` as in the scene's Curvature."""

    rate: float = attrs.field(default=0.5, validator=within(0.0, 1.0))
    alpha: tuple[float, float] = attrs.field(default=(100.0, 200.0), validator=interval(0.0, 1000.0))
    sigma: tuple[float, float] = attrs.field(default=(0.3, 1.2), validator=interval(0.02, 5.0))


def sample(rng: np.random.Generator, ranges: Ranges) -> Curvature | None:
    """Draw the curvature of an image, or none."""
    if not happens(rng, ranges.rate):
        return None
    return Curvature(uniform(rng, ranges.alpha), uniform(rng, ranges.sigma), seed(rng))
