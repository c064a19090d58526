"""What stands on the ground, as a low camera smears it over a view from above.

A thing is a pile of slices. A camera h metres up sees the slice at height z where the ray through it meets the ground:
the slice's outline, enlarged by h / (h - z) about the camera's foot. Drawn from the ground up, each slice covers what
it hides; what lies above the camera is never seen on the ground.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np

from pavemark.training.canvas import SIDE, fill
from pavemark.training.paint import Row

_HIGHEST = 0.985
"""Share of the camera's height up to which slices are drawn: beyond it they leave any view."""

STEP = 5.0
"""Pixels between two slices, about."""

Outline = Callable[[float], "np.ndarray | None"]
Shade = Callable[[float], np.ndarray]


@attrs.frozen(eq=False)
class Body:
    """A thing on the ground.

    Attributes
    ----------
    foot : ndarray (N, 2)
        Outline on the ground, pixels.
    height : float
        Metres.
    outline : callable
        Height in metres → outline (N, 2) in pixels, None where there is nothing.
    shade : callable
        Height in metres → reflectance (3,).
    parts : tuple of (outline, shade)
        Drawn after each slice of the body: wheels, lamps, plates.
    dark : float
        Share of the light that it takes from the ground beside it.
    """

    foot: np.ndarray
    height: float
    outline: Outline
    shade: Shade
    parts: tuple[tuple[Outline, Shade], ...] = ()
    dark: float = 0.4


def sample(
    rng: np.random.Generator, scale: float, turn: float, slots: tuple[Row, ...], full: bool = False
) -> list[Body]:
    """Draw what stands on the ground; in a `full` car park there are cars in most slots."""
    found = []
    for row in slots:
        occupied = 0.8 if full else rng.choice([0.0, 0.3, 0.6])
        lean = rng.choice([0, np.pi]) + rng.normal(0, 0.03)
        for start in row.starts:
            if rng.random() < occupied:
                into = row.depth if row.depth < row.entrance else rng.uniform(3.7, 5.2) * scale
                middle = row.at(
                    start + row.entrance / 2 + rng.normal(0, 0.1) * scale, into / 2 + rng.uniform(0, 0.6) * scale
                )
                heading = row.into if row.depth > row.entrance else row.along
                found.append(_car(rng, middle, np.arctan2(heading[1], heading[0]) + lean, scale))
        if rng.random() < 0.3:
            shift, every = rng.uniform(0, 1) * row.entrance, int(rng.integers(1, 4))
            round_ = rng.random() < 0.5
            size = rng.uniform(0.25, 0.8)
            for start in row.starts[::every]:
                at = row.at(start + shift * (rng.random() < 0.2), rng.uniform(0.0, 1.2) * scale)
                found.append(_pillar(rng, at, size, turn, scale, round_))
        if rng.random() < 0.25:
            for start in row.starts:
                for part in (0.25, 0.75) if rng.random() < 0.7 else (0.5,):
                    at = row.at(start + row.entrance * part, row.depth * 0.8)
                    found.append(_stop(rng, at, row.along, scale))
    for side in (-1, 1):
        if rng.random() < 0.35:
            found += _roadside(rng, side, scale, turn)
    for _ in range(int(rng.choice(3, p=(0.6, 0.28, 0.12)))):
        kinds = (_pillar_somewhere, _post, _bush, _stray_car, _crate)
        found.append(kinds[int(rng.integers(len(kinds)))](rng, scale, turn))
    if rng.random() < 0.12:
        found.append(_bump(rng, scale, turn))
    return found


def _box(centre: np.ndarray, long: float, wide: float, angle: float) -> np.ndarray:
    """A rectangle (4, 2)."""
    return _turned(np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), centre, long, wide, angle)


def _rounded(centre: np.ndarray, long: float, wide: float, angle: float, power: float) -> np.ndarray:
    """A superellipse (28, 2): round with a power of 2, a box with one beyond 10."""
    c, s = np.cos(_AROUND), np.sin(_AROUND)
    unit = np.stack([np.sign(c) * np.abs(c) ** (2 / power), np.sign(s) * np.abs(s) ** (2 / power)], -1)
    return _turned(unit, centre, long, wide, angle)


