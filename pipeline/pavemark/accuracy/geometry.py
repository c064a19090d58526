"""The geometry stage: what it costs to bend, simplify, place and map outlines, and how many pixels that is off by."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import attrs

from pavemark.accuracy import maps, shapes
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.figure import Axis
from pavemark.accuracy.maps import DRAWS, PAIRS, Pairs
from pavemark.accuracy.race import Contender, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.shapes import Errors, Ways
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import Point, points, short
from pavemark.accuracy.write_up import Wording, written
from pavemark.geometry.outline import STEP

ROUNDS, QUICK_ROUNDS = 15, 3

LEAST = 0.01
"""Seconds that each is timed for: the quickest takes microseconds."""


@attrs.frozen(kw_only=True)
class GeometryPoint(Point):
    """A row of geometry.csv; `error` is Hausdorff's distance to the reference in pixels.

    Attributes
    ----------
    marking_point : float
        The worst of the marking points, in pixels: what a label would be off by.
    """

    marking_point: float


@attrs.frozen
class Problem:
    """Ways to do a thing, their errors, and which of them ships (family, setting)."""

    ways: Callable[[], Ways]
    errors: Callable[[Any], Errors]
    ships: tuple[str, str]


def _placed(distance: float) -> Problem:
    return Problem(partial(shapes.placing, distance), shapes.placed_errors, ("float64", ""))


def _mapped(pairs: Pairs) -> Problem:
    return Problem(partial(maps.estimating, pairs), partial(maps.errors, pairs=pairs), (maps.NORMALISED, ""))


PROBLEMS = {
    "bent lines, by the distance of their points": Problem(
        shapes.bending, shapes.bent_errors, ("chords", f"{STEP:g} m")
    ),
    "outline of a mask, simplified by ε pixels": Problem(
        shapes.simplifying, shapes.simplified_errors, (shapes.OURS, "")
    ),
    "outline 10 km from the origin": _placed(1e4),
    "outline 10,000 km from the origin": _placed(1e7),
    "homography, exact points": _mapped(Pairs()),
    "homography, noise of 0.5 px": _mapped(Pairs(0.5)),
    "homography, noise of 0.5 px, 10,000 km from the origin": _mapped(Pairs(0.5, 1e7)),
    "homography, noise of 0.5 px, three pairs wrong": _mapped(Pairs(0.5, wrong=3)),
}


def contenders() -> list[Contender]:
    """All ways of all problems."""
    return [
        Contender(name, family, setting, (family, setting) == problem.ships)
        for name, problem in PROBLEMS.items()
        for family, setting in _ways(name)
    ]


@cache
def _ways(problem: str) -> Ways:
    return PROBLEMS[problem].ways()


def work(contender: Contender) -> Any:
    """What a contender makes of its problem: for a process of its own."""
    return _ways(contender.problem)[contender.family, contender.setting]()


def judge(run: Run) -> Errors:
    """A contender's errors."""
    return PROBLEMS[run.contender.problem].errors(run.value)


def report(quick: bool, watcher: Watcher) -> Report:
    """Race them: geometry.svg, geometry.csv and geometry.md.

    Parameters
    ----------
    quick : bool
        With fewer rounds.
    watcher : Watcher
    """
    with Apart(work, "geometry", LEAST) as apart:
        runs, failed = race(contenders(), apart, QUICK_ROUNDS if quick else ROUNDS, watcher)
    made = points(runs, GeometryPoint, judge)
    return written(
        "geometry",
        "Geometry: bending, simplifying, placing and mapping outlines",
        made,
        Wording(
            unit="px",
            axis=Axis("Hausdorff distance, pixels", ("worst marking point", lambda point: point.marking_point)),
            intro=INTRO,
            columns={"worst marking point, pixels": lambda point: short(point.marking_point)},
            failed=failed,
        ),
    )


INTRO = (
    "A row of three slots, 600×600 pixels at 60 px/m. References: bent lines with 32 times as many points as ship; the "
    "outline that the mask was drawn from; pixels of coordinates that were never far away; the map that the points "
    f"were made with. A homography is estimated from {PAIRS} pairs of points, world to image, in {DRAWS} draws: errors "
    "are medians over them, times are those of all."
)
