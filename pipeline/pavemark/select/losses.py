"""A figure of a selection: how hard the images of each domain are, and which of them are kept."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pavemark.chart import COLOURS, svg

KEPT, DROPPED = COLOURS[0], "#c8c8c8"

MOST = 11
"""Domains that have a panel of their own; what is done to the others' images is rare, and they share one."""

OTHERS = "others"

_BINS = 36
_ACROSS = 3
_PANEL = (3.6, 2.1)
_WIDE = 50.0
"""How many times the least the largest loss is where an axis by powers of ten shows more."""


def losses(loss: np.ndarray, domain: Sequence[str], kept: np.ndarray) -> str:
    """Draw losses by domain, kept and dropped images on top of each other.

    Parameters
    ----------
    loss : ndarray (N,) float64
    domain : sequence of str
    kept : ndarray (N,) bool

    Returns
    -------
    str
        SVG; the same images in any order give the same bytes.
    """
    return svg("losses", lambda: _drawn(loss, np.array(domain), kept))


def panels(domain: Sequence[str]) -> list[str]:
    """The domains that have a panel: the largest, then by name, and `OTHERS` where there are more."""
    names, counts = np.unique(np.array(domain), return_counts=True)
    order = [str(names[k]) for k in sorted(range(len(names)), key=lambda k: (-counts[k], names[k]))]
    return order if len(order) <= MOST + 1 else [*order[:MOST], OTHERS]


def _drawn(loss: np.ndarray, domain: np.ndarray, kept: np.ndarray) -> Figure:
    shown = panels(domain)
    across = min(_ACROSS, len(shown))
    down = math.ceil(len(shown) / across)
    drawing = Figure(figsize=(across * _PANEL[0], down * _PANEL[1]), layout="constrained")
    axes = drawing.subplots(down, across, squeeze=False, sharex=True).ravel()
    edges, log = _edges(loss)
    for panel, name in zip(axes, shown, strict=False):
        which = ~np.isin(domain, shown[:-1]) if name == OTHERS and name not in domain else domain == name
        _panel(panel, loss[which], kept[which], edges, log)
        panel.set_title(f"{name}: {kept[which].sum():,} of {which.sum():,}", loc="left")
    for panel in axes[len(shown) :]:
        panel.set_visible(False)
    for k, panel in enumerate(axes[: len(shown)]):
        if k + across >= len(shown):
            panel.set_xlabel("point loss")
            panel.tick_params(labelbottom=True)
        if k % across == 0:
            panel.set_ylabel("images")
    drawing.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2, frameon=False)
    return drawing


def _panel(axes: Axes, loss: np.ndarray, kept: np.ndarray, edges: np.ndarray, log: bool) -> None:
    if log:
        axes.set_xscale("log")
    own, all_of = (np.histogram(each, edges)[0] for each in (loss[kept], loss))
    axes.stairs(all_of, edges, baseline=own, fill=True, color=DROPPED, label="dropped")
    axes.stairs(own, edges, fill=True, color=KEPT, label="kept")
    axes.set_ylim(bottom=0)
    axes.yaxis.get_major_locator().set_params(integer=True)
    axes.grid(axis="x", visible=False)


def _edges(loss: np.ndarray) -> tuple[np.ndarray, bool]:
    """Bounds of the columns, and whether they are even in powers of ten."""
    low, high = float(loss.min()), float(loss.max())
    if low > 0 and high > _WIDE * low:
        edges, log = np.geomspace(low, high, _BINS + 1), True
    else:
        spread = high - low or max(high, 1e-6)
        edges, log = np.linspace(max(0.0, low - 0.02 * spread), high + 0.02 * spread, _BINS + 1), False
    edges[0], edges[-1] = min(edges[0], low), max(edges[-1], high)
    return edges, log