_AROUND = np.linspace(0, 2 * np.pi, 28, endpoint=False)


def _turned(unit: np.ndarray, centre: np.ndarray, long: float, wide: float, angle: float) -> np.ndarray:
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    return centre + np.outer(unit[:, 0] * long / 2, along) + np.outer(unit[:, 1] * wide / 2, across)


def _car(rng: np.random.Generator, centre: np.ndarray, angle: float, scale: float) -> Body:
    long, wide = rng.uniform(4.0, 5.0) * scale, rng.uniform(1.7, 1.95) * scale
    grey = rng.choice([0.02, 0.04, 0.1, 0.3, 0.6, 0.8])
    paint = np.full(3, grey) if rng.random() < 0.75 else rng.uniform(0.01, 0.6, 3)
    belt, sill = rng.uniform(0.75, 0.95), rng.uniform(0.18, 0.3)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    gloss = rng.uniform(0.1, 0.5)
    sheen = np.interp(np.linspace(0, 1.6, 50), np.linspace(0, 1.6, 9), rng.uniform(0.6, 1.5, 9))
    corners, nose = rng.uniform(4.0, 8.0), rng.uniform(0.1, 0.6)
    # What is below the bumper is black plastic, in some cars up to half their height.
    skirt = sill + rng.choice([0.08, rng.uniform(0.08, 0.4)])

    def outline(z):
        if z < sill:
            return _rounded(centre, long * 0.93, wide * 0.85, angle, corners)
        if z < belt:
            # The bonnet and the boot rise towards the windows.
            up = max(0.0, z - 0.6)
            swell = 1 - 0.03 * abs(z - 0.55) / 0.35
            return _rounded(centre, long * (swell - nose * up), wide * (swell - 0.1 * up), angle, corners - 4 * up)
        lean = (z - belt) / 0.6
        shift = along * 0.04 * long
        return _rounded(centre - shift, long * (0.62 - 0.25 * lean), wide * (0.9 - 0.2 * lean), angle, 6)

    def shade(z):
        if z < sill:
            return np.full(3, 0.006)
        if z < skirt:
            return np.full(3, 0.02)
        if z < belt:
            return paint * (0.55 + 0.7 * (z - sill) / (belt - sill)) * sheen[int(z * 30)] + gloss * max(
                0.0, z - belt + 0.12
            )
        return np.full(3, 0.02 + 0.1 * max(0.0, sheen[int(z * 30)] - 0.9))

    parts = []
    for x in (0.31, -0.29):
        for y in (-1, 1):
            hub = centre + along * x * long + across * y * wide * 0.45
            parts.append((_wheel(hub, angle, scale, 0.33), lambda z: np.full(3, 0.012)))
            parts.append((_wheel(hub + across * y * 0.02 * scale, angle, scale, 0.2), _rim(rng)))
    for x, z, colour in _fittings(rng):
        for y in (-1, 1) if x > 0 or rng.random() < 0.8 else (0,):
            parts.append((_slab(centre + along * x * long + across * y * wide * 0.36, angle, scale, z), _flat(colour)))
    for x in (0.5, -0.5):
        colour = np.array([0.03, 0.08, 0.4] if rng.random() < 0.7 else [0.05, 0.3, 0.1])
        parts.append((_slab(centre + along * x * long, angle, scale, 0.5, 0.45), _flat(colour)))
    for _ in range(int(rng.integers(2, 9))):
        # Chrome, gaps, reflections of the sky: thin and of any brightness.
        at = centre + along * rng.uniform(-0.5, 0.5) * long + across * rng.choice([-0.5, -0.2, 0.0, 0.3, 0.5]) * wide
        size = rng.uniform(0.05, 1.2), rng.uniform(0.03, 0.9), rng.uniform(0.02, 0.08)
        trim = _slab(at, angle, scale, rng.uniform(0.25, 1.1), size[1], size[0], size[2])
        parts.append((trim, _flat(np.full(3, rng.choice([0.01, 0.2, 0.6, 0.9])))))
    return Body(_rounded(centre, long, wide, angle, corners), 1.5, outline, shade, tuple(parts), rng.uniform(0.3, 0.9))


