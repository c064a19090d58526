"""Rows as CSV, and what they come to as Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import attrs
import numpy as np


def as_csv(rows: Sequence[object], kind: type) -> str:
    """Rows of one attrs class as CSV, a column a field: floats to six digits, nan as an empty field."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in attrs.fields(kind)], lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: _plain(value) for name, value in attrs.asdict(row).items()})
    return text.getvalue()


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table.

    Examples
    --------
    >>> print(markdown(["method", "dB"], [["fsr", "24.1"]]))
    | method | dB |
    | --- | --- |
    | fsr | 24.1 |
    """
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, ["---"] * len(head), *rows))


def spread(values: Sequence[float], digits: int) -> str:
    """Median and quartiles, nan left out; one value is told as it is.

    Examples
    --------
    >>> spread([1.0, 2.0, 3.0, 4.0, float("nan"), 9.0], 1)
    '3.0 (2.0 to 4.0)'
    >>> spread([float("nan"), 2.0], 1), spread([float("nan")], 1), spread([float("inf"), float("inf"), 30.0], 1)
    ('2.0', '–', 'inf (30.0 to inf)')
    """
    known = [value for value in values if not np.isnan(value)]
    if not known:
        return "–"
    if len(known) == 1:
        return f"{known[0]:.{digits}f}"
    # Between an infinite PSNR and another there is nothing to interpolate.
    low, middle, high = np.percentile(known, (25, 50, 75), method="linear" if np.isfinite(known).all() else "nearest")
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _plain(value: object) -> object:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return value


def counted(things: Sequence[object]) -> str:
    """How many images the rows of a table tell of: "1 image", "2 images"."""
    number = len({thing.image for thing in things})
    return f"{number} image{'' if number == 1 else 's'}"
