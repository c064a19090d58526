"""What a sweep writes: figures over the number of images that were learned from, as JSON, a table and a drawing."""

from __future__ import annotations

import json
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from matplotlib.figure import Figure

from pavemark import __version__, files
from pavemark.chart import COLOURS, svg
from pavemark.study.peak import ALPHA, against, not_told_apart, peak
from pavemark.study.sweep import Sweep, Trial
from pavemark.study.tables import FIGURES, spread

UNKNOWN = "one seed: noise unknown"


def write(wanted: Sweep, trials: Sequence[Trial], folder: Path) -> str:
    """Write `sweep.json`, `sweep.svg` and `sweep.md` into a folder.

    Returns
    -------
    str
        The table.
    """
    written = table(trials)
    files.write(folder / "sweep.json", json.dumps(plain(wanted, trials, folder), indent=1) + "\n")
    files.write(folder / "sweep.svg", drawing(trials))
    files.write(folder / "sweep.md", f"{written}\n![F1 over the number of images](sweep.svg)\n")
    return written


def by_keep(trials: Sequence[Trial], figure: str) -> dict[int, list[float | None]]:
    """A figure on the test images at each seed, by the number of images that were learned from."""
    found: dict[int, list[float | None]] = {}
    for trial in trials:
        found.setdefault(trial.keep, []).append(trial.figures["test"][figure])
    return found


def table(trials: Sequence[Trial]) -> str:
    """Precision, recall, F1 and AP in %, the mean over the seeds ± their sample standard deviation, as Markdown."""
    f1 = by_keep(trials, "f1")
    best, compared = peak(f1), against(f1)
    columns = [by_keep(trials, figure) for figure in FIGURES]
    lines = [["images", *FIGURES.values(), "against the peak"], ["---"] * (2 + len(FIGURES))]
    for keep in f1:
        name = f"**{keep}**" if keep == best else str(keep)
        lines.append([name, *(spread(column[keep]) for column in columns), _apart(keep, best, compared)])
    rows = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    return f"{rows}\n{conclusion(f1)}\n"


def conclusion(f1: dict[int, list[float]]) -> str:
    """The peak and what is not told apart from it, in words."""
    best, like = peak(f1), not_told_apart(f1)
    seeds = len(f1[best])
    told = f"Peak: {best} images, F1 {spread(f1[best])} %, {seeds} seed{'' if seeds == 1 else 's'}."
    if len(f1) == 1:
        return f"{told} No other number of images was tried."
    if like is None:
        return f"{told} {UNKNOWN.capitalize()}."
    others = ", ".join(map(str, like)) or "none"
    return f"{told} Not told apart from it (F1, Welch's t-test over the seeds, two-sided, p ≥ {ALPHA}): {others}."


def _apart(keep: int, best: int, compared: dict[int, float | None]) -> str:
    if keep == best:
        return "peak"
    p = compared[keep]
    if p is None:
        return UNKNOWN
    return f"{'not told apart' if p >= ALPHA else 'lower'}, p = {p:.2g}"


def plain(wanted: Sweep, trials: Sequence[Trial], folder: Path) -> dict[str, Any]:
    """All figures, as JSON holds them; paths as they are to be found from the folder."""
    f1 = by_keep(trials, "f1")
    compared = against(f1)
    numbers = {
        keep: {
            "keep": keep,
            **{figure: _summary(by_keep(trials, figure)[keep]) for figure in FIGURES},
            "p_against_peak": compared.get(keep),
        }
        for keep in f1
    }
    return {
        **{name: files.relative(getattr(wanted, name), folder) for name in ("dataset", "scores", "test", "validation")},
        "strategy": wanted.strategy,
        "seed": wanted.seed,
        "training": attrs.asdict(wanted.training),
        "scale": wanted.scale,
        "height": wanted.height,
        "pavemark": __version__,
        "peak": peak(f1),
        "not_told_apart": not_told_apart(f1),
        "test_of": f"F1, Welch's t-test over the seeds, two-sided, p >= {ALPHA}",
        "numbers": list(numbers.values()),
        "runs": [
            {
                "keep": trial.keep,
                "seed": trial.seed,
                "model": files.relative(trial.model, folder),
                **trial.figures,
            }
            for trial in trials
        ],
    }


def _summary(values: Sequence[float | None]) -> dict[str, float | None]:
    """Nothing where a seed has no figure, as in the table."""
    if None in values:
        return {"mean": None, "deviation": None}
    return {"mean": statistics.mean(values), "deviation": statistics.stdev(values) if len(values) > 1 else None}


def drawing(trials: Sequence[Trial]) -> str:
    """F1 over the number of images, the seeds as dots and their sample standard deviation as bars: SVG, no date."""
    return svg("sweep", lambda: _drawn(by_keep(trials, "f1")))


def _drawn(f1: dict[int, list[float]]) -> Figure:
    figure = Figure(figsize=(5.6, 3.8), layout="constrained")
    axes = figure.subplots()
    numbers = list(f1)
    means = [100 * statistics.mean(values) for values in f1.values()]
    # A bar of no length would say that there is no noise.
    bars = [100 * statistics.stdev(values) if len(values) > 1 else np.nan for values in f1.values()]
    for keep, values in f1.items():
        axes.plot([keep] * len(values), [100 * value for value in values], ".", color=COLOURS[0], alpha=0.4)
    told = "mean ± standard deviation of the seeds" if not np.isnan(bars).all() else UNKNOWN
    axes.errorbar(numbers, means, bars, fmt="-o", color=COLOURS[0], markersize=4, capsize=3, label=told)
    best = peak(f1)
    ring = {"marker": "o", "markersize": 13, "markerfacecolor": "none", "markeredgecolor": COLOURS[1]}
    axes.plot(best, means[numbers.index(best)], linestyle="none", label=f"peak, {best} images", **ring)
    axes.set(xlabel="images learned from", ylabel="F1, %")
    axes.legend(loc="best", frameon=False)
    return figure
