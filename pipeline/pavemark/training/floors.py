"""Floors of our own: asphalt, concrete, brick, tiles, turf pavers and epoxy, as reflectance in linear light."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np

from pavemark.training.canvas import SIDE, Stencil, axes, clouds, fill, speckle


@attrs.frozen(eq=False)
class Floor:
    """What the light meets.

    Attributes
    ----------
    albedo : ndarray (SIDE, SIDE, 3) float32
        Reflectance.
    gloss : ndarray (SIDE, SIDE) float32
        0 matt to 1 a mirror of the lamps.
    """

    albedo: np.ndarray
    gloss: np.ndarray


def sample(rng: np.random.Generator, scale: float, turn: float, kind: str | None = None) -> Floor:
    """Draw a floor.

    Parameters
    ----------
    rng : Generator
    scale : float
        Pixels per metre.
    turn : float
        Radians of the rows of slots against the rows of pixels: zones and bands follow them.
    kind : str or None
        "pavers" or "epoxy"; None draws one of all kinds.
    """
    indoors = rng.random() < 0.45 if kind is None else kind == "epoxy"
    kinds = _INDOORS if indoors else _PAVERS if kind == "pavers" else _OUTDOORS
    name = str(rng.choice(list(kinds)))
    albedo, gloss = kinds[name](rng, scale, turn)
    for _ in range(int(rng.choice(4, p=(0.45, 0.25, 0.2, 0.1)))):
        other = kinds[name] if indoors or rng.random() < 0.4 else _OUTDOORS[str(rng.choice(list(_OUTDOORS)))]
        zone = _zone(rng, scale, turn)[..., None]
        albedo2, gloss2 = other(rng, scale, turn)
        albedo = albedo * (1 - zone) + albedo2 * zone
        gloss = gloss * (1 - zone[..., 0]) + gloss2 * zone[..., 0]
    # Indoors a light band would be paint to anybody.
    for _ in range(0 if indoors else int(rng.choice(3, p=(0.7, 0.2, 0.1)))):
        albedo = _bands(rng, scale, turn, albedo)
    level = np.ones((SIDE, SIDE), np.float32)
    if rng.random() < 0.5:
        level *= 1 - rng.uniform(0.2, 0.7) * _cracks(rng, int(rng.integers(1, 8)))
    if rng.random() < 0.5:
        level *= 1 - rng.uniform(0.2, 0.8) * _stains(rng, int(rng.integers(1, 9)), scale)
    if rng.random() < 0.5:
        level *= 1 + rng.uniform(-0.4, 0.25) * _tracks(rng, int(rng.integers(1, 4)), scale)
    albedo = albedo * level[..., None]
    for _ in range(int(rng.choice(3, p=(0.7, 0.2, 0.1)))):
        albedo = _drain(rng, scale, albedo)
    return Floor(np.clip(albedo, 0.008, 0.9).astype(np.float32), np.clip(gloss, 0, 1).astype(np.float32))


def _tinted(level: np.ndarray, tint: np.ndarray) -> np.ndarray:
    return (level[..., None] * np.asarray(tint, np.float32)).astype(np.float32)


def _warmth(rng: np.random.Generator, spread: float = 0.06) -> np.ndarray:
    warm = rng.normal(0, spread)
    return np.array([1 + warm, 1 + rng.normal(0, spread / 3), 1 - warm])


def _matt(rng: np.random.Generator) -> np.ndarray:
    return np.full((SIDE, SIDE), rng.uniform(0, 0.15), np.float32)


def _asphalt(rng, scale, turn):
    level = np.exp(rng.uniform(np.log(0.05), np.log(0.3)))
    level = level * (
        1
        + rng.uniform(0.03, 0.2) * clouds(rng, scale * rng.uniform(1, 4), 4)
        + rng.uniform(0, 0.15) * clouds(rng, 0.06 * scale, 2)
        + rng.uniform(0.02, 0.25) * speckle(rng)
    )
    if rng.random() < 0.3:
        for _ in range(int(rng.integers(1, 6))):
            patch = _rectangle(rng, scale * rng.uniform(0.4, 4, 2), turn + rng.normal(0, 0.1))
            level = level * (1 - patch * rng.uniform(-0.3, 0.6))
    return _tinted(level, _warmth(rng)), _matt(rng)


def _concrete(rng, scale, turn):
    x, y = axes(turn + rng.normal(0, 0.1), rng.uniform(0, SIDE, 2), scale)
    period, width = rng.uniform(1.5, 6), rng.uniform(0.005, 0.02)
    joint = np.minimum(np.abs(x % period - period / 2), np.abs(y % period - period / 2)) < width
    tone = rng.normal(0, rng.uniform(0, 0.12), (64, 64)).astype(np.float32)
    slab = tone[np.floor(y / period + 0.5).astype(int) % 64, np.floor(x / period + 0.5).astype(int) % 64]
    level = rng.uniform(0.15, 0.5) * (
        1
        + slab
        + rng.uniform(0.02, 0.15) * clouds(rng, 2.5 * scale, 6)
        + rng.uniform(0, 0.08) * cv2.blur(speckle(rng), (41, 1)) * 5
        + rng.uniform(0.01, 0.1) * speckle(rng)
    )
    level *= 1 - rng.uniform(0.0, 0.7) * joint
    return _tinted(level, _warmth(rng)), _matt(rng)


def _bricks(rng: np.random.Generator, scale: float, turn: float, long: float, wide: float):
    """Bricks in bond: the number of a tone (SIDE, SIDE) for each, and how much of each pixel is joint."""
    x, y = axes(turn, rng.uniform(0, SIDE, 2), scale)
    row = np.floor(y / wide).astype(int)
    shifted = x + (row % 2) * long * rng.choice([0.0, 0.5, 0.5, 0.33])
    column = np.floor(shifted / long).astype(int)
    edge = np.minimum(long / 2 - np.abs(shifted % long - long / 2), wide / 2 - np.abs(y % wide - wide / 2))
    joint = np.clip((rng.uniform(0.003, 0.012) - edge) * scale + 0.5, 0, 1).astype(np.float32)
    return row, column, joint


_CLAYS = np.array(
    [
        (0.30, 0.17, 0.12), (0.20, 0.145, 0.115), (0.36, 0.24, 0.13), (0.27, 0.25, 0.23), (0.42, 0.36, 0.29),
        (0.14, 0.13, 0.125), (0.45, 0.22, 0.08), (0.22, 0.20, 0.21), (0.5, 0.46, 0.42), (0.16, 0.10, 0.08),
    ],
    np.float32,
)  # fmt: skip


def _brick(rng, scale, turn):
    long = rng.choice([0.2, 0.2, 0.25, 0.3, 0.12])
    wide = long * rng.choice([0.5, 0.5, 1.0, 0.33])
    row, column, joint = _bricks(
        rng, scale, turn + rng.choice([0, np.pi / 2, np.pi / 4, rng.uniform(0, 3)]), long, wide
    )
    clays = _CLAYS[rng.integers(len(_CLAYS), size=int(rng.integers(1, 4)))] * rng.uniform(0.6, 1.3)
    if rng.random() < 0.3:
        period = int(rng.integers(2, 8))
        clay = ((row // period + column // period) % len(clays)).astype(int)
    else:
        clay = rng.integers(len(clays), size=(97, 89))[row % 97, column % 89]
    tone = rng.normal(0, rng.uniform(0.02, 0.2), (97, 89)).astype(np.float32)[row % 97, column % 89]
    level = 1 + tone + rng.uniform(0.03, 0.15) * clouds(rng, 2 * scale, 5) + rng.uniform(0.02, 0.15) * speckle(rng)
    # Joints of sand are lighter than the bricks, of earth darker.
    level *= 1 + joint * (rng.uniform(-0.75, -0.2) if rng.random() < 0.7 else rng.uniform(0.1, 0.6))
    return clays[clay] * level[..., None].astype(np.float32), _matt(rng)


def _tiles(rng, scale, turn):
    long = rng.uniform(0.3, 1.0)
    row, column, joint = _bricks(
        rng, scale, turn + rng.choice([0.0, rng.uniform(0, 3)]), long, long * rng.choice([1.0, 0.5])
    )
    tone = rng.normal(0, rng.uniform(0.02, 0.15), (64, 64)).astype(np.float32)[row % 64, column % 64]
    level = rng.uniform(0.12, 0.5) * (1 + tone + 0.09 * clouds(rng, 2.5 * scale, 5) + 0.08 * speckle(rng))
    level *= 1 - rng.uniform(0.1, 0.7) * joint
    return _tinted(level, _warmth(rng, 0.1)), np.full(level.shape, rng.uniform(0, 0.5), np.float32)


def _turf(rng, scale, turn):
    x, y = axes(turn + rng.normal(0, 0.05), rng.uniform(0, SIDE, 2), scale)
    step = rng.uniform(0.09, 0.22)
    row = np.floor(y / step)
    x = x + (row % 2) * step * rng.choice([0.0, 0.5])
    across, along = x % step - step / 2, y % step - step / 2
    size = step * rng.uniform(0.2, 0.36)
    hole = np.hypot(across, along) if rng.random() < 0.6 else np.maximum(np.abs(across), np.abs(along))
    hole = np.clip((size - hole) * scale + 0.5, 0, 1)[..., None]
    level = rng.uniform(0.2, 0.5) * (1 + 0.1 * clouds(rng, 2 * scale, 5) + 0.1 * speckle(rng))
    green = np.clip(0.5 + 0.5 * clouds(rng, 1.2 * scale, 4), 0, 1)[..., None]
    earth = green * np.array([0.05, 0.10, 0.03]) + (1 - green) * np.array([0.09, 0.07, 0.05])
    # Grass grows over the webs, too.
    over = np.clip(rng.uniform(-0.8, 0.5) + 0.5 * clouds(rng, 0.7 * scale, 4), 0, 0.8)[..., None]
    hole = np.maximum(hole, over)
    return (earth * hole + _tinted(level, _warmth(rng, 0.1)) * (1 - hole)).astype(np.float32), _matt(rng)


def _epoxy(rng, scale, turn):
    level = 1 + rng.uniform(0.01, 0.07) * clouds(rng, 3 * scale, 5) + rng.uniform(0.005, 0.05) * speckle(rng)
    if rng.random() < 0.55:
        colour = np.exp(rng.uniform(np.log(0.06), np.log(0.45))) * _warmth(rng, 0.07)
    else:
        hue = rng.choice([0, 2, 60, 70, 80, 85, 90, 100, 110, 165, 170, 175])
        hsv = np.uint8([[[hue, rng.integers(40, 255), rng.integers(90, 255)]]])
        colour = (cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0] / 255.0) ** 2.2 * rng.uniform(0.4, 0.9)
    return _tinted(level, colour), np.full(level.shape, rng.uniform(0.2, 1.0), np.float32)


Kind = Callable[[np.random.Generator, float, float], tuple[np.ndarray, np.ndarray]]
_OUTDOORS: dict[str, Kind] = {
    "asphalt": _asphalt,
    "concrete": _concrete,
    "brick": _brick,
    "paving": _brick,
    "tiles": _tiles,
    "turf": _turf,
}
_PAVERS: dict[str, Kind] = {"turf": _turf, "brick": _brick}
_INDOORS: dict[str, Kind] = {"epoxy": _epoxy, "coat": _epoxy, "paint": _epoxy, "concrete": _concrete}


def _rectangle(rng: np.random.Generator, size: np.ndarray, turn: float) -> np.ndarray:
    """A rectangle somewhere: (SIDE, SIDE) float32."""
    sheet = np.zeros((SIDE, SIDE), np.float32)
    corners = cv2.boxPoints((rng.uniform(0, SIDE, 2).tolist(), size.tolist(), float(np.degrees(turn))))
    fill(sheet, corners, 1.0)
    return sheet


def _zone(rng: np.random.Generator, scale: float, turn: float) -> np.ndarray:
    """A part of the floor that is laid with something else, straight-edged, along or across the rows."""
    x, y = axes(turn + rng.choice([0, np.pi / 2]) + rng.normal(0, 0.02), np.full(2, SIDE / 2), scale)
    start = rng.uniform(-4, 4)
    width = rng.choice([rng.uniform(0.3, 1.2), rng.uniform(1.2, 3), 20.0])
    inside = (x > start) & (x < start + width)
    if rng.random() < 0.3:
        period = rng.uniform(2.3, 3.2)
        inside &= (y % period) > rng.uniform(0, 0.5)
    return cv2.GaussianBlur(inside.astype(np.float32), (0, 0), rng.uniform(0.3, 1.0))


def _bands(rng: np.random.Generator, scale: float, turn: float, albedo: np.ndarray) -> np.ndarray:
    """Courses of another stone: edgings, gutters, dark or light bands between slots; they are no markings."""
    x, y = axes(turn + rng.choice([0, np.pi / 2]), np.full(2, SIDE / 2), scale)
    start, width = rng.uniform(-4, 4), rng.uniform(0.2, 0.6)
    inside = (x > start) & (x < start + width)
    if rng.random() < 0.4:
        period = rng.uniform(2.3, 3.2)
        inside |= np.abs((y - start) % period - period / 2) < width / 2
    tone = albedo.mean((0, 1)) * np.exp(rng.uniform(-0.8, 0.5)) * _warmth(rng, 0.06)
    stone = _tinted(1 + 0.1 * clouds(rng, 0.3 * scale, 3) + 0.08 * speckle(rng), tone)
    joint = (y % rng.uniform(0.3, 1.0)) < 0.012
    if rng.random() < 0.7:
        stone = stone * (1 - rng.uniform(0.2, 0.6) * joint[..., None])
    return np.where(inside[..., None], stone, albedo)


def _cracks(rng: np.random.Generator, count: int) -> np.ndarray:
    """Wandering cracks, 0 to 1."""
    sheet = np.zeros((SIDE, SIDE), np.uint8)
    for _ in range(count):
        steps = int(rng.integers(20, 120))
        heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.25, steps))
        path = rng.uniform(0, SIDE, 2) + np.cumsum(np.stack([np.cos(heading), np.sin(heading)], -1) * 4, 0)
        width = int(rng.choice([1, 1, 1, 2]))
        cv2.polylines(
            sheet, [np.rint(path * 8).astype(np.int32)], False, int(rng.integers(90, 255)), width, cv2.LINE_AA, 3
        )
    return sheet.astype(np.float32) / 255


def _stains(rng: np.random.Generator, count: int, scale: float) -> np.ndarray:
    """Oil and water: soft round spots, 0 to 1."""
    sheet = np.zeros((SIDE, SIDE), np.float32)
    for _ in range(count):
        centre = rng.uniform(0, SIDE, 2)
        for _ in range(int(rng.integers(1, 10))):
            spot = np.rint(centre + rng.normal(0, 0.25 * scale, 2)).astype(int)
            radius = max(1, int(rng.uniform(0.02, 0.2) * scale))
            cv2.circle(sheet, tuple(spot.tolist()), radius, float(rng.uniform(0.3, 0.9)), -1)
    return cv2.GaussianBlur(sheet, (0, 0), 2.5)


def _tracks(rng: np.random.Generator, count: int, scale: float) -> np.ndarray:
    """Tyre marks in pairs, 0 to 1."""
    sheet = np.zeros((SIDE, SIDE), np.float32)
    for _ in range(count):
        t = np.linspace(-1, 1, 40)
        angle = rng.normal(np.pi / 2, 0.3) if rng.random() < 0.6 else rng.uniform(0, np.pi)
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        bend, shift = rng.normal(0, 1.5), rng.normal(0, 3)
        for wheel in (-0.75, 0.75):
            path = (t[:, None] * 7 * along + (shift + wheel + bend * t**2)[:, None] * across) * scale + SIDE / 2
            strength = float(rng.uniform(0.3, 1.0))
            cv2.polylines(sheet, [np.rint(path * 8).astype(np.int32)], False, strength, max(2, int(0.18 * scale)), 8, 3)
    worn = np.clip(0.6 + 0.5 * clouds(rng, scale, 5), 0, 1)
    return np.clip(cv2.GaussianBlur(sheet, (0, 0), rng.uniform(0.8, 3)) * worn, 0, 1)


def _drain(rng: np.random.Generator, scale: float, albedo: np.ndarray) -> np.ndarray:
    """A manhole, a grating in its frame, or a gutter."""
    turn, centre = rng.uniform(0, np.pi), rng.uniform(0, SIDE, 2)
    frame, lid, bars = Stencil(), Stencil(), Stencil()
    long = scale * rng.uniform(0.3, 0.8)
    wide = long * rng.choice([1.0, 1.0, 0.5])
    rim = scale * rng.uniform(0.02, 0.06)
    if rng.random() < 0.4:
        ring = np.stack([np.cos(np.linspace(0, 2 * np.pi, 24)), np.sin(np.linspace(0, 2 * np.pi, 24))], -1)
        frame.polygon(centre + ring * (long / 2 + rim))
        lid.polygon(centre + ring * long / 2)
    else:
        box = (centre.tolist(), (long, wide), float(np.degrees(turn)))
        frame.polygon(cv2.boxPoints((box[0], (long + 2 * rim, wide + 2 * rim), box[2])))
        lid.polygon(cv2.boxPoints(box))
        if rng.random() < 0.6:
            along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
            for k in np.linspace(-0.4, 0.4, int(rng.integers(3, 8))):
                bars.line(centre + along * long * k + np.outer([-0.45, 0.45], across) * wide, max(1.0, 0.03 * scale))
    tone = albedo.mean((0, 1))
    for stencil, level in ((frame, rng.uniform(0.5, 2.2)), (lid, rng.uniform(0.3, 0.9)), (bars, rng.uniform(0.3, 1.6))):
        cover = stencil.coverage()[..., None]
        albedo = albedo * (1 - cover) + tone * level * cover
    return albedo
