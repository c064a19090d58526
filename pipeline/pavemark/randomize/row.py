"""A row of slots on the ground: its painted lines and its slots."""

from __future__ import annotations

import math
from itertools import pairwise

import attrs
import numpy as np

from pavemark.randomize.shape import Shape
from pavemark.scene import Point, Slot, Stroke

Stretch = tuple[float, ...]
"""Where the marking points of slots that share their separating lines lie along the entrance line, ascending."""


@attrs.frozen
class Row:
    """Slots side by side along a roadside.

    Attributes
    ----------
    shape : Shape
    origin : Point
        A point of the entrance line, world, metres.
    heading : float
        Direction of p1 → p2, radians anticlockwise from the world's X. The slots lie to its left.
    stretches : tuple of Stretch
        Metres from the origin; between two stretches there is a gap.
    """

    shape: Shape
    origin: Point
    heading: float
    stretches: tuple[Stretch, ...]

    @property
    def along(self) -> np.ndarray:
        """Unit vector (2,) of the entrance line."""
        return np.array([math.cos(self.heading), math.sin(self.heading)])

    @property
    def inwards(self) -> np.ndarray:
        """Unit vector (2,) of the separating lines, into the slots."""
        angle = self.heading + self.shape.angle
        return np.array([math.cos(angle), math.sin(angle)])

    @property
    def normal(self) -> np.ndarray:
        """Unit vector (2,) from the aisle to the slots, across the entrance line."""
        return np.array([-math.sin(self.heading), math.cos(self.heading)])

    @property
    def middles(self) -> tuple[float, ...]:
        """Metres from the origin to the middle of each slot's entrance."""
        return tuple((a + b) / 2 for stretch in self.stretches for a, b in pairwise(stretch))

    def at(self, along: float, inwards: float = 0.0) -> Point:
        """The point `along` metres along the entrance line and `inwards` metres along a separating line."""
        x, y = np.asarray(self.origin) + along * self.along + inwards * self.inwards
        return float(x), float(y)


def slots(row: Row) -> tuple[Slot, ...]:
    """The slots of a row, in order along it.

    A marking point is T where two slots share it or the entrance line runs on, L at the end of a stretch. "open"
    outlines have no entrance line to tell by: a shared end is called T and an end of the row L, as if it were painted,
    because the field's data sets label bare line ends so.
    """
    shape = row.shape
    end = "T" if shape.tee and shape.outline != "open" else "L"
    found = []
    for stretch in row.stretches:
        marks = [end, *("T" for _ in stretch[1:-1]), end]
        for k, (a, b) in enumerate(pairwise(stretch)):
            corners = (row.at(a), row.at(b), row.at(b, shape.depth), row.at(a, shape.depth))
            found.append(Slot(corners, shape.kind, (marks[k], marks[k + 1]), shape.outline))
    return tuple(found)


def strokes(row: Row) -> tuple[Stroke, ...]:
    """The painted lines of a row. A line that two slots share is painted once; L corners are mitred, so they are full.

    The separating lines start, and end at a back line, on the centre line they join. An entrance line that runs on is
    one stroke for the whole row, across its gaps.
    """
    paths = []
    if row.shape.tee and row.shape.outline in ("closed", "half-closed"):
        ends = row.stretches[0][0] - row.shape.tee, row.stretches[-1][-1] + row.shape.tee
        paths.append(((row.at(ends[0]), row.at(ends[1])), False))
    for stretch in row.stretches:
        if row.shape.outline == "corner":
            paths += _corners(row, stretch)
        elif row.shape.outline == "open":
            paths += _open(row, stretch)
        else:
            paths += _fronted(row, stretch)
    return tuple(Stroke(tuple(path), row.shape.line, closed) for path, closed in paths)


def _corners(row: Row, stretch: Stretch):
    leg, deep, tee = row.shape.leg, row.shape.separator, row.shape.tee > 0
    first, last = stretch[0], stretch[-1]
    shared = stretch if tee else stretch[1:-1]
    if not tee:
        yield (row.at(first, deep), row.at(first), row.at(first + leg)), False
        yield (row.at(last - leg), row.at(last), row.at(last, deep)), False
    for s in shared:
        yield (row.at(s - leg), row.at(s + leg)), False
        yield (row.at(s), row.at(s, deep)), False


def _open(row: Row, stretch: Stretch):
    depth = row.shape.depth
    first, *shared, last = stretch
    if row.shape.back:
        yield (row.at(first), row.at(first, depth), row.at(last, depth), row.at(last)), False
    else:
        shared = stretch
    for s in shared:
        yield (row.at(s), row.at(s, depth)), False


def _fronted(row: Row, stretch: Stretch):
    depth, tee, back = row.shape.depth, row.shape.tee > 0, row.shape.back
    first, *shared, last = stretch
    if tee and back:
        yield (row.at(first), row.at(first, depth), row.at(last, depth), row.at(last)), False
    elif back:
        yield (row.at(first), row.at(last), row.at(last, depth), row.at(first, depth)), True
    elif tee:
        shared = stretch
    else:
        yield (row.at(first, depth), row.at(first), row.at(last), row.at(last, depth)), False
    for s in shared:
        yield (row.at(s), row.at(s, depth)), False
