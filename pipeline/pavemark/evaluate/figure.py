"""Precision over recall, drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from pavemark.chart import COLOURS, svg
from pavemark.evaluate.curve import curve, thinned
from pavemark.evaluate.results import Result
from pavemark.evaluate.tally import Tally


def figure(kinds: Sequence[tuple[str, Tally, Result]]) -> str:
    """A curve for each kind, points and slots, and on it the threshold of its result: SVG without a date."""
    return svg("evaluate", lambda: _drawn(kinds))


def _drawn(kinds: Sequence[tuple[str, Tally, Result]]) -> Figure:
    drawing = Figure(figsize=(5.6, 4.6), layout="constrained")
    axes = drawing.subplots()
    for (name, tally, result), colour in zip(kinds, COLOURS, strict=False):
        along = thinned(curve(tally))
        told = f"AP {100 * result.average_precision:.1f} %" if result.truths else "none are there"
        # From where the first is found, at once.
        recall = np.concatenate([np.zeros(len(along.recall[:1])), along.recall])
        precision = np.concatenate([along.precision[:1], along.precision])
        axes.plot(100 * recall, 100 * precision, color=colour, label=f"{name}, {told}")
        at = f"at confidence {result.threshold:.3g}"
        axes.plot(100 * result.recall, 100 * result.precision, "o", color=colour, label=at)
    axes.set(xlim=(0, 101), ylim=(0, 101), xlabel="recall, %", ylabel="precision, %")
    axes.legend(loc="lower left", frameon=False)
    return drawing