def _wheel(hub: np.ndarray, angle: float, scale: float, radius: float) -> Outline:
    def outline(z):
        if abs(z - 0.33) > radius:
            return None
        return _box(hub, 2 * scale * np.sqrt(radius**2 - (z - 0.33) ** 2) + 1, 0.2 * scale, angle)

    return outline


def _rim(rng: np.random.Generator) -> Shade:
    level = rng.uniform(0.05, 0.5)
    return lambda z: np.full(3, level * (0.5 + 0.5 * np.sin(40 * z)))


def _fittings(rng: np.random.Generator):
    return (
        (0.46, rng.uniform(0.6, 0.75), np.full(3, rng.uniform(0.3, 0.9))),
        (-0.47, 0.8, np.array([0.35, 0.01, 0.01])),
    )


def _slab(
    at: np.ndarray,
    angle: float,
    scale: float,
    height: float,
    wide: float = 0.35,
    long: float = 0.14,
    half: float = 0.07,
) -> Outline:
    return lambda z: _box(at, long * scale, wide * scale, angle) if abs(z - height) < half else None


def _flat(colour: np.ndarray) -> Shade:
    return lambda z: colour


def _stray_car(rng, scale, turn):
    return _car(rng, rng.uniform(-0.1, 1.1, 2) * SIDE, turn + rng.choice([0, np.pi / 2]) + rng.normal(0, 0.2), scale)


def _striped(rng: np.random.Generator) -> Shade:
    first, second = [(np.array([0.6, 0.4, 0.03]), np.full(3, 0.015)), (np.full(3, 0.7), np.array([0.5, 0.03, 0.03]))][
        int(rng.integers(2))
    ]
    step, top = rng.uniform(0.08, 0.2), rng.uniform(0.5, 1.2)
    above = np.full(3, rng.uniform(0.3, 0.8))
    return lambda z: above if z > top else (first if int(z / step) % 2 else second)


def _plain(rng: np.random.Generator) -> Shade:
    low, high = np.exp(rng.uniform(np.log(0.04), np.log(0.8), 2))
    tint = 1 + rng.normal(0, 0.06, 3)
    return lambda z: (low + (high - low) * min(z, 1.0)) * tint


def _pillar(rng, at, size, turn, scale, round_):
    shade = _striped(rng) if rng.random() < 0.4 else _plain(rng)
    if round_:
        around = np.linspace(0, 2 * np.pi, 20, endpoint=False)
        foot = at + np.stack([np.cos(around), np.sin(around)], -1) * size / 2 * scale
    else:
        foot = _box(at, size * scale, size * scale * rng.uniform(0.6, 1.0), turn)
    return Body(foot, 3.0, lambda z: foot, shade, dark=rng.uniform(0.1, 0.5))


def _pillar_somewhere(rng, scale, turn):
    return _pillar(rng, rng.uniform(0, SIDE, 2), rng.uniform(0.25, 0.9), turn, scale, rng.random() < 0.5)


def _post(rng, scale, turn):
    return _pillar(rng, rng.uniform(0, SIDE, 2), rng.uniform(0.06, 0.15), turn, scale, True)


def _crate(rng, scale, turn):
    foot = _box(rng.uniform(0, SIDE, 2), *(rng.uniform(0.2, 1.5, 2) * scale), turn + rng.normal(0, 0.3))
    return Body(foot, rng.uniform(0.15, 1.0), lambda z: foot, _plain(rng), dark=rng.uniform(0.1, 0.5))


