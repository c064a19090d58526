"""Domain aisle: what else is painted along a row, and is no slot: lines, walkways, lanes, crossings, hatching, floors.

Detectors that never saw it take a line beside the entrance line, the border of a walkway or the corner of a hatched
box for marking points, and overlook those of slots on a painted floor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import attrs
import numpy as np

from pavemark.randomize.colour import on_grey
from pavemark.randomize.row import Row
from pavemark.randomize.streams import happens, uniform, weighted
from pavemark.records import interval, within
from pavemark.scene import RGB, Area, Marking, Paint, Path, Stroke

_share = within(0.0, 1.0)

FLOORS: dict[str, RGB] = {
    "green": (0.04, 0.99, 0.42),
    "red": (2.17, 0.12, 0.43),
    "blue": (0.04, 0.42, 0.99),
    "dark": (0.6, 0.6, 0.6),
    "light": (1.5, 1.5, 1.5),
}
"""Reflectance ratios of floor paints to the grey floor beside them. Green and red are medians over real half-views of
one car park (97 and 68 of them); blue is that green with two channels exchanged, dark and light are greys."""

_SHALLOW = 0.4
"""Metres from the row into the aisle below which there is no box."""


_SHORT = 0.05
"""Metres below which a piece of a line is left out."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    rate : float
        Share of the images with rows that have anything of it.
    line : float
        Of those, share with a line along the row, in front of it.
    second : float
        Of those with a line, share with a second one.
    band : float
        Of those with two, share whose ground between the lines is painted.
    zebra : float
        Share with a crossing in front of the row.
    hatch : float
        Share with a hatched box in front of the row.
    crossed : float
        Of those with a box, share hatched both ways.
    lane : float
        Share with a broken line in the aisle.
    floor : float
        Share whose slots have painted ground.
    gap : tuple of float
        Metres from the entrance line to the first line, centre to centre.
    walkway : tuple of float
        Metres between the lines.
    line_width : tuple of float
        Metres.
    opacity : tuple of float
        Of floor paint.
    """

    rate: float = attrs.field(default=0.0, validator=_share)
    line: float = attrs.field(default=0.7, validator=_share)
    second: float = attrs.field(default=0.45, validator=_share)
    band: float = attrs.field(default=0.4, validator=_share)
    zebra: float = attrs.field(default=0.25, validator=_share)
    hatch: float = attrs.field(default=0.25, validator=_share)
    crossed: float = attrs.field(default=0.0, validator=_share)
    lane: float = attrs.field(default=0.0, validator=_share)
    floor: float = attrs.field(default=0.2, validator=_share)
    gap: tuple[float, float] = attrs.field(default=(0.2, 0.7), validator=interval(0.0, 10.0))
    walkway: tuple[float, float] = attrs.field(default=(0.25, 1.4), validator=interval(0.05, 10.0))
    line_width: tuple[float, float] = attrs.field(default=(0.08, 0.2), validator=interval(0.02, 1.0))
    opacity: tuple[float, float] = attrs.field(default=(0.5, 1.0), validator=interval(0.0, 1.0))


@attrs.frozen
class Box:
    """A place in front of a row: shares of the row's length for its ends, and metres from the entrance line."""

    start: float
    length: float
    near: float
    far: float


@attrs.frozen
class Lane:
    """A broken line in the aisle: metres from the entrance line, of a dash, and between two; and the share of the first
    dash that lies before the row's end."""

    away: float
    dash: float
    between: float
    start: float


@attrs.frozen
class Aisle:
    """What is painted along the rows of an image. Lengths in metres.

    Attributes
    ----------
    lines : tuple of float
        From the entrance line into the aisle.
    width : float
        Of the lines.
    run_on : tuple of float
        By which they run on past the row's first and last slot.
    band, floor : str
        The paint between the lines and in the slots, a key of FLOORS; "" for none.
    opacity : float
        Of both.
    zebra, hatch : Box or None
    stripe : float
        Width of a crossing's stripes, and of the ground between them.
    slant : float
        Radians of the hatching to the row.
    crossed : bool
        Whether it is hatched the other way as well.
    lane : Lane or None
    """

    lines: tuple[float, ...]
    width: float
    run_on: tuple[float, float]
    band: str
    floor: str
    opacity: float
    zebra: Box | None
    hatch: Box | None
    stripe: float
    slant: float
    crossed: bool
    lane: Lane | None


