"""Domain optics (ours, not the paper's): the blur of the cameras, which the markings suffer as the plate did."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.randomize.streams import happens
from pavemark.records import within
from pavemark.scene import Optics

Blur = tuple[tuple[float, ...], ...]


@attrs.frozen
class Ranges:
    """What may be drawn: `rate`, the share of images whose markings are blurred as their plate is."""

    rate: float = attrs.field(default=1.0, validator=within(0.0, 1.0))


def sample(rng: np.random.Generator, ranges: Ranges, blur: Blur | None) -> Optics | None:
    """Draw whether an image has optics.

    Parameters
    ----------
    blur : tuple of tuple of float, or None
        What was measured on the plate, as in `pavemark.scene.Optics`; without it there is none.
    """
    if blur is None or not happens(rng, ranges.rate):
        return None
    return Optics(blur)
