"""Ground symbols: slot numbers behind the entrance, arrows in the aisle. They are markings, but no slot's."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.randomize.row import Row
from pavemark.randomize.streams import happens
from pavemark.scene import Area, Marking, Paint, Path, Stroke

# A glyph is paths on a grid 2 wide and 4 high, its origin at the lower left.
GLYPHS: dict[str, tuple[Path, ...]] = {
    "0": (((0, 0), (2, 0), (2, 4), (0, 4), (0, 0)),),
    "1": (((0.4, 3.2), (1.2, 4), (1.2, 0)),),
    "2": (((0, 4), (2, 4), (2, 2), (0, 2), (0, 0), (2, 0)),),
    "3": (((0, 4), (2, 4), (2, 0), (0, 0)), ((0.4, 2), (2, 2))),
    "4": (((0, 4), (0, 2), (2, 2)), ((2, 4), (2, 0))),
    "5": (((2, 4), (0, 4), (0, 2), (2, 2), (2, 0), (0, 0)),),
    "6": (((2, 4), (0, 4), (0, 0), (2, 0), (2, 2), (0, 2)),),
    "7": (((0, 4), (2, 4), (0.8, 0)),),
    "8": (((0, 0), (2, 0), (2, 4), (0, 4), (0, 0)), ((0, 2), (2, 2))),
    "9": (((2, 2), (0, 2), (0, 4), (2, 4), (2, 0), (0, 0)),),
    "A": (((0, 0), (0, 3), (1, 4), (2, 3), (2, 0)), ((0, 1.6), (2, 1.6))),
    "B": (((0, 0), (0, 4), (1.6, 4), (1.6, 2.2), (0, 2.2)), ((1.6, 2.2), (2, 1.8), (2, 0), (0, 0))),
    "C": (((2, 4), (0, 4), (0, 0), (2, 0)),),
    "D": (((0, 0), (0, 4), (1.2, 4), (2, 3.2), (2, 0.8), (1.2, 0), (0, 0)),),
    "E": (((2, 4), (0, 4), (0, 0), (2, 0)), ((0, 2), (1.6, 2))),
}

_PITCH = 3.0
"""Grid units from one glyph to the next."""


@attrs.frozen
class Symbols:
    """What an image's symbols are. Lengths in metres.

    Attributes
    ----------
    arrow : bool
        An arrow in the aisle rather than numbers in the slots.
    letter : str
        Before every number; may be empty.
    first : int
        Number of the first slot; the next ones count up.
    height : float
        Of the glyphs.
    behind : float
        From the entrance line to the glyphs.
    place : float
        Where along the row the arrow lies, 0 to 1.
    aisle : float
        From the entrance line to the arrow.
    """

    arrow: bool
    letter: str
    first: int
    height: float
    behind: float
    place: float
    aisle: float


def sample(rng: np.random.Generator, rate: float) -> Symbols | None:
    """Draw the symbols of an image, or none."""
    if not happens(rng, rate):
        return None
    return Symbols(
        arrow=bool(rng.random() < 0.3),
        letter=("", "", "A", "B", "C", "D", "E")[int(rng.random() * 7)],
        first=1 + int(rng.random() * 400),
        height=0.25 + 0.25 * rng.random(),
        behind=0.25 + 0.5 * rng.random(),
        place=rng.random(),
        aisle=1.5 + 1.5 * rng.random(),
    )


def marking(symbols: Symbols, row: Row, paint: Paint) -> Marking:
    """The symbols of a row as one coat of paint."""
    if symbols.arrow:
        return _arrow(symbols, row, paint)
    return _numbers(symbols, row, paint)


def _numbers(symbols: Symbols, row: Row, paint: Paint) -> Marking:
    """Numbers to be read from the aisle, in the middle of each slot."""
    unit = symbols.height / 4
    # In slanted slots the numbers stay midway between the separating lines.
    lean = (symbols.behind + symbols.height / 2) / math.tan(row.shape.angle)
    strokes = []
    for number, middle in enumerate(row.middles, symbols.first):
        text = f"{symbols.letter}{number}"
        start = -(_PITCH * (len(text) - 1) + 2) / 2
        for k, glyph in enumerate(text):
            for path in GLYPHS[glyph]:
                points = np.array([(start + _PITCH * k + x, y) for x, y in path]) * unit
                strokes.append(_stroke(row, middle + lean, symbols.behind, points, 0.6 * unit))
    return Marking("symbol", paint, tuple(strokes))


def _arrow(symbols: Symbols, row: Row, paint: Paint) -> Marking:
    """An arrow 2.4 m long in the aisle, along the row, the way that traffic on the right would take."""
    first, last = row.stretches[0][0], row.stretches[-1][-1]
    middle = first + symbols.place * (last - first)
    shaft = _stroke(row, middle, -symbols.aisle, np.array([(-1.2, 0.0), (0.45, 0.0)]), 0.15)
    head = _onto(row, middle, -symbols.aisle, np.array([(0.4, -0.3), (1.2, 0.0), (0.4, 0.3)]))
    return Marking("symbol", paint, (shaft,), (Area(head),))


def _stroke(row: Row, along: float, normal: float, points: np.ndarray, width: float) -> Stroke:
    path = _onto(row, along, normal, points)
    if path[0] == path[-1]:
        return Stroke(path[:-1], width, closed=True)
    return Stroke(path, width)


def _onto(row: Row, along: float, normal: float, points: np.ndarray) -> Path:
    """Points (N, 2) along and across the entrance line, from a place beside it, in the world."""
    world = np.asarray(row.origin) + (along + points[:, :1]) * row.along + (normal + points[:, 1:]) * row.normal
    return tuple((float(x), float(y)) for x, y in world)
