"""What a selection kept and dropped, as one page: losses by domain, pictures, and a table of domains and plates."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pavemark.detect import reading
from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.page import drawn, page, pictured
from pavemark.select.candidate import Candidate
from pavemark.select.losses import losses
from pavemark.select.strategies import cfds

NAME = "report.html"

ACROSS = 6
"""Pictures of a row."""

SIDE = 200
"""Pixels of a picture's longer side."""

PLATES = 10
"""Plates that have a column of their own: those with most images."""

UNKNOWN = "not known"

ALL = "all domains"

_POINT = (0, 90, 255)

_STYLE = """
.row { display: flex; flex-wrap: wrap; gap: 14px; align-items: flex-start; margin: 0.4em 0 1.4em; }
.row figure { margin: 0; width: 172px; font-size: 12px; line-height: 1.35; overflow-wrap: anywhere; }
.row img { max-height: 200px; max-width: 172px; display: block; margin-bottom: 4px; }
.lacking { height: 172px; background: #f2f2f2; color: #777; text-align: center; line-height: 172px; }
h2 { margin-top: 1.8em; } h3 { margin: 1em 0 0.2em; font-size: 1em; }
td.number, th.number { text-align: right; }
.wide { overflow-x: auto; }
"""


def report(dataset: Path, candidates: Sequence[Candidate], kept: Sequence[Candidate], told: dict[str, Any]) -> str:
    """The page of a selection.

    Parameters
    ----------
    dataset : Path
        Where the pictures are found.
    candidates : sequence of Candidate
        All images that could have been kept, at least one.
    kept : sequence of Candidate
    told : dict
        What the record of the selection says.
    """
    names = {each.name for each in kept}
    order = cfds(candidates)
    galleries = {
        "Kept": _rows([each for each in order if each.name in names]),
        "Dropped": _rows([each for each in order if each.name not in names]),
    }
    shown = {each.name for rows in galleries.values() for row in rows.values() for each in row}
    pictures = (
        {
            example.name: example
            for example in reading.examples_or_faults(dataset, only=lambda _, name: name in shown)
            if isinstance(example, Example)
        }
        if shown
        else {}
    )
    figure = losses(
        np.array([each.loss for each in order]),
        [each.domain or UNKNOWN for each in order],
        np.array([each.name in names for each in order]),
    )
    parts = [
        f"<h1>{len(kept):,} of {len(order):,} images</h1>",
        _asked(told),
        "<h2>How hard they are, by domain</h2>",
        drawn(figure, "losses", "Histograms of the point loss of kept and dropped images, a panel a domain"),
    ]
    for title, rows in galleries.items():
        parts.append(f"<h2>{title}</h2>")
        parts += [f"<p>No image was {title.lower()}.</p>"] * (not rows)
        for name, row in rows.items():
            tiles = "".join(_tile(each, pictures.get(each.name)) for each in row)
            parts.append(f'<h3>{name}</h3>\n<div class="row">{tiles}</div>')
    parts += ["<h2>Domains and plates</h2>", "<p>Kept of all images.</p>", _table(order, names)]
    return page("Pavemark: what was selected", parts, _STYLE)


def _rows(order: Sequence[Candidate]) -> dict[str, Sequence[Candidate]]:
    """The easiest, those in the middle and the hardest of an order, none of them twice."""
    rows = {}
    if len(order) <= 3 * ACROSS:
        return {"All, easiest first": order} if order else {}
    middle = (len(order) - ACROSS) // 2
    rows["Easiest"] = order[:ACROSS]
    rows["Median"] = order[middle : middle + ACROSS]
    rows["Hardest"] = order[-ACROSS:]
    return rows


