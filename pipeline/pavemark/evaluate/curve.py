"""Precision and recall: at a confidence, at all of them, and what becomes of them over all."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.evaluate.tally import Tally

MOST = 1000
"""Rows of a curve that is drawn or written."""


@attrs.frozen
class Rates:
    """What is right and wrong of what was found with at least a certain confidence.

    Attributes
    ----------
    threshold : float
        That confidence.
    hits, false_positives, misses : int
    """

    threshold: float
    hits: int
    false_positives: int
    misses: int

    @property
    def precision(self) -> float:
        """The share of what was found that is there; NaN where nothing was found."""
        return float(share(self.hits, self.hits + self.false_positives))

    @property
    def recall(self) -> float:
        """The share of what is there that was found; NaN where nothing is there."""
        return float(share(self.hits, self.hits + self.misses))

    @property
    def f1(self) -> float:
        """The harmonic mean of both; NaN where nothing was found and nothing is there."""
        return float(share(2 * self.hits, 2 * self.hits + self.false_positives + self.misses))


@attrs.frozen(eq=False)
class Curve:
    """Precision and recall at every confidence that occurs, descending.

    Attributes
    ----------
    confidence, precision, recall, f1 : ndarray (K,) float64
        Recall is NaN where nothing is there.
    """

    confidence: np.ndarray
    precision: np.ndarray
    recall: np.ndarray
    f1: np.ndarray


def rates(tally: Tally, threshold: float) -> Rates:
    """Count what was found with at least that confidence."""
    kept = tally.confidence >= threshold
    hits = int((kept & tally.hit).sum())
    return Rates(threshold, hits, int(kept.sum()) - hits, int(tally.truths.sum()) - hits)


def curve(tally: Tally) -> Curve:
    """Precision and recall as the threshold falls: what is equally confident is found at once."""
    order, ends = steps(tally)
    hits = np.cumsum(tally.hit[order])[ends]
    truths = int(tally.truths.sum())
    recall = hits / truths if truths else np.full(len(ends), math.nan)
    return Curve(tally.confidence[order][ends], hits / (ends + 1), recall, 2 * hits / (ends + 1 + truths))


def thinned(whole: Curve) -> Curve:
    """A curve of at most `MOST` rows: evenly spread ones, the first and the last among them."""
    count = len(whole.confidence)
    rows = np.unique(np.linspace(0, count - 1, min(MOST, count)).round().astype(int))
    return Curve(*(values[rows] for values in (whole.confidence, whole.precision, whole.recall, whole.f1)))


def steps(tally: Tally) -> tuple[np.ndarray, np.ndarray]:
    """Positions of what was found, the most confident first, and where in them each run of equals ends."""
    order = np.argsort(-tally.confidence, kind="stable")
    sorted_ = tally.confidence[order]
    return order, np.flatnonzero(np.diff(sorted_, append=-math.inf))


def average_precision(tally: Tally) -> float:
    """The area under precision over recall, interpolated at all points (as PASCAL VOC does it from 2010 on).

    At each recall the precision is the best at that recall or a greater one, ``Σ (rₖ − rₖ₋₁) · max_{j ≥ k} pⱼ``. Recall
    that no threshold reaches counts as nought. NaN where nothing is there.
    """
    order, ends = steps(tally)
    hits = np.cumsum(tally.hit[order])[ends]
    return float(area(hits, ends + 1, int(tally.truths.sum())))


def area(hits: np.ndarray, found: np.ndarray, truths: np.ndarray | int) -> np.ndarray:
    """`average_precision` of hits and things found (..., K) as the threshold falls, and truths (...)."""
    precision = hits / np.maximum(found, 1)
    best = np.maximum.accumulate(precision[..., ::-1], axis=-1)[..., ::-1]
    return share((np.diff(hits, prepend=0) * best).sum(-1), truths)


def best_threshold(tally: Tally) -> float:
    """The confidence at which F1 is best, of equals the greatest; 1 where nothing was found.

    To be chosen on images that nothing is judged by.
    """
    along = curve(tally)
    return float(along.confidence[along.f1.argmax()]) if len(along.f1) else 1.0


def share(part: np.ndarray | float, whole: np.ndarray | int) -> np.ndarray:
    """Parts of wholes, of any shape; NaN where there is none."""
    return np.divide(
        part,
        whole,
        out=np.full(np.broadcast_shapes(np.shape(part), np.shape(whole)), math.nan),
        where=np.asarray(whole) > 0,
    )
