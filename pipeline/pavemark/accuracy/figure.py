"""A stage's figure: error against time, log-log, a panel a problem."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from pavemark.accuracy.work_precision import Point, duration, families, problems
from pavemark.chart import COLOURS, svg

Styles = dict[str, tuple[str, str]]

LEAST = 1e-15
"""What an error of nought is drawn at: nothing in float64 is nearer to a number of size 1."""

MARKERS = "osD^vP<>Xh"

PANEL = (5.6, 4.0)
"""Inches of a panel, its legend left out."""

LEGEND = 2.1
"""Inches beside a panel for a legend of its own."""


LEAST_RANGE = 6.0
"""How many times its beginning an axis ends at, at least."""

LABEL = 7.5
"""Points of the settings' letters."""

NARROW = 200
"""How many times its beginning an axis may end at for 2 and 5 to be told between the powers of ten."""


@attrs.frozen(eq=False)
class Axis:
    """What the error is, with its unit.

    Attributes
    ----------
    error : str
    second : tuple of (str, callable) or None
        Another error in the same unit that is shown beside it, as a cross: its name, and from a point to its value.
    """

    error: str
    second: tuple[str, Callable[[Any], float]] | None = None


def figure(name: str, made: Sequence[Point], axis: Axis, across: int) -> str:
    """Draw a stage.

    Parameters
    ----------
    name : str
        Of the stage: the ids within the SVG follow from it, so that several fit on one page.
    made : sequence of Point
        At least one.
    axis : Axis
    across : int
        Panels in a row.

    Returns
    -------
    str
        SVG without a date; the same points give the same bytes.
    """
    return svg(name, lambda: _drawn(made, axis, across))


