"""How far a figure would swing, had other images of the same kind been judged: bootstrap intervals."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence

import numpy as np

from pavemark.evaluate.curve import area, share, steps
from pavemark.evaluate.tally import Tally

DRAWS = 1000

TOGETHER = 1 << 14
"""Numbers that are looked at at once: small sets are drawn a thousand times in one go, large ones take no memory."""

LEVEL = 0.95

FIGURES = ("precision", "recall", "f1", "average_precision")


def resampled(
    tally: Tally, threshold: float, clusters: Sequence[Hashable], draws: int = DRAWS, seed: int = 0
) -> dict[str, np.ndarray]:
    """Figures of images drawn anew, with replacement, as many clusters as there are.

    What is drawn follows from the seed and the clusters' names, whatever the order of the images and whatever was found
    in them: two detectors judged by the same images are drawn alike, and the difference of their figures, draw by
    draw, has an interval too.

    Parameters
    ----------
    tally : Tally
    threshold : float
        For precision, recall and F1.
    clusters : sequence
        For each image what it is drawn with, as `Judged.clusters` tells it. Images of one place or one plate are alike,
        and to draw them apart makes intervals too narrow.
    draws : int
    seed : int

    Returns
    -------
    dict of str to ndarray (draws,)
        "precision", "recall", "f1" and "average_precision"; NaN where a draw has none.
    """
    names = sorted(set(clusters))
    number = {name: k for k, name in enumerate(names)}
    cluster = np.array([number[name] for name in clusters], np.int64)
    count = len(names)
    order, ends = steps(tally)
    hit, of = tally.hit[order], cluster[tally.image[order]]
    kept = tally.confidence[order] >= threshold
    # Where nothing is right precision only falls: steps with a hit are enough for the area.
    right_ones = np.flatnonzero(hit)
    step = np.searchsorted(ends, right_ones)
    last = np.flatnonzero(np.diff(step, append=len(ends)))
    rows = ends[step[last]]
    truths = np.bincount(cluster, tally.truths, count).astype(np.int64)
    found = np.bincount(of[kept], minlength=count)
    hits = np.bincount(of[kept & hit], minlength=count)
    rng = np.random.Generator(np.random.PCG64(seed))
    figures = np.full((len(FIGURES), draws), math.nan)
    together = max(1, TOGETHER // max(count, len(of)))
    for first in range(0, draws, together):
        block = slice(first, min(first + together, draws))
        times = _times(rng, count, block.stop - block.start)
        there, right, told = (times @ sums for sums in (truths, hits, found))
        weight = times[:, of]
        figures[:, block] = (
            share(right, told),
            share(right, there),
            share(2 * right, told + there),
            area(weight[:, right_ones].cumsum(1)[:, last], weight.cumsum(1)[:, rows], there),
        )
    return dict(zip(FIGURES, figures, strict=True))


def _times(rng: np.random.Generator, count: int, draws: int) -> np.ndarray:
    """How often each of `count` clusters is drawn, (draws, count)."""
    drawn = rng.integers(count, size=(draws, count)) + count * np.arange(draws)[:, None]
    return np.bincount(drawn.ravel(), minlength=draws * count).reshape(draws, count)


def interval(values: np.ndarray, level: float = LEVEL) -> tuple[float, float] | None:
    """The percentile interval of draws (D,); those that are NaN are left out, and None where all are."""
    values = values[~np.isnan(values)]
    if not len(values):
        return None
    low, high = np.quantile(values, [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)
