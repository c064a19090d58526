"""Domain layout: how many slots, and where, along a roadside beside (or across) the way of the car."""

from __future__ import annotations

import math

import attrs
import numpy as np

from pavemark.plate import Plate, Roadside
from pavemark.randomize.car import Car, find_car
from pavemark.randomize.fitted import Fitted
from pavemark.randomize.free import moved, seen_part, shifted
from pavemark.randomize.row import Row, Stretch
from pavemark.randomize.shape import Shape
from pavemark.randomize.streams import Stage, happens, quantile, stream, uniform
from pavemark.records import interval, within

_share = within(0.0, 1.0)

TRIES = 12
"""Places tried for a row before it is left out."""

FREE_TRIES = 6
"""Places tried before that where nothing stands in the slots; each is moved until there is free ground."""

_SIDE = 16
"""Slots drawn to either side of the first; more than fit into any frame of interest."""

_PROBE = 0.15
"""Metres from a marking point along its lines at which there must be ground too, or nobody could see its shape."""

_STEM = 1.0
"""Metres into the slot at which there must be ground, too, where ground is known well enough to tell the roadside: an
entrance line along a kerb or a wall has no slots behind it."""


_AISLE = 2.5
"""Metres between two opposite entrance lines, at least: a car must pass."""

_SKEW = (-1.0, 1.0)
"""Degrees between two opposite entrance lines; half of the real ones are within ±0.6."""

_SCATTER = (-1.0, 1.0)
"""Degrees of a row about the roadside's direction, which is itself known to half a degree."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    empty_rate : float
        Share of images without any marking.
    original_rate : float
        Share of images with markings in which, instead of new slots, the image's own markings are re-painted: 0 is the
        paper's random line mask, 1 its original one. Images without markings get new slots.
    both_sides : float
        Share of images that also have a row opposite the first.
    run_on : float
        Probability, for either end of a row, that it runs out of the frame rather than ends after as many slots as
        real rows have.
    offset : tuple of float
        Lateral offset in metres of the entrance line, added to the fitted distance from the car, or to the roadside's
        line.
    on_line : float
        Share of the rows that begin where the plate's own roadside does, where that is known, rather than at a fitted
        distance from the car.
    turned : float
        Share of the images whose rows are turned away from the roadside, as a car sees them that turns into a slot.
    turn : tuple of float
        Degrees by which they are.
    gap_rate : float or None
        Share of neighbouring slots with a gap between them, such as a pillar's; as fitted where it is not given.
    gap : tuple of float
        Factors on the fitted gaps.
    symbol_rate : float
        Share of images with slot numbers or arrows.
    slots : tuple of int
        Fewest and most slots of a row that ends in the frame; between them as many as real rows have.
    """

    empty_rate: float = attrs.field(default=0.1, validator=_share)
    original_rate: float = attrs.field(default=0.0, validator=_share)
    both_sides: float = attrs.field(default=0.25, validator=_share)
    run_on: float = attrs.field(default=0.7, validator=_share)
    offset: tuple[float, float] = attrs.field(default=(-0.3, 0.3), validator=interval(-10.0, 10.0))
    on_line: float = attrs.field(default=0.5, validator=_share)
    turned: float = attrs.field(default=0.0, validator=_share)
    turn: tuple[float, float] = attrs.field(default=(-45.0, 45.0), validator=interval(-90.0, 90.0))
    gap_rate: float | None = attrs.field(default=None, validator=attrs.validators.optional(_share))
    gap: tuple[float, float] = attrs.field(default=(1.0, 1.0), validator=interval(0.1, 5.0))
    symbol_rate: float = attrs.field(default=0.3, validator=_share)
    slots: tuple[int, int] = attrs.field(default=(1, _SIDE + 1), validator=interval(1, _SIDE + 1))


@attrs.frozen
class Choice:
    """What an image is painted with.

    Attributes
    ----------
    content : str
        Nothing ("empty"), its own markings ("original") or new slots ("slots").
    both_sides : bool
        Whether there is a row opposite the first as well.
    gap : float
        Factor on the fitted gaps between slots.
    turn : float
        Degrees by which rows are turned away from the roadside.
    """

    content: str
    both_sides: bool
    gap: float
    turn: float