def sample(rng: np.random.Generator, ranges: Ranges) -> Aisle | None:
    """Draw what is painted along the rows of an image, or nothing."""
    if not happens(rng, ranges.rate):
        return None
    has = dict(zip(("line", "second", "band", "zebra", "hatch", "floor"), rng.random(6), strict=True))
    has = {name: drawn < getattr(ranges, name) for name, drawn in has.items()}
    first, between = uniform(rng, ranges.gap), uniform(rng, ranges.walkway)
    lines = ((first, first + between) if has["second"] else (first,)) if has["line"] else ()
    paints = [weighted(rng, dict.fromkeys(FLOORS, 1.0)) for _ in range(2)]
    return Aisle(
        lines=lines,
        width=uniform(rng, ranges.line_width),
        run_on=(4.0 * rng.random(), 4.0 * rng.random()),
        band=paints[0] if has["band"] and len(lines) == 2 else "",
        floor=paints[1] if has["floor"] else "",
        opacity=uniform(rng, ranges.opacity),
        zebra=_box(rng, (0.3, 1.5), (1.0, 3.0)) if has["zebra"] else None,
        hatch=_box(rng, (0.2, 0.8), (0.5, 1.2)) if has["hatch"] else None,
        stripe=uniform(rng, (0.2, 0.5)),
        slant=math.radians(uniform(rng, (30.0, 60.0))) * (1 if rng.random() < 0.5 else -1),
        crossed=bool(rng.random() < ranges.crossed),
        lane=_lane(rng) if rng.random() < ranges.lane else None,
    )


def beside(aisle: Aisle, row: Row, others: Iterable[Row]) -> Aisle:
    """What of it has room before a row: as far as the middle of the aisle where there is a row across it.

    Parameters
    ----------
    aisle : Aisle
    row : Row
    others : iterable of Row
        All other rows of the image.
    """
    ends = [other.at(end) for other in others for end in _ends(aisle, other)]
    room = min([-float((np.asarray(end) - row.origin) @ row.normal) / 2 for end in ends], default=math.inf)
    lines = tuple(line for line in aisle.lines if line + aisle.width / 2 <= room)
    lane = aisle.lane if aisle.lane is not None and aisle.lane.away + aisle.width / 2 <= room else None
    zebra, hatch = _cut(aisle.zebra, room), _cut(aisle.hatch, room - aisle.width / 2)
    if zebra is not None and hatch is not None:
        (begin, end), (first, last) = _place(row, zebra), _place(row, hatch)
        if begin < last + aisle.width and first - aisle.width < end:
            hatch = None  # one of them is painted at a place
    band = aisle.band if len(lines) == 2 else ""
    return attrs.evolve(aisle, lines=lines, band=band, zebra=zebra, hatch=hatch, lane=lane)


def floors(aisle: Aisle, row: Row) -> tuple[Marking, ...]:
    """Painted ground of a row, which lies below all its lines and is not labelled."""
    found = []
    if aisle.floor:
        rings = [
            (row.at(start), row.at(end), row.at(end, row.shape.depth), row.at(start, row.shape.depth))
            for start, end in ((stretch[0], stretch[-1]) for stretch in row.stretches)
        ]
        found.append(Marking("floor", on_grey(FLOORS[aisle.floor], aisle.opacity), areas=tuple(map(Area, rings))))
    if aisle.band:
        ring = _rectangle(row, *_ends(aisle, row), *aisle.lines)
        found.append(Marking("floor", on_grey(FLOORS[aisle.band], aisle.opacity), areas=(Area(ring),)))
    return tuple(found)


