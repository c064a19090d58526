"""A scene after its curves were moved by hand: the slots follow the lines they belong to."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import attrs
import numpy as np

from pavemark.scene import Area, Marking, Path, Scene, Slot, Stroke

AT = 1e-3
"""Metres between a slot's corner and the point of a line that it goes with; curves are kept in float32."""

RIGID = 1e-4
"""Metres by which points may be off a turn, a shift and a change of size for a marking to count as moved whole."""


@attrs.frozen
class Drawn:
    """What curves show of a marking.

    Attributes
    ----------
    number : int
        Of the marking in the scene. The first of a number is the marking itself, further ones are copies of it.
    strokes : tuple of Stroke
    areas : tuple of Area
    """

    number: int
    strokes: tuple[Stroke, ...] = ()
    areas: tuple[Area, ...] = ()


def follow(scene: Scene, drawn: Iterable[Drawn]) -> Scene:
    """The scene as its curves are now.

    A marking whose curves are gone is gone, and its slots with it; a copied marking has copies of its slots. A corner
    goes where the point of its line went; one that is not painted goes with its marking where that was moved whole, and
    with the marking point in front of it otherwise. What was not moved, to the precision of float32, stays as it was to
    the last bit.

    Parameters
    ----------
    scene : Scene
        As it was.
    drawn : iterable of Drawn

    Returns
    -------
    Scene
        The same object when nothing was moved.

    Raises
    ------
    ValueError
        When a slot is no longer one: its corners turn right, or a line is too wide or too far away.
    """
    drawn = list(drawn)
    versions = [
        [_settled(marking, one) for one in drawn if one.number == number]
        for number, marking in enumerate(scene.markings)
    ]
    markings = tuple(marking for each in versions for marking in each)
    if markings == scene.markings:
        return scene
    slots = []
    for number, slot in enumerate(scene.slots):
        owner = next((k for k, marking in enumerate(scene.markings) if _bound(slot, marking)), None)
        if owner is None:
            slots.append(slot)
            continue
        for marking in versions[owner]:
            corners = _moved(slot, scene.markings[owner], marking)
            if corners is not None:
                slots.append(_evolved(slot, corners, number))
    # Relief is that of markings.
    relief = scene.relief if markings else None
    return attrs.evolve(scene, markings=markings, slots=tuple(slots), relief=relief)


def _evolved(slot: Slot, corners: tuple, number: int) -> Slot:
    try:
        return attrs.evolve(slot, corners=corners)
    except ValueError as error:
        raise ValueError(f"slot {number + 1}: {error}") from None


def _settled(marking: Marking, drawn: Drawn) -> Marking:
    """The marking as drawn, with its own numbers wherever float32 cannot tell the two apart."""
    strokes = tuple(
        Stroke(
            _same(old.path, new.path),
            old.width if _alike(old.width, new.width) else new.width,
            new.closed,
        )
        for old, new in _paired(marking.strokes, drawn.strokes, lambda stroke: stroke.path)
    )
    areas = tuple(
        Area(
            _same(old.ring, new.ring),
            tuple(_same(before, now) for before, now in _paired(old.holes, new.holes, lambda hole: hole)),
        )
        for old, new in _paired(marking.areas, drawn.areas, lambda area: area.ring)
    )
    return attrs.evolve(marking, strokes=strokes, areas=areas)


def _paired(old: tuple, new: tuple, path: Callable[[Any], Path]) -> Iterable[tuple]:
    """What is new with what it was: by its number, or where some came or went by its path; else with itself."""
    if len(old) == len(new):
        return zip(old, new, strict=True)
    return ((next((was for was in old if _same(path(was), path(now)) == path(was)), now), now) for now in new)


def _same(old: Path, new: Path) -> Path:
    if len(old) != len(new):
        return new
    return tuple(a if _alike(a[0], b[0]) and _alike(a[1], b[1]) else b for a, b in zip(old, new, strict=True))


def _alike(a: float, b: float) -> bool:
    return np.float32(a) == np.float32(b)


def _vertices(marking: Marking) -> np.ndarray:
    points = [point for stroke in marking.strokes for point in stroke.path]
    points += [point for area in marking.areas for ring in (area.ring, *area.holes) for point in ring]
    return np.array(points, np.float64).reshape(-1, 2)


def _shape(marking: Marking) -> list[int]:
    rings = [ring for area in marking.areas for ring in (area.ring, *area.holes)]
    return [len(stroke.path) for stroke in marking.strokes] + [len(ring) for ring in rings]


def _at(corner: np.ndarray, vertices: np.ndarray) -> int | None:
    if not len(vertices):
        return None
    away = np.hypot(*(vertices - corner).T)
    nearest = int(away.argmin())
    return nearest if away[nearest] <= AT else None


def _bound(slot: Slot, marking: Marking) -> bool:
    vertices = _vertices(marking)
    return marking.kind in ("slot", "original") and any(
        _at(np.array(corner), vertices) is not None for corner in slot.corners[:2]
    )


def _moved(slot: Slot, before: Marking, after: Marking) -> tuple | None:
    """The slot's corners after its marking was moved; None when the marking points have gone."""
    old, new = _vertices(before), _vertices(after)
    if _shape(before) == _shape(after):
        kept = np.ones(len(old), bool)
    else:
        # Points were added or taken away: those that are still there have not moved.
        nearest = [_at(point, new) for point in old]
        kept = np.array([k is not None for k in nearest], bool)
        new = np.array([new[k] if k is not None else point for k, point in zip(nearest, old, strict=True)])
    corners = np.array(slot.corners)
    at = [_at(corner, old) for corner in corners]
    if not any(kept[k] for k in at[:2] if k is not None):
        return None
    whole = _similarity(old[kept], new[kept])
    moved = [None if k is None else new[k] for k in at]
    for k, other, before_it in ((0, 1, 1), (1, 0, 0), (2, 3, 1), (3, 2, 0)):
        if moved[k] is None and whole is not None:
            moved[k] = whole(corners[k])
        elif moved[k] is None:
            guide = before_it if moved[before_it] is not None else other
            moved[k] = corners[k] + (moved[guide] - corners[guide])
    return tuple((float(x), float(y)) for x, y in moved)


def _similarity(old: np.ndarray, new: np.ndarray):
    """The turn, shift and change of size that took points (N, 2) to others, or None where it was another map.

    In complex numbers z → a·z + b, in the least-squares sense.
    """
    z, w = (points @ (1, 1j) for points in (old, new))
    spread = z - z.mean()
    if len(z) < 2 or not np.abs(spread).max() > AT:
        return None
    a = (spread.conj() @ (w - w.mean())) / (spread.conj() @ spread)
    b = w.mean() - a * z.mean()
    if np.abs(a * z + b - w).max() > RIGID:
        return None

    def moved(point: np.ndarray) -> np.ndarray:
        there = a * complex(*point) + b
        return np.array((there.real, there.imag))

    return moved
