"""Random streams: one for each stage of each image, so that no draw depends on any other.

Image i of a job draws the same whatever the shard, the workers or the order; a stage that is switched off, or that
draws more or fewer numbers than before, moves no other.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Stage(IntEnum):
    """What is drawn. The numbers are part of every seed: they are never given away again."""

    LAYOUT = 0
    SHAPE = 1
    COLOUR = 2
    TEXTURE = 3
    NOISE = 4
    CURVATURE = 5
    BRIGHTNESS = 6
    OPTICS = 7
    SYMBOL = 8
    FORMER = 9
    TYRES = 10
    SUN = 11
    RELIEF = 12
    SHADOWS = 13
    WET = 14
    GLARE = 15
    AISLE = 16
    STOPS = 17


def stream(job_seed: int, index: int, stage: Stage, *children: int) -> np.random.Generator:
    """The random generator of one stage of one image.

    Parameters
    ----------
    job_seed : int
        Not negative.
    index : int
        Number of the image in its job.
    stage : Stage
    children : int
        Number of the row, the marking, the effect or the attempt, where a stage draws for several.

    Examples
    --------
    >>> stream(7, 3, Stage.NOISE).random() == stream(7, 3, Stage.NOISE).random()
    True
    """
    key = (index, int(stage), *children)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(job_seed, spawn_key=key)))


def seed(rng: np.random.Generator) -> int:
    """A seed for a field that is drawn later, 0 to 2⁶³ - 1."""
    return int(rng.integers(2**63, dtype=np.uint64))


def happens(rng: np.random.Generator, rate: float) -> bool:
    """Whether something happens that does so at a rate, 0 to 1; where it never does, nothing is drawn."""
    return rate > 0 and rng.random() < rate


def uniform(rng: np.random.Generator, interval: tuple[float, float]) -> float:
    """A number drawn evenly from an interval."""
    low, high = interval
    return low + (high - low) * rng.random()


def weighted(rng: np.random.Generator, weights: dict[str, float]) -> str:
    """A word drawn with the given weights, of which at least one is positive; one draw."""
    words = list(weights)
    bounds = np.cumsum([weights[word] for word in words])
    return words[int(np.searchsorted(bounds, rng.random() * bounds[-1], side="right"))]


def quantile(rng: np.random.Generator, table: tuple[float, ...]) -> float:
    """A number drawn from a distribution given by its quantiles at equal steps of probability."""
    return float(np.interp(rng.random(), np.linspace(0.0, 1.0, len(table)), table))