def choose(rng: np.random.Generator, ranges: Ranges) -> Choice:
    """Draw what an image is painted with."""
    empty, original, both = rng.random(3)
    content = "empty" if empty < ranges.empty_rate else "original" if original < ranges.original_rate else "slots"
    gap = uniform(rng, ranges.gap)
    turn = uniform(rng, ranges.turn) if happens(rng, ranges.turned) else 0.0
    return Choice(content, bool(both < ranges.both_sides), gap, turn)


def sample(
    job_seed: int, index: int, ranges: Ranges, fitted: Fitted, plate: Plate, shape: Shape, choice: Choice
) -> tuple[Row, ...]:
    """Draw the rows of an image: none, one, or two opposite each other.

    Each try to place a row draws from a stream of its own, so that its draws do not depend on the tries before. Where
    the plate's roadside is known, rows follow it, and a place where nothing stands in the slots is looked for first.
    """
    car = find_car(plate)
    if not car.sides:
        return ()
    first = _placed(job_seed, index, 0, ranges, fitted, plate, car, shape, choice)
    if first is None:
        return ()
    if not choice.both_sides or len(car.sides) < 2:
        return (first,)
    second = _placed(job_seed, index, 1, ranges, fitted, plate, car, shape.mirrored(), choice, first)
    return (first,) if second is None else (first, second)


def _placed(
    job_seed: int,
    index: int,
    number: int,
    ranges: Ranges,
    fitted: Fitted,
    plate: Plate,
    car: Car,
    shape: Shape,
    choice: Choice,
    opposite: Row | None = None,
) -> Row | None:
    for free, tries in ((True, 0 if plate.roadside is None else FREE_TRIES), (False, TRIES)):
        for attempt in range(tries):
            rng = stream(job_seed, index, Stage.LAYOUT, 1, number, attempt)
            line_rng = stream(job_seed, index, Stage.LAYOUT, 2, number, attempt)
            row = _place(rng, line_rng, ranges, fitted, plate, car, shape, choice.turn, opposite)
            spots = None
            if free:
                row, spots = moved(row, plate, car)
                if not len(spots):
                    continue
            if opposite is not None and not _leaves_an_aisle(row, opposite):
                continue
            row = _fill(rng, ranges, fitted, plate, row, spots, choice.gap)
            if row is not None:
                return row
    return None


def _place(
    rng: np.random.Generator,
    line_rng: np.random.Generator,
    ranges: Ranges,
    fitted: Fitted,
    plate: Plate,
    car: Car,
    shape: Shape,
    away: float,
    opposite: Row | None,
) -> Row:
    """Draw where the entrance line runs: a row without slots, its origin the point nearest to the car's centre."""
    family, roadside = getattr(fitted, shape.family), plate.roadside
    across = rng.random() < family.across and len(car.sides) == 2
    forwards = rng.random() < fitted.left
    if roadside is None:
        turn = quantile(rng, family.turn_across if across else family.turn)
    else:
        turn = math.degrees(roadside.direction) - 90.0 + uniform(rng, _SCATTER)
    clearance = quantile(rng, family.clearance_across if across else family.clearance)
    offset = uniform(rng, ranges.offset)
    if opposite is None:
        # Slots lie to the left of their heading: up the picture has them left of the car, down the picture right.
        up = forwards if len(car.sides) == 2 else car.sides[0] < 0
        heading = math.radians(turn + away + (90.0 if up else -90.0) + (90.0 if across else 0.0))
    else:
        heading = opposite.heading + math.pi + math.radians(uniform(rng, _SKEW))
        clearance = abs(clearance)
    row = Row(shape, (car.x, 0.0), heading, ())
    on_line = roadside is not None and line_rng.random() < ranges.on_line
    line = _roadside_line(row, roadside) if on_line else None
    if line is None:
        distance = clearance + offset + car.reach(row.normal)
    else:
        distance = line + offset - car.x * float(row.normal[0])
    return shifted(row, distance)


def _roadside_line(row: Row, roadside: Roadside) -> float | None:
    """Metres along the row's normal from the frame's centre to where the roadside begins on that side."""
    leftwards = float(row.normal @ (-math.sin(roadside.direction), math.cos(roadside.direction)))
    if abs(leftwards) < math.cos(math.radians(45.0)):
        return None  # the row runs across the roadside
    line = roadside.left if leftwards > 0 else roadside.right
    return None if line is None else line * math.copysign(1.0, leftwards)