def _bush(rng, scale, turn):
    centre, size = rng.uniform(0, SIDE, 2), rng.uniform(0.4, 1.5) * scale
    around = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    leaf = np.array([0.05, 0.1, 0.03]) * rng.uniform(0.5, 2.0)

    def outline(z):
        radius = size * (1 - 0.5 * z / 0.8) * (1 + rng.normal(0, 0.12, 40))
        return centre + np.stack([np.cos(around), np.sin(around)], -1) * radius[:, None] if z < 0.8 else None

    return Body(outline(0.0), 0.8, outline, lambda z: leaf * (0.4 + 1.2 * z) * rng.uniform(0.7, 1.3), dark=0.4)


def _stop(rng, at, along, scale):
    foot = _box(at, rng.uniform(0.4, 0.7) * scale, 0.14 * scale, np.arctan2(along[1], along[0]))
    shade = _striped(rng) if rng.random() < 0.3 else _plain(rng)
    return Body(foot, rng.uniform(0.06, 0.14), lambda z: foot, shade, dark=0.3)


def _bump(rng, scale, turn):
    """A rubber bump across the lane, black and yellow in turn."""
    angle = turn + rng.choice([0, np.pi / 2])
    centre, wide, long = rng.uniform(0, SIDE, 2), rng.uniform(0.25, 0.4) * scale, rng.uniform(2, 8) * scale
    whole = _box(centre, long, wide, angle)
    along = np.array([np.cos(angle), np.sin(angle)])
    step = rng.uniform(0.2, 0.5) * scale
    bright = np.array([0.6, 0.4, 0.04]) if rng.random() < 0.8 else np.full(3, 0.7)
    count = int(long / step / 2)
    parts = tuple(
        (lambda z, k=k: _box(centre + along * (2 * k - count + 0.5) * step, step, wide, angle), _flat(bright))
        for k in range(count)
    )
    return Body(whole, 0.05, lambda z: whole, _flat(np.full(3, 0.02)), parts, 0.2)


def _roadside(rng, side, scale, turn):
    """A kerb with what lies behind it, or a wall, along the rows or across them."""
    angle = turn if rng.random() < 0.8 else turn + np.pi / 2
    along = np.array([np.cos(angle), np.sin(angle)])
    normal = np.array([-along[1], along[0]]) * side
    distance = rng.uniform(1.4, 5.5) * scale
    start = np.full(2, SIDE / 2) + normal * distance
    far, deep = SIDE * 2.0, SIDE * 1.5

    def strip(near, wide):
        a, b = start + normal * near, start + normal * (near + wide)
        return np.array([a - along * far, a + along * far, b + along * far, b - along * far])

    if rng.random() < 0.45:
        foot = strip(0, deep)
        return [Body(foot, 3.0, lambda z: foot, _plain(rng), dark=rng.uniform(0, 0.4))]
    width, height = rng.uniform(0.08, 0.3) * scale, rng.uniform(0.08, 0.25)
    kerb = strip(0, width)
    behind = strip(width, deep)
    if rng.random() < 0.7:
        green = np.array([0.05, 0.1, 0.03]) * rng.uniform(0.4, 2.0)
        shade = lambda z: green * rng.uniform(0.5, 1.6)  # noqa: E731
    else:
        shade = _plain(rng)
    tall = height + (rng.uniform(0.0, 0.5) if rng.random() < 0.5 else 0.0)
    bodies = [Body(behind, tall, lambda z: behind, shade, dark=0.0)]
    if rng.random() < 0.8:
        striped = rng.random() < 0.15
        bodies.append(Body(kerb, height, lambda z: kerb, _striped(rng) if striped else _plain(rng), dark=0.3))
    return bodies