def _asked(told: dict[str, Any]) -> str:
    """What was asked for, as far as it mattered."""
    matters = {
        "dataset": told["listed"],
        "strategy": told["strategy"],
        "seed": told["seed"] if told["strategy"] in ("random", "coverage") else None,
        "quantiles of the loss": told["quantiles"] if told["strategy"] == "coverage" else None,
        "learnable up to the quantile": told["learnable"] if told["strategy"] == "learnable" else None,
        "hardest dropped": told["drop_hardest"] or None,
        "near-duplicates within": told["near_duplicates"],
        "most of a plate": told["cap_per_plate"],
        "scored by": f"{told['family']} {told['model']}",
        "that learns": told["learner"] and f"{told['learner_family']} {told['learner']}",
        "like real images whose embeddings are": told["real"],
        "pavemark": told["pavemark"],
    }
    rows = (
        f"<tr><th>{name}</th><td>{escape(str(value))}</td></tr>" for name, value in matters.items() if value is not None
    )
    return f'<div class="wide"><table>{"".join(rows)}</table></div>'


def _tile(each: Candidate, example: Example | None) -> str:
    words = escape(each.name)
    try:
        image = '<div class="lacking">cannot be read</div>' if example is None else _thumbnail(example, words)
    except InputError:
        image = '<div class="lacking">cannot be read</div>'
    # A domain is a sum of effects, and may be wider than its picture.
    about = "<br>".join(escape(word).replace("+", "+<wbr>") for word in (each.domain, each.plate) if word)
    return f"<figure>{image}<figcaption>{words}<br>loss {each.loss:.4g}<br>{about}</figcaption></figure>"


def _thumbnail(example: Example, words: str) -> str:
    """A small picture with the true marking points."""
    picture = reading.picture(example)
    scale = min(1.0, SIDE / max(picture.shape[:2]))
    size = [max(1, round(side * scale)) for side in picture.shape[1::-1]]
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    for u, v in example.points * scale:
        # Coordinates are continuous, and the centre of the first pixel is at 0.5.
        at = [round((value - 0.5) * 16) for value in (u, v)]
        for colour, width in (((255, 255, 255), 3), (_POINT, 1)):
            cv2.circle(small, at, 3 * 16, colour, width, cv2.LINE_AA, 4)
    data = cv2.imencode(".jpg", small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
    return pictured(data, words, "jpeg")


def _table(order: Sequence[Candidate], names: set[str]) -> str:
    """Kept and all images by domain and plate; the plates with most images have a column."""
    total, taken = _counted(order), _counted([each for each in order if each.name in names])
    plates, domains = _largest(total[ALL]), _largest({name: of.total() for name, of in total.items() if name != ALL})
    single, rest = plates[:PLATES], len(plates) - PLATES
    heads = ["domain", "all plates", "plates", *single, *[f"{rest:,} others"] * (rest > 0)]
    lines = []
    for domain in [*domains, ALL]:
        both = taken[domain], total[domain]
        counts = [[of.total() for of in both], [len(of) for of in both]]
        counts += [[of[plate] for of in both] for plate in single]
        if rest > 0:
            counts.append([of.total() - sum(of[plate] for plate in single) for of in both])
        lines.append([domain, *(f"{kept:,} / {there:,}" for kept, there in counts)])
    return (
        '<div class="wide"><table>' + _row("th", heads) + "".join(_row("td", line) for line in lines) + "</table></div>"
    )


def _counted(order: Sequence[Candidate]) -> dict[str, Counter[str]]:
    """How many images there are of each plate, by domain and of them all."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for each in order:
        for domain in (each.domain or UNKNOWN, ALL):
            counts[domain][each.plate or UNKNOWN] += 1
    return counts


def _largest(counts: Mapping[str, int]) -> list[str]:
    return sorted(counts, key=lambda name: (-counts[name], name))


def _row(tag: str, cells: Sequence[str]) -> str:
    first, *others = (escape(cell) for cell in cells)
    return f"<tr><{tag}>{first}</{tag}>" + "".join(f'<{tag} class="number">{c}</{tag}>' for c in others) + "</tr>"