def _drawn(made: Sequence[Point], axis: Axis, across: int) -> Figure:
    shown = problems(made)
    by_problem = [[point for point in made if point.problem == problem] for problem in shown]
    shared = all(families(of) == families(by_problem[0]) for of in by_problem)
    style = _styles(by_problem)
    across = min(across, len(shown))
    down = math.ceil(len(shown) / across)
    width, height = PANEL[0] + (0 if shared else LEGEND), PANEL[1]
    drawing = Figure(figsize=(across * width, down * height), layout="constrained")
    drawing.get_layout_engine().set(h_pad=0.1)
    panels = drawing.subplots(down, across, squeeze=False).ravel()
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    for axes, problem, of in zip(panels, shown, by_problem, strict=False):
        _panel(axes, of, style, axis)
        axes.set_title(problem, loc="left")
        axes.set_xlabel("processor time")
        axes.set_ylabel(axis.error)
        if not shared:
            axes.legend(handles=_legend(of, style, axis), loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    if shared:
        drawing.legend(handles=_legend(made, style, axis), loc="outside lower center", ncols=4, frameon=False)
    drawing.draw_without_rendering()  # lays the panels out, so that labels know where their points are
    for axes, of in zip(panels, by_problem, strict=False):
        _label(axes, of, style, axis)
    return drawing


def _styles(by_problem: Sequence[Sequence[Point]]) -> Styles:
    """A colour and a marker for each family; those of one problem differ."""
    styles: Styles = {}
    every = list(zip(COLOURS, MARKERS, strict=True))
    for of in by_problem:
        free = [style for style in every if style not in [styles.get(family) for family in families(of)]]
        for family in families(of):
            if family not in styles:
                styles[family] = free.pop(0)
    return styles


def _panel(axes: Axes, of: Sequence[Point], style: Styles, axis: Axis) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    best = sorted((point for point in of if point.pareto), key=lambda point: point.seconds)
    axes.plot([p.seconds for p in best], [_seen(p.error) for p in best], color="#bbbbbb", linewidth=5, alpha=0.6)
    for family in families(of):
        colour, marker = style[family]
        members = [point for point in of if point.family == family]
        x, y = [point.seconds for point in members], [_seen(point.error) for point in members]
        spread = np.array([[p.seconds - p.lower for p in members], [p.upper - p.seconds for p in members]])
        axes.errorbar(x, y, xerr=spread, color=colour, marker=marker, markersize=5, linewidth=1, capsize=2)
    for point in of:
        at = point.seconds, _seen(point.error)
        if axis.second:
            beside = _seen(axis.second[1](point))
            axes.plot(point.seconds, beside, marker="x", markersize=5, color=style[point.family][0], linestyle="")
        if point.pareto:
            axes.plot(*at, marker="o", markersize=11, markerfacecolor="none", markeredgecolor="black", linestyle="")
        if point.ships:
            axes.plot(*at, marker="*", markersize=17, markerfacecolor="none", markeredgecolor="black", linestyle="")
    axes.margins(0.12)
    axes.set_xlim(*_widened(axes.get_xlim()))
    axes.set_ylim(*_widened(axes.get_ylim()))
    axes.xaxis.set_major_locator(_locator(axes.get_xlim()))
    axes.xaxis.set_major_formatter(lambda seconds, _: duration(seconds))
    axes.yaxis.set_major_locator(_locator(axes.get_ylim()))
    if _narrow(axes.get_ylim()):
        axes.yaxis.set_major_formatter("{x:g}")
    for each in (axes.xaxis, axes.yaxis):
        each.set_minor_formatter(NullFormatter())


def _widened(limits: tuple[float, float]) -> tuple[float, float]:
    """Limits of an axis with room for a factor of LEAST_RANGE: a difference that is none must not look like one."""
    low, high = limits
    more = max(1.0, math.sqrt(LEAST_RANGE * low / high))
    return low / more, high * more


def _narrow(limits: tuple[float, float]) -> bool:
    return limits[1] < NARROW * limits[0]


def _locator(limits: tuple[float, float]) -> LogLocator:
    return LogLocator(10, subs=(1, 2, 5) if _narrow(limits) else (1,), numticks=12)


def _label(axes: Axes, of: Sequence[Point], style: Styles, axis: Axis) -> None:
    """Settings beside their points, as many as find room: what ships and what is worth its time first."""
    scale = axes.figure.dpi / 72

    def placed(point: Point, error: float) -> np.ndarray:
        return axes.transData.transform((point.seconds, _seen(error))) / scale

    place = {id(point): placed(point, point.error) for point in of}
    crosses = [placed(point, axis.second[1](point)) for point in of] if axis.second else []
    taken = [_box(*at, 5, 5) for at in (*place.values(), *crosses)]
    for point in sorted(of, key=lambda point: (not point.ships, not point.pareto)):
        size = 0.62 * LABEL * len(point.setting), LABEL
        for right, up in ((1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1.4), (0, -1.4)) if point.setting else ():
            shift = right * (size[0] / 2 + 6), up * (LABEL / 2 + 5)
            box = _box(*(place[id(point)] + shift), size[0] / 2, LABEL / 2)
            if not any(_meet(box, other) for other in taken):
                taken.append(box)
                at = point.seconds, _seen(point.error)
                how = {"ha": "center", "va": "center", "fontsize": LABEL, "color": style[point.family][0]}
                axes.annotate(point.setting, at, xytext=shift, textcoords="offset points", **how)
                break


def _box(x: float, y: float, wide: float, high: float) -> tuple[float, float, float, float]:
    return x - wide, y - high, x + wide, y + high


def _meet(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _legend(of: Sequence[Point], style: Styles, axis: Axis) -> list[Line2D]:
    ways = [Line2D([], [], color=style[f][0], marker=style[f][1], markersize=5, label=f) for f in families(of)]
    ring = {"markerfacecolor": "none", "markeredgecolor": "black", "linestyle": ""}
    crosses = [Line2D([], [], color="#555555", marker="x", linestyle="", label=axis.second[0])] if axis.second else []
    return [
        *ways,
        *crosses,
        Line2D([], [], marker="o", markersize=11, label="worth its time (Pareto)", **ring),
        Line2D([], [], marker="*", markersize=15, label="what ships", **ring),
    ]


def _seen(error: float) -> float:
    return max(error, LEAST)