def _leaves_an_aisle(row: Row, opposite: Row) -> bool:
    return float((np.asarray(opposite.origin) - row.origin) @ row.normal) <= -_AISLE


def _fill(
    rng: np.random.Generator,
    ranges: Ranges,
    fitted: Fitted,
    plate: Plate,
    row: Row,
    free: np.ndarray | None,
    gap: float,
) -> Row | None:
    """Draw the slots along an entrance line, one of them at one of the `free` places where such are known.

    None where no whole slot would be seen.
    """
    shape = row.shape
    starts, ends = _slots_along(rng, ranges, fitted, shape, gap)
    place = rng.random()
    count = 1 + int(np.searchsorted(np.cumsum(getattr(fitted, shape.family).count), rng.random()))
    count = min(max(count, ranges.slots[0]), ranges.slots[1])
    before = min(int(rng.random() * count), count - 1)
    run_before, run_after = rng.random(2) < ranges.run_on

    seen = seen_part(row, plate.frame)
    if seen is None or seen[1] - seen[0] < shape.entrance:
        return None
    room = seen[1] - seen[0] - shape.entrance
    shift = seen[0] + place * room if free is None else free[int(place * len(free))]
    starts, ends = starts + shift, ends + shift
    number = np.arange(-_SIDE, _SIDE + 1)
    wanted = (run_before | (number >= -before)) & (run_after | (number < count - before))
    margin = shape.entrance + abs(shape.depth * math.cos(shape.angle))
    near = (ends > seen[0] - margin) & (starts < seen[1] + margin)

    front = np.stack([starts, ends], 1)
    inside, on_ground = _look(row, plate, front)
    if not (wanted & near & (inside & on_ground).all(1)).any():
        return None
    shown = wanted & near & (~inside | on_ground).all(1)
    hidden = (wanted[:, None] & inside & ~on_ground).sum() > (wanted[:, None] & inside & on_ground).sum()
    if hidden and free is None:
        return None
    return attrs.evolve(row, stretches=_stretches(starts[shown], ends[shown]))


def _slots_along(
    rng: np.random.Generator, ranges: Ranges, fitted: Fitted, shape: Shape, gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """Where slots start and end (N,) along the entrance line, the one in the middle starting at 0."""
    count = 2 * _SIDE + 1
    steps = np.linspace(0.0, 1.0, len(fitted.variation))
    # A table of ratios between neighbours: each of the two varies by its square root.
    lengths = shape.entrance * np.sqrt(np.interp(rng.random(count), steps, fitted.variation))
    gaps = np.interp(rng.random(count), np.linspace(0.0, 1.0, len(fitted.gap)), fitted.gap)
    gaps *= gap * (rng.random(count) < (fitted.gap_rate if ranges.gap_rate is None else ranges.gap_rate))
    starts = np.concatenate([[0.0], np.cumsum(lengths + gaps)[:-1]])
    starts -= starts[_SIDE]
    return starts, starts + lengths


def _look(row: Row, plate: Plate, front: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether marking points, given along the entrance line (N, 2), are in the frame, and their lines on ground."""
    points = np.asarray(row.origin) + front[..., None] * row.along
    stem = _PROBE if plate.roadside is None else _STEM
    probes = np.array([np.zeros(2), _PROBE * row.along, -_PROBE * row.along, stem * row.inwards])
    uv = plate.frame.to_image(points[..., None, :] + probes)
    inside = plate.frame.contains(uv)
    u, v = np.floor(uv).astype(np.int64)[..., 0], np.floor(uv).astype(np.int64)[..., 1]
    ground = plate.ground[np.clip(v, 0, plate.frame.height - 1), np.clip(u, 0, plate.frame.width - 1)]
    return inside[..., 0], (ground | ~inside).all(-1)


def _stretches(starts: np.ndarray, ends: np.ndarray) -> tuple[Stretch, ...]:
    """Slots joined where one ends as the next starts."""
    stretches: list[list[float]] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        # A thousandth of a millimetre: neighbours meet to rounding, gaps are wider than centimetres.
        if stretches and abs(start - stretches[-1][-1]) < 1e-6:
            stretches[-1].append(end)
        else:
            stretches.append([start, end])
    return tuple(map(tuple, stretches))
