"""A stage's report: its figure, its CSV, and what they say in plain words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import attrs

from pavemark.accuracy.figure import Axis, figure
from pavemark.accuracy.machine import machine
from pavemark.accuracy.race import Failure
from pavemark.accuracy.report import Report
from pavemark.accuracy.table import as_csv, markdown
from pavemark.accuracy.work_precision import Point, duration, families, halving, problems, sentences, short

SEVERAL = 3
"""Settings of a way without which no slope is fitted to it."""


@attrs.frozen(eq=False)
class Wording:
    """What a stage says of itself.

    Attributes
    ----------
    unit : str
        Of the error.
    axis : Axis
    intro : str
        What was done, and against what reference.
    columns : mapping of str to callable
        More columns of the table, from a point to what stands there.
    remarks : sequence of str
        A line each, below the figure.
    failed : sequence of Failure
    across : int
        Panels in a row of the figure.
    """

    unit: str
    axis: Axis
    intro: str
    columns: Mapping[str, Callable[[Point], str]]
    remarks: Sequence[str] = ()
    failed: Sequence[Failure] = ()
    across: int = 2


def written(stage: str, title: str, made: Sequence[Point], wording: Wording) -> Report:
    """The report of a stage: STAGE.svg, STAGE.csv and STAGE.md.

    Parameters
    ----------
    stage, title : str
    made : sequence of Point
        All of one kind, at least one.
    wording : Wording
    """
    told = [
        f"# {title}",
        f"{wording.intro}",
        f"{machine()} Processor time, median (quartiles) of {_rounds(made)}; all ran in turn, round after round.",
        f"![{title}]({stage}.svg)",
        *(_said(name, [point for point in made if point.problem == name], wording.unit) for name in problems(made)),
        *wording.remarks,
        *_not_run(wording.failed),
        *(_table([point for point in made if point.problem == name], wording) for name in problems(made)),
    ]
    text = "\n\n".join(told) + "\n"
    kind = type(made[0])
    drawn = figure(stage, made, wording.axis, wording.across)
    return Report({f"{stage}.svg": drawn, f"{stage}.csv": as_csv(made, kind), f"{stage}.md": text}, text)


def _rounds(made: Sequence[Point]) -> str:
    number = made[0].rounds
    return f"{number} round{'' if number == 1 else 's'}"


def _said(name: str, of: Sequence[Point], unit: str) -> str:
    costs = []
    for family in families(of):
        members = [point for point in of if point.family == family]
        if len(members) >= SEVERAL and (cost := halving(members)):
            costs.append(f"{family} {cost:.3g}×")
    within = [f"Within one way, halving the error costs: {', '.join(costs)} the time."] if costs else []
    return " ".join([f"**{name[0].upper()}{name[1:]}.**", *sentences(of, unit), *within])


def _not_run(failed: Sequence[Failure]) -> list[str]:
    settings: dict[tuple[str, ...], list[str]] = {}
    for failure in failed:
        one = failure.contender
        settings.setdefault((one.family, one.problem, failure.reason), []).append(one.setting)
    return [
        f"{' '.join([family, ', '.join(of)]).rstrip()}, {problem}: not run: {reason}."
        for (family, problem, reason), of in settings.items()
    ]


def _table(of: Sequence[Point], wording: Wording) -> str:
    head = (of[0].problem, "setting", wording.axis.error, "time", *wording.columns, "")
    rows = [
        (
            point.family,
            point.setting,
            short(point.error),
            f"{duration(point.seconds)} ({duration(point.lower)} to {duration(point.upper)})",
            *(column(point) for column in wording.columns.values()),
            ", ".join(["ships"] * point.ships + ["Pareto"] * point.pareto),
        )
        for point in of
    ]
    return markdown(head, rows)
