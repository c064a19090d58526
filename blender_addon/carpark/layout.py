"""What stands and lies in the car park: slot rows, arrows, cars, kerbs, pillars. Pure data, metres."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.scene import Area, Path, Point, Stroke

WHITE = (0.72, 0.72, 0.68)
YELLOW = (0.62, 0.40, 0.06)
"""Reflectances of road paint, linear light."""


@attrs.frozen
class Coat:
    """Lines and symbols painted together.

    Attributes
    ----------
    strokes : tuple of Stroke
    areas : tuple of Area
    colour : tuple of float
        Reflectance, linear light.
    wear : float
        Share of the paint that is gone, 0 to 1.
    """

    strokes: tuple[Stroke, ...] = ()
    areas: tuple[Area, ...] = ()
    colour: tuple[float, float, float] = WHITE
    wear: float = 0.2


@attrs.frozen
class Row:
    """A row of slots along one side of the lane.

    Attributes
    ----------
    side : str
        "left" or "right" of the car.
    offset : float
        Metres from the lane's middle to the entrance lines.
    entrance, depth : float
        Metres of a slot.
    slant : float
        Radians from the entrance line to the separating lines; π/2 for right-angled slots.
    outline : str
        "closed", "half-closed", "open" or "corner", as in `pavemark.scene.Slot`.
    width : float
        Metres across the lines.
    shift : float
        Metres by which the row is moved along the lane.
    numbered : bool
        Whether each slot carries its number.
    parked : tuple of int
        The slots with a car in it; slot 0 begins at the origin, negative ones lie behind it.
    """

    side: str
    offset: float
    entrance: float = 2.5
    depth: float = 5.2
    slant: float = np.pi / 2
    outline: str = "half-closed"
    colour: tuple[float, float, float] = WHITE
    wear: float = 0.2
    width: float = 0.12
    shift: float = 0.0
    numbered: bool = False
    parked: tuple[int, ...] = ()


@attrs.frozen
class Parked:
    """A parked car: where its middle stands, and where it faces in radians anticlockwise from +X."""

    at: Point
    heading: float


@attrs.frozen
class Block:
    """Something square that stands on the ground.

    Attributes
    ----------
    at : Point
        Middle of its foot.
    size : tuple of float
        Metres along, across and up.
    heading : float
        Radians of its long side.
    kind : str
        "kerb", "wall", "pillar" or "verge".
    """

    at: Point
    size: tuple[float, float, float]
    heading: float
    kind: str


def slots(row: Row) -> range:
    """The slots of a row that lie within 9 m of the origin along the lane."""
    reach = int(np.ceil(9 / row.entrance))
    return range(-reach, reach + 1)


def painted(row: Row, turn: float) -> Coat:
    """The lines of a row whose lane is turned by `turn` radians."""
    strokes: list[Stroke] = []
    entrance, into = _axes(row)
    half = row.width / 2
    first, last = slots(row)[0], slots(row)[-1] + 1
    tip = 0.45
    for number in range(first, last + 1):
        p = _corner(row, number)
        back = p + into * row.depth
        if row.outline == "corner":
            strokes += [Stroke((tuple(p - into * half), tuple(p + into * tip)), row.width)]
            strokes += [Stroke((tuple(p - entrance * tip), tuple(p + entrance * tip)), row.width)]
        else:
            strokes.append(Stroke((tuple(p), tuple(back)), row.width))
        if row.numbered and number < last:
            foot = p + entrance * row.entrance / 2 + into * 0.75
            strokes += figures(str(40 + number), foot, -entrance, 0.42)
    ends = _corner(row, first), _corner(row, last)
    if row.outline in ("closed", "half-closed"):
        strokes.append(Stroke((tuple(ends[0]), tuple(ends[1])), row.width))
    if row.outline in ("closed", "open"):
        strokes.append(Stroke((tuple(ends[0] + into * row.depth), tuple(ends[1] + into * row.depth)), row.width))
    return Coat(tuple(turned(stroke, turn) for stroke in strokes), colour=row.colour, wear=row.wear)


def cars(row: Row, turn: float, rng: np.random.Generator) -> tuple[Parked, ...]:
    """The cars that stand in a row, nose in or out, never quite straight."""
    entrance, into = _axes(row)
    lengthwise = entrance if row.entrance > row.depth else into
    result = []
    for number in row.parked:
        middle = _corner(row, number) + entrance * row.entrance / 2 + into * (row.depth / 2 + rng.normal(0, 0.08))
        middle = middle + entrance * rng.normal(0, 0.06)
        facing = lengthwise * rng.choice([-1, 1])
        heading = np.arctan2(facing[1], facing[0]) + rng.normal(0, 0.02)
        result.append(Parked(_turn(middle, turn), float(heading + turn)))
    return tuple(result)


def beside(kind: str, side: str, offset: float, turn: float) -> Block:
    """A kerb, wall or verge along the lane, its face `offset` metres from the middle."""
    thick, tall = {"kerb": (0.16, 0.13), "wall": (0.3, 3.0), "verge": (6.0, 0.11)}[kind]
    x = (offset + thick / 2) * (1 if side == "right" else -1)
    return Block(_turn(np.array([x, 0.0]), turn), (22.0, thick, tall), np.pi / 2 + turn, kind)


def pillars(row: Row, turn: float) -> tuple[Block, ...]:
    """Square pillars between every second and third slot of a row, a little behind the entrance."""
    _, into = _axes(row)
    found = [_corner(row, number) + into * 0.9 for number in slots(row) if number % 3 == 1]
    return tuple(Block(_turn(p, turn), (0.7, 0.5, 3.2), np.pi / 2 + turn, "pillar") for p in found)


def arrow(at: Point, turn: float, colour: tuple[float, float, float] = WHITE) -> Coat:
    """A straight-ahead arrow in the lane, 3 m long."""
    x, y = at
    shaft = ((x - 0.08, y - 1.5), (x + 0.08, y - 1.5), (x + 0.08, y + 0.5), (x - 0.08, y + 0.5))
    head = ((x - 0.3, y + 0.4), (x + 0.3, y + 0.4), (x, y + 1.5))
    areas = tuple(Area(tuple(_turn(np.array(p), turn) for p in ring)) for ring in (shaft, head))
    return Coat(areas=areas, colour=colour)


_SEGMENTS = {
    "0": "abcdef", "1": "bc", "2": "abged", "3": "abgcd", "4": "fgbc", "5": "afgcd", "6": "afgcde", "7": "abc",
    "8": "abcdefg", "9": "abcdfg",
}  # fmt: skip
_ENDS = {
    "a": ((0, 2), (1, 2)), "b": ((1, 2), (1, 1)), "c": ((1, 1), (1, 0)), "d": ((0, 0), (1, 0)), "e": ((0, 0), (0, 1)),
    "f": ((0, 1), (0, 2)), "g": ((0, 1), (1, 1)),
}  # fmt: skip


def figures(text: str, foot: np.ndarray, right: np.ndarray, height: float) -> list[Stroke]:
    """Digits in seven segments, as stencils paint them, centred over `foot`, reading along the unit vector `right`."""
    up = np.array([-right[1], right[0]])
    step, wide = height * 0.75, height * 0.42
    strokes = []
    for k, digit in enumerate(text):
        corner = foot + right * ((k - len(text) / 2) * step + (step - wide) / 2)
        for segment in _SEGMENTS[digit]:
            path = tuple(tuple(corner + right * u * wide + up * v * height / 2) for u, v in _ENDS[segment])
            strokes.append(Stroke(path, height * 0.14))
    return strokes


def turned(stroke: Stroke, turn: float) -> Stroke:
    """The stroke turned about the origin."""
    path: Path = tuple(_turn(np.array(p), turn) for p in stroke.path)
    return attrs.evolve(stroke, path=path)


def _axes(row: Row) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors along the entrance lines and into the slots; the slot lies to the left of the entrance."""
    angle = np.pi / 2 if row.side == "left" else -np.pi / 2
    into = angle + row.slant
    return np.array([np.cos(angle), np.sin(angle)]), np.array([np.cos(into), np.sin(into)])


def _corner(row: Row, number: int) -> np.ndarray:
    entrance, _ = _axes(row)
    side = 1 if row.side == "right" else -1
    return np.array([side * row.offset, row.shift]) + entrance * row.entrance * number


def _turn(point: np.ndarray, turn: float) -> Point:
    x, y = point
    return float(x * np.cos(turn) - y * np.sin(turn)), float(x * np.sin(turn) + y * np.cos(turn))