def marking(aisle: Aisle, row: Row, paint: Paint) -> Marking | None:
    """The lines along a row, its crossing and its hatched box, as one coat of paint; None where there are none."""
    start, end = _ends(aisle, row)
    strokes = [Stroke((_onto(row, start, line), _onto(row, end, line)), aisle.width) for line in aisle.lines]
    if aisle.lane is not None:
        strokes += [
            Stroke((_onto(row, begin, aisle.lane.away), _onto(row, last, aisle.lane.away)), aisle.width)
            for begin, last in _dashes(aisle.lane, start, end)
        ]
    areas: list[Area] = []
    if aisle.zebra is not None:
        areas = [Area(ring) for ring in _stripes(aisle, row, aisle.zebra)]
    if aisle.hatch is not None:
        strokes += _hatching(aisle, row, aisle.hatch)
    return Marking("aisle", paint, tuple(strokes), tuple(areas)) if strokes or areas else None


def _box(rng: np.random.Generator, near: tuple[float, float], deep: tuple[float, float]) -> Box:
    start, from_line = rng.random(), uniform(rng, near)
    return Box(start, uniform(rng, (1.5, 4.5)), from_line, from_line + uniform(rng, deep))


def _lane(rng: np.random.Generator) -> Lane:
    away = uniform(rng, (1.5, 3.5))
    return Lane(away, uniform(rng, (0.6, 3.0)), uniform(rng, (0.5, 2.5)), rng.random())


def _dashes(lane: Lane, start: float, end: float) -> list[tuple[float, float]]:
    """Where dashes begin and end along the row, the first and the last cut at its ends."""
    begins = np.arange(start - lane.start * lane.dash, end, lane.dash + lane.between)
    found = [(max(begin, start), min(begin + lane.dash, end)) for begin in begins.tolist()]
    return [(begin, last) for begin, last in found if last - begin >= _SHORT]


def _cut(box: Box | None, room: float) -> Box | None:
    """A box as far as there is room for it, None where that is next to nothing."""
    if box is None or room - box.near < _SHALLOW:
        return None
    return attrs.evolve(box, far=min(box.far, room))


def _ends(aisle: Aisle, row: Row) -> tuple[float, float]:
    return row.stretches[0][0] - aisle.run_on[0], row.stretches[-1][-1] + aisle.run_on[1]


def _place(row: Row, box: Box) -> tuple[float, float]:
    first, last = row.stretches[0][0], row.stretches[-1][-1]
    start = first + box.start * (last - first) - box.length / 2
    return start, start + box.length


def _stripes(aisle: Aisle, row: Row, box: Box) -> list[Path]:
    """Stripes across the row's direction, as many whole ones as there is room for."""
    start, end = _place(row, box)
    count = max(1, int((end - start + aisle.stripe) / (2 * aisle.stripe)))
    begins = [start + 2 * aisle.stripe * number for number in range(count)]
    return [_rectangle(row, begin, begin + aisle.stripe, box.near, box.far) for begin in begins]


def _hatching(aisle: Aisle, row: Row, box: Box) -> list[Stroke]:
    """The outline of a box and slanted lines in it, one way or both, each cut at its sides."""
    (start, end), deep = _place(row, box), box.far - box.near
    found = [Stroke(_rectangle(row, start, end, box.near, box.far), aisle.width, closed=True)]
    pitch = 2 * aisle.stripe
    for slant in (aisle.slant, -aisle.slant) if aisle.crossed else (aisle.slant,):
        lean = deep / math.tan(slant)
        begin = start - max(lean, 0.0)
        for number in range(int((end - start + abs(lean)) / pitch) + 1):
            foot = begin + pitch * (number + 0.5)
            low, high = sorted((foot, foot + lean))
            low, high = max(low, start), min(high, end)
            if high - low < _SHORT:
                continue
            path = [_onto(row, along, box.near + deep * (along - foot) / lean) for along in (low, high)]
            found.append(Stroke(tuple(path), aisle.width))
    return found


def _rectangle(row: Row, start: float, end: float, near: float, far: float) -> Path:
    return _onto(row, start, near), _onto(row, start, far), _onto(row, end, far), _onto(row, end, near)


def _onto(row: Row, along: float, away: float) -> tuple[float, float]:
    """A point `away` metres from the entrance line into the aisle."""
    x, y = np.asarray(row.origin) + along * row.along - away * row.normal
    return float(x), float(y)
