"""The style of all figures, and their way into SVG."""

from __future__ import annotations

import io
from collections.abc import Callable

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5195", "#8c6d1f", "#56b4e9", "#555555", "#b00020", "#e69f00")
"""Told apart by people who see colours differently (Okabe and Ito, 2008), and some more; markers differ as well."""

STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",  # text stays text: it can be read, searched and copied
}


def svg(name: str, draw: Callable[[], Figure]) -> str:
    """A drawing in the reports' style as SVG without a date; the ids within follow from the name."""
    with mpl.rc_context():
        mpl.rcdefaults()  # what a user has set for figures of their own is not for ours
        mpl.rcParams.update(STYLE | {"svg.hashsalt": name})
        text = io.StringIO()
        undated = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        FigureCanvasSVG(draw()).print_figure(text, format="svg", metadata=undated, bbox_inches="tight")
    return text.getvalue()