def seen(bodies: list[Body], foot: np.ndarray, height: float, scale: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The polygons (N, 2) that a camera sees of bodies, each with its reflectance (3,), in the order of drawing.

    Parameters
    ----------
    bodies : list of Body
    foot : ndarray (2,)
        The ground below the camera, pixels.
    height : float
        Metres of the camera above it.
    scale : float
        Pixels per metre.
    """
    polygons = []
    for body in sorted(bodies, key=lambda body: -np.hypot(*(body.foot.mean(0) - foot))):
        top = min(body.height, _HIGHEST * height)
        # Even steps of what is seen, not of height: the last centimetres below the camera reach farthest.
        farthest = min(height / (height - top), 1 + SIDE / max(float(np.hypot(*(body.foot - foot).T).min()), 1.0))
        steps = 2 + int(np.log(farthest) * float(np.hypot(*(body.foot - foot).T).mean().clip(20, SIDE)) / STEP)
        for z in height * (1 - np.exp(-np.linspace(0, np.log(farthest), max(3, steps)))):
            for outline, shade in ((body.outline, body.shade), *body.parts):
                shape = outline(float(z))
                if shape is not None:
                    polygons.append((foot + (shape - foot) * height / (height - z), shade(float(z))))
    return polygons


def draw(albedo: np.ndarray, free: np.ndarray, polygons: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """Paint polygons over reflectance (SIDE, SIDE, 3), and take them off free ground (SIDE, SIDE) uint8, in place."""
    for shape, colour in polygons:
        low, high = shape.min(0), shape.max(0)
        if (high < 0).any() or (low > SIDE).any():
            continue
        fill(albedo, shape, np.maximum(colour, 0.002))
        fill(free, shape, 0)


def smear(rng: np.random.Generator, polar: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """What upright surfaces show besides their colour, drawn out away from the camera as they are.

    Grilles, joints and leaves darken and lighten it, and smooth paint mirrors the sky and lamps.

    Parameters
    ----------
    rng : Generator
    polar : tuple of ndarray (SIDE, SIDE) float32
        Radians about the camera's foot, and pixels from it.

    Returns
    -------
    tuple of ndarray (SIDE, SIDE) float32
        What its reflectance is multiplied by, and what is added to it.
    """
    angle, distance = polar
    turned = (angle + np.pi) / (2 * np.pi)
    far = np.log(np.maximum(distance, 1.0) / 10) / np.log(SIDE / 10)

    def pattern(around: int, outwards: int) -> np.ndarray:
        grid = rng.standard_normal((outwards + 2, around + 2), np.float32)
        return cv2.remap(
            grid, (turned * around).astype(np.float32), (far * outwards).astype(np.float32), cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REFLECT_101,
        )  # fmt: skip

    coarse = pattern(int(rng.integers(30, 120)), int(rng.integers(4, 14)))
    fine = pattern(int(rng.integers(150, 700)), int(rng.integers(8, 40)))
    factor = np.exp(rng.uniform(0.0, 0.6) * coarse + rng.uniform(0.0, 0.35) * fine)
    mirrored = np.clip(pattern(int(rng.integers(40, 200)), int(rng.integers(5, 20))) - rng.uniform(0.6, 2.2), 0, 1)
    return factor.astype(np.float32), (rng.uniform(0.0, 0.9) * mirrored).astype(np.float32)


def shade_below(bodies: list[Body], sun: np.ndarray | None, scale: float) -> np.ndarray:
    """The light that bodies leave on the ground, (SIDE, SIDE) float32: less beside them, and in their shadows.

    Parameters
    ----------
    bodies : list of Body
    sun : ndarray (2,) or None
        Metres that the shadow of one metre of height reaches; None without sun.
    scale : float
    """
    light = np.ones((SIDE, SIDE), np.float32)
    cast = np.zeros((SIDE, SIDE), np.float32)
    for body in bodies:
        if body.dark > 0:
            near = np.zeros((SIDE, SIDE), np.float32)
            fill(near, body.foot, 1.0)
            near = cv2.GaussianBlur(near, (0, 0), max(1.0, 0.18 * scale * min(body.height, 1.0)))
            light *= 1 - body.dark * np.clip(near * 1.6, 0, 1)
        if sun is not None:
            for z in np.linspace(0, min(body.height, 4.0), 8):
                fill(cast, body.foot + sun * z * scale, 1.0)
    if sun is not None:
        light *= 1 - 0.75 * cv2.GaussianBlur(cast, (0, 0), 1.2)
    return light
