"""The figures of a detector on a set of images, with what they would swing by, for people and for programs."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from typing import Any

import attrs

from pavemark.evaluate.bootstrap import DRAWS, FIGURES, interval, resampled
from pavemark.evaluate.curve import average_precision, curve, rates, thinned
from pavemark.evaluate.tally import Tally

HEADINGS = {"precision": "precision", "recall": "recall", "f1": "F1", "average_precision": "AP"}


@attrs.frozen
class Result:
    """How well things of one kind, points or slots, were found.

    Attributes
    ----------
    images, truths : int
        How many were looked at, and how many things there are in them.
    threshold : float
        The least confidence of what counts, but for average precision.
    hits, false_positives, misses : int
    precision, recall, f1, average_precision : float
        0 to 1; NaN where there is none, as the precision where nothing was found.
    intervals : dict of str to (float, float) or None
        95 % bootstrap intervals of the four; None where there is none, as for a single image.
    """

    images: int
    truths: int
    threshold: float
    hits: int
    false_positives: int
    misses: int
    precision: float
    recall: float
    f1: float
    average_precision: float
    intervals: dict[str, tuple[float, float] | None]


def result(tally: Tally, threshold: float, clusters: Sequence[Hashable], draws: int = DRAWS, seed: int = 0) -> Result:
    """The figures of what was found, and their bootstrap intervals.

    Parameters
    ----------
    tally : Tally
        `Judged.points` or `Judged.slots`.
    threshold : float
    clusters, draws, seed
        As `pavemark.evaluate.bootstrap.resampled` takes them; `Judged.clusters()` draws image by image.
    """
    found = rates(tally, threshold)
    intervals: dict[str, tuple[float, float] | None] = dict.fromkeys(FIGURES)
    # One cluster says nothing of how clusters differ.
    if len(set(clusters)) > 1:
        drawn = resampled(tally, threshold, clusters, draws, seed)
        intervals = {name: interval(values) for name, values in drawn.items()}
    return Result(
        len(tally.truths),
        int(tally.truths.sum()),
        threshold,
        found.hits,
        found.false_positives,
        found.misses,
        found.precision,
        found.recall,
        found.f1,
        average_precision(tally),
        intervals,
    )


def plain(result: Result) -> dict[str, Any]:
    """A result as JSON holds it: null where there is no number."""
    return {name: _known(value) for name, value in attrs.asdict(result).items()}


def plain_curve(tally: Tally) -> dict[str, list[float | None]]:
    """The precision-recall curve as JSON holds it, thinned."""
    along = attrs.asdict(thinned(curve(tally)))
    return {name: [_known(value) for value in values.tolist()] for name, values in along.items()}


def cells(result: Result) -> list[str]:
    """A result as a row of a table: images, how many there are, found, and the four figures in %."""
    counts = [str(result.images), str(result.truths), str(result.hits + result.false_positives)]
    return [*counts, *(_told(getattr(result, name), result.intervals[name]) for name in HEADINGS)]


COLUMNS = ("images", "there", "found", *HEADINGS.values())
"""What `cells` are."""


def markdown(rows: Sequence[tuple[str, Result]], first: str) -> str:
    """A table of results, a row each; `first` heads their names."""
    lines = [[first, *COLUMNS], ["---"] * (1 + len(COLUMNS)), *([name, *cells(each)] for name, each in rows)]
    return "".join(f"| {' | '.join(cell.replace('|', '¦') for cell in line)} |\n" for line in lines)


def _told(value: float, interval: tuple[float, float] | None) -> str:
    if math.isnan(value):
        return "–"
    told = f"{100 * value:.2f}"
    return told if interval is None else f"{told} ({100 * interval[0]:.1f}–{100 * interval[1]:.1f})"


def _known(value: Any) -> Any:
    return None if isinstance(value, float) and math.isnan(value) else value
