"""Where a figure is greatest along a quantity, and which others are as great within the noise of the seeds."""

from __future__ import annotations

import statistics
import warnings
from collections.abc import Mapping, Sequence

from scipy.stats import ttest_ind

ALPHA = 0.05
"""Probability, under the same mean, of a difference at least as large: from here on two are not told apart."""


def peak(figures: Mapping[int, Sequence[float]]) -> int:
    """The quantity with the greatest mean, of equals the least.

    Parameters
    ----------
    figures : mapping of int to sequence of float
        By quantity, the figure at each seed: at least one.
    """
    return min(figures, key=lambda quantity: (-statistics.mean(figures[quantity]), quantity))


def p_value(one: Sequence[float], other: Sequence[float]) -> float | None:
    """Of the difference of two means, by Welch's t-test, two-sided.

    Returns
    -------
    float or None
        None where one of them has a single seed: its noise is not known. Without any noise in both, 1 for equal means
        and 0 for others.
    """
    if min(len(one), len(other)) < 2:
        return None
    if statistics.mean(one) == statistics.mean(other):
        return 1.0
    with warnings.catch_warnings():
        # Seeds that agree to the last digit: SciPy warns of cancellation, and gives 0.
        warnings.simplefilter("ignore", RuntimeWarning)
        return float(ttest_ind(one, other, equal_var=False).pvalue)


def against(figures: Mapping[int, Sequence[float]]) -> dict[int, float | None]:
    """The p-value of each quantity but the peak against it."""
    best = peak(figures)
    return {quantity: p_value(figures[best], each) for quantity, each in figures.items() if quantity != best}


def not_told_apart(figures: Mapping[int, Sequence[float]]) -> list[int] | None:
    """The quantities that are as good as the peak within the noise; None where that is not known."""
    compared = against(figures)
    if None in compared.values():
        return None
    return [quantity for quantity, p in compared.items() if p >= ALPHA]
