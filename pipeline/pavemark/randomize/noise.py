"""Domain noise: the sensor's, over the whole image."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.randomize.streams import happens, seed, uniform
from pavemark.records import interval, one_of, within
from pavemark.scene import Noise

KINDS = ("gaussian", "laplacian", "salt-and-pepper")


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of images with noise.
    kinds : tuple of str
    level : tuple of float
        Standard deviation of Gaussian and Laplacian noise, 8-bit levels.
    share : tuple of float
        Share of pixels that salt and pepper hit.
    """

    rate: float = attrs.field(default=0.3, validator=within(0.0, 1.0))
    kinds: tuple[str, ...] = attrs.field(default=KINDS, validator=one_of(*KINDS))
    level: tuple[float, float] = attrs.field(default=(1.0, 8.0), validator=interval(0.0, 128.0))
    share: tuple[float, float] = attrs.field(default=(0.0005, 0.01), validator=interval(0.0, 1.0))

    @kinds.validator
    def _some(self, attribute: attrs.Attribute, value: tuple[str, ...]) -> None:
        if not value:
            raise ValueError("kinds is empty: at least one kind of noise is allowed")


def sample(rng: np.random.Generator, ranges: Ranges) -> Noise | None:
    """Draw the noise of an image, or none."""
    if not happens(rng, ranges.rate):
        return None
    kind = ranges.kinds[int(rng.random() * len(ranges.kinds))]
    amount = uniform(rng, ranges.share if kind == "salt-and-pepper" else ranges.level)
    return Noise(kind, amount, seed(rng))
