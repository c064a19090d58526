"""Error against time: which contenders are worth their time, and what exactness costs.

A contender is on the Pareto front when nothing else is both at least as quick and at least as exact. Along the front
the time is fitted to a power of the error, so that one number says what halving the error costs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from pavemark.accuracy.race import Run

SAME = 1.05
"""Times, and errors, that differ by no more than this factor are the same: medians of one and the same thing do."""

NOTHING = 1e-9
"""Errors below it, in levels or in pixels, are the same: they are rounding, and their order is chance."""


@attrs.frozen(kw_only=True)
class Point:
    """A contender in the figure, and a row of a stage's CSV, which adds measures of its own.

    Attributes
    ----------
    problem, family, setting, ships
        See `Contender`.
    error : float
        What the figure shows, in the stage's unit.
    seconds, lower, upper : float
        Median and quartiles of the processor time.
    rounds : int
        How often it was timed.
    pareto : bool
        Whether it is on the Pareto front of its problem.
    """

    problem: str
    family: str
    setting: str
    ships: bool
    error: float
    seconds: float
    lower: float
    upper: float
    rounds: int
    pareto: bool = False

    def __str__(self) -> str:
        return f"{self.family} {self.setting}".rstrip()


def points(runs: Sequence[Run], kind: type[Point], judge: Callable[[Run], dict[str, Any]]) -> list[Any]:
    """The points of runs, of a stage's kind, with those on the Pareto front marked.

    Parameters
    ----------
    runs : sequence of Run
    kind : type
        `Point` or what a stage derives from it.
    judge : callable
        From a run to the other fields of `kind`, "error" among them.
    """
    made = []
    for run in runs:
        lower, middle, upper = map(float, np.percentile(run.seconds, (25, 50, 75)))
        times = {"seconds": middle, "lower": lower, "upper": upper, "rounds": len(run.seconds)}
        made.append(kind(**attrs.asdict(run.contender), **times, **judge(run)))
    return [
        attrs.evolve(point, pareto=on)
        for problem in problems(made)
        for of in [[point for point in made if point.problem == problem]]
        for point, on in zip(of, front([p.error for p in of], [p.seconds for p in of]), strict=True)
    ]


def problems(made: Sequence[Point]) -> list[str]:
    """The problems of points, in order."""
    return list(dict.fromkeys(point.problem for point in made))


def front(errors: Sequence[float], seconds: Sequence[float]) -> list[bool]:
    """Which of some points nothing dominates: nothing is better in one and no worse in the other.

    Better is more than SAME, so that of two that take as long only the more exact one stays, and errors below NOTHING
    count as that.

    Examples
    --------
    >>> front([4.0, 2.0, 3.0, 1.0], [1.0, 2.0, 3.0, 4.0])
    [True, True, False, True]
    >>> front([4.0, 3.0], [1.0, 1.01])
    [False, True]
    """
    pairs = list(zip(errors, seconds, strict=True))
    return [not any(_beats(other, one) for other in pairs) for one in pairs]


def _beats(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether an error and a time are better in one and no worse in the other."""
    (error, seconds), (its_error, its_seconds) = ((_seen(error), seconds) for error, seconds in (one, other))
    no_worse = error <= SAME * its_error and seconds <= SAME * its_seconds
    return no_worse and (SAME * error < its_error or SAME * seconds < its_seconds)


def _seen(error: float) -> float:
    return max(error, NOTHING)


def power(of: Sequence[float], by: Sequence[float]) -> float:
    """The exponent k of the fit of ∝ byᵏ, least squares in the logarithms; nan where `by` does not vary.

    Examples
    --------
    >>> round(power([3.0, 12.0, 48.0], [1.0, 2.0, 4.0]), 9)
    2.0
    """
    if min(of, default=0) <= 0 or min(by, default=0) <= 0 or len(set(by)) < 2:
        return float("nan")
    return float(np.polyfit(np.log(by), np.log(of), 1)[0])


def halving(of: Sequence[Point]) -> float | None:
    """How many times the time it costs to halve the error, fitted; None where the error is not halved.

    Examples
    --------
    >>> times = dict(lower=0, upper=0, rounds=1, problem="", family="", setting="", ships=False)
    >>> halving([Point(error=8.0, seconds=1.0, **times), Point(error=2.0, seconds=16.0, **times)])
    4.0
    """
    errors = [_seen(point.error) for point in of]
    if max(errors) < 2 * min(errors):
        return None
    return round(2 ** -power([point.seconds for point in of], errors), 12)


def sentences(of: Sequence[Point], unit: str) -> list[str]:
    """What the figure says of one problem, in plain words and from the data alone.

    Parameters
    ----------
    of : sequence of Point
        Of one problem.
    unit : str
        Of the error.
    """
    best = sorted((point for point in of if point.pareto), key=lambda point: point.seconds)
    quick, exact = best[0], best[-1]
    if quick is exact:
        said = [f"Nothing is quicker or more exact than {quick} ({told(quick, unit)})."]
    elif cost := halving(best):
        said = [
            f"From {quick} ({told(quick, unit)}) to {exact} ({told(exact, unit)}), along what is worth its time, "
            f"halving the error costs {cost:.3g}× the time."
        ]
    else:
        said = [
            f"From {quick} ({told(quick, unit)}) to {exact} ({told(exact, unit)}) the error falls by "
            f"{1 - exact.error / quick.error:.0%} only: nothing halves it."
        ]
    for point in of:
        if point.ships and not point.pareto:
            better = [p for p in (*best, *of) if _beats((p.error, p.seconds), (point.error, point.seconds))]
            said.append(f"What ships, {point} ({told(point, unit)}), is dominated by {better[0]}.")
        elif point.ships and quick is not exact:
            said.append(f"What ships is {point} ({told(point, unit)}).")
    lost = [family for family in families(of) if not any(p.pareto for p in of if p.family == family)]
    if lost:
        said.append(f"Never worth the time here: {', '.join(lost)}.")
    return said


def families(of: Sequence[Point]) -> list[str]:
    """The families of points, in order."""
    return list(dict.fromkeys(point.family for point in of))


def told(point: Point, unit: str) -> str:
    """A point's error and time."""
    return f"{short(point.error)} {unit} in {duration(point.seconds)}"


def duration(seconds: float) -> str:
    """A time to read.

    Examples
    --------
    >>> [duration(seconds) for seconds in (2.5, 0.0123, 4.56e-6)]
    ['2.5 s', '12 ms', '4.6 µs']
    """
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{short(seconds / size)} {unit}"
    return f"{short(seconds / 1e-6)} µs"


def short(number: float) -> str:
    """A number to read: two digits, or all before the point.

    Examples
    --------
    >>> [short(number) for number in (0.00034, 9.96, 99.7, 123.4, 2.34e-13)]
    ['0.00034', '10', '100', '123', '2.3e-13']
    """
    return f"{number:.0f}" if number >= 99.5 else f"{number:.2g}"
