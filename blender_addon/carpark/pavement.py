"""The ground as maps of reflectance and roughness: asphalt, concrete, paving, epoxy, and the paint on it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import attrs
import cv2
import numpy as np

from blender_addon.carpark.layout import Coat
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.scene import Marking, Paint

FRAME = Frame(2560, 2560, 128.0)
"""The maps span 20 m in steps of 8 mm, half a pixel of the view at 60 px/m."""


@attrs.frozen(eq=False)
class Surface:
    """What the light meets.

    Attributes
    ----------
    albedo : ndarray (N, N, 3), float32
        Reflectance, linear light.
    roughness : ndarray (N, N), float32
        0 mirror to 1 matt, as Blender's Principled shader takes it.
    marked : ndarray (N, N), float32
        Share of each cell inside the outline of a marking, worn or not.
    """

    albedo: np.ndarray
    roughness: np.ndarray
    marked: np.ndarray


def surface(kind: str, coats: Iterable[Coat], rng: np.random.Generator) -> Surface:
    """A kind of ground with its markings.

    Parameters
    ----------
    kind : str
        One of KINDS.
    coats : iterable of Coat
        Bottom first.
    rng : Generator
    """
    albedo, roughness = KINDS[kind](rng)
    marked = np.zeros_like(roughness)
    relief = 0.5 + 0.5 * _clouds(rng, 0.03, 3)
    for coat in coats:
        marking = Marking("slot", Paint((255.0,) * 3, (1.0,) * 3), coat.strokes, coat.areas)
        inside = coverage(outline(marking, None), FRAME).astype(np.float32)
        kept = inside * _worn(rng, inside, coat.wear, relief)
        dirt = 1 - 0.25 * np.clip(_clouds(rng, 0.6, 4), 0, 1)
        paint = np.array(coat.colour, np.float32) * (dirt * (1 + 0.05 * relief))[..., None]
        albedo = albedo * (1 - kept[..., None]) + paint * kept[..., None]
        roughness = roughness + 0.1 * kept
        marked = np.maximum(marked, inside)
    return Surface(np.clip(albedo, 0.01, 0.9), np.clip(roughness, 0.05, 1), marked)


def _worn(rng: np.random.Generator, inside: np.ndarray, wear: float, relief: np.ndarray) -> np.ndarray:
    """Paint left, 0 to 1: thin where the grain stands out, along the edges and in patches."""
    patches = _clouds(rng, 0.5, 4)
    edge = 1 - np.clip(cv2.blur(inside, (9, 9)) * 1.6 - 0.6, 0, 1)
    loss = wear * 2.2 - 1.15 + 0.45 * patches + 0.45 * relief + 0.25 * edge
    return np.clip(1 - loss * 2.5, 0, 1) * (1 - 0.35 * wear)


def _clouds(rng: np.random.Generator, size: float, octaves: int) -> np.ndarray:
    """Smooth fractal noise of unit standard deviation whose largest features measure `size` metres."""
    total = np.zeros((FRAME.height, FRAME.width), np.float32)
    for octave in range(octaves):
        cells = max(int(FRAME.size[0] / size * 2**octave), 2)
        if cells >= FRAME.width:
            break
        grid = rng.normal(size=(cells, cells)).astype(np.float32)
        total += 0.6**octave * cv2.resize(grid, total.shape[::-1], interpolation=cv2.INTER_CUBIC)
    return total / total.std()


def _speckle(rng: np.random.Generator) -> np.ndarray:
    """White noise, one value a cell, unit standard deviation."""
    return rng.normal(size=(FRAME.height, FRAME.width)).astype(np.float32)


def _cracks(rng: np.random.Generator, count: int, width: int) -> np.ndarray:
    """Wandering cracks, 0 to 1."""
    canvas = np.zeros((FRAME.height, FRAME.width), np.uint8)
    for _ in range(count):
        steps = int(rng.integers(40, 260))
        heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.22, steps))
        path = rng.uniform(0, FRAME.width, 2) + np.cumsum(np.stack([np.cos(heading), np.sin(heading)], -1) * 9, 0)
        path += rng.normal(0, 1.5, path.shape)
        cv2.polylines(canvas, [np.rint(path * 8).astype(np.int32)], False, 255, width, cv2.LINE_AA, 3)
    return canvas.astype(np.float32) / 255


def _stains(rng: np.random.Generator, count: int) -> np.ndarray:
    """Oil that dripped from engines: soft round spots, 0 to 1."""
    canvas = np.zeros((FRAME.height, FRAME.width), np.float32)
    for _ in range(count):
        centre = rng.uniform(0.2, 0.8, 2) * FRAME.width
        for _ in range(int(rng.integers(3, 14))):
            spot = np.rint(centre + rng.normal(0, 22, 2)).astype(int)
            cv2.circle(canvas, tuple(spot.tolist()), int(rng.integers(3, 24)), float(rng.uniform(0.3, 0.9)), -1)
    return cv2.GaussianBlur(canvas, (0, 0), 5)


def _tracks(rng: np.random.Generator, count: int) -> np.ndarray:
    """Curved tyre marks in pairs, 0 to 1."""
    canvas = np.zeros((FRAME.height, FRAME.width), np.float32)
    for _ in range(count):
        t = np.linspace(-1, 1, 60)
        bend, shift, slope = rng.normal(0, 1.6), rng.normal(0, 2.5), rng.normal(0, 0.15)
        layer = np.zeros_like(canvas)
        for wheel in (-0.75, 0.75):
            x = shift + wheel + slope * t * 8 + bend * t**2
            path = FRAME.to_image(np.stack([x, t * 10], -1))
            cv2.polylines(layer, [np.rint(path * 8).astype(np.int32)], False, 1.0, 24, cv2.LINE_8, 3)
        canvas += rng.uniform(0.15, 0.6) * layer
    worn = np.clip(0.6 + 0.5 * _clouds(rng, 1.5, 5), 0, 1)
    return np.clip(cv2.GaussianBlur(canvas, (0, 0), 4) * worn, 0, 1)


def _metres(turn: float) -> tuple[np.ndarray, np.ndarray]:
    """World X, Y of the cells, the axes turned by `turn` radians, float32."""
    x, y = np.moveaxis(FRAME.pixel_centres().astype(np.float32), -1, 0)
    c, s = np.float32(np.cos(turn)), np.float32(np.sin(turn))
    return c * x + s * y, c * y - s * x


def _grey(level: np.ndarray, tint: tuple[float, float, float]) -> np.ndarray:
    return (level[..., None] * np.array(tint, np.float32)).astype(np.float32)


def asphalt(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Fairly new asphalt: dark, speckled with stone."""
    level = 0.13 * (1 + 0.12 * _clouds(rng, 3, 4) + 0.13 * _clouds(rng, 0.04, 2) + 0.16 * _speckle(rng))
    level *= (1 - 0.6 * _stains(rng, 14)) * (1 - 0.45 * _cracks(rng, 5, 1)) * (1 - 0.25 * _tracks(rng, 3))
    return _grey(level, (1.0, 0.98, 0.95)), np.full(level.shape, 0.85, np.float32)


def patched(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Old asphalt, greyed, cracked, sealed with bitumen and mended in rectangles."""
    level = 0.2 * (1 + 0.14 * _clouds(rng, 2, 5) + 0.12 * _clouds(rng, 0.05, 2) + 0.16 * _speckle(rng))
    for _ in range(9):
        box = (rng.uniform(0.15, 0.85, 2) * FRAME.width, rng.uniform(80, 520, 2), float(rng.normal(0, 12)))
        corners = np.rint(cv2.boxPoints((box[0].tolist(), box[1].tolist(), box[2]))).astype(np.int32)
        patch = np.zeros_like(level)
        cv2.fillPoly(patch, [corners], 1.0)
        seam = np.zeros_like(level)
        cv2.polylines(seam, [corners], True, 1.0, 6, cv2.LINE_AA)
        level = level * (1 - patch) + patch * (0.35 * level + rng.uniform(0.05, 0.13))
        level *= 1 - 0.55 * seam * np.clip(0.7 + 0.4 * _clouds(rng, 0.5, 3), 0, 1)
    level *= (1 - 0.75 * _cracks(rng, 26, 1)) * (1 - 0.7 * _cracks(rng, 6, 7)) * (1 - 0.6 * _stains(rng, 22))
    return _grey(level, (1.0, 0.97, 0.93)), np.full(level.shape, 0.9, np.float32)


def concrete(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Slabs of broomed concrete with joints every four metres."""
    x, y = _metres(rng.normal(0, 0.1))
    joint = np.minimum(np.abs((x + 1.3) % 4 - 2), np.abs((y + 0.4) % 4 - 2)) < 0.009
    tone = rng.normal(0, 0.05, (32, 32)).astype(np.float32)
    slab = tone[np.floor((y + 2.4) / 4).astype(int) % 32, np.floor((x + 3.3) / 4).astype(int) % 32]
    broom = cv2.blur(_speckle(rng), (61, 1)) * 4
    level = 0.36 * (1 + slab + 0.09 * _clouds(rng, 2.5, 6) + 0.03 * broom + 0.06 * _speckle(rng))
    level *= (
        (1 - 0.6 * joint) * (1 - 0.5 * _stains(rng, 16)) * (1 - 0.5 * _tracks(rng, 5)) * (1 - 0.4 * _cracks(rng, 4, 1))
    )
    return _grey(level, (1.0, 0.97, 0.91)), np.full(level.shape, 0.75, np.float32)


def _setts(rng: np.random.Generator, turn: float, long: float, wide: float, joint: float) -> tuple[np.ndarray, ...]:
    """Bricks in running bond: a random tone for each (unit deviation), and the joints, 0 to 1."""
    x, y = _metres(turn)
    row = np.floor(y / wide).astype(int)
    shifted = x + (row % 2) * long / 2
    tones = rng.normal(size=(256, 256)).astype(np.float32)
    brick = tones[row % 256, np.floor(shifted / long).astype(int) % 256]
    edge = np.minimum(long / 2 - np.abs(shifted % long - long / 2), wide / 2 - np.abs(y % wide - wide / 2))
    return brick, np.clip((joint - edge) / 0.008 + 0.5, 0, 1).astype(np.float32)


def brick(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Red and brown paving bricks with dark joints."""
    tone, joint = _setts(rng, np.radians(45), 0.2, 0.1, 0.005)
    hue = np.clip(0.5 + 0.35 * tone, 0, 1)[..., None]
    colour = hue * np.array([0.30, 0.17, 0.12], np.float32) + (1 - hue) * np.array([0.20, 0.145, 0.115], np.float32)
    level = 1 + 0.12 * _clouds(rng, 2, 5) + 0.10 * _speckle(rng)
    level *= (1 - 0.72 * joint) * (1 - 0.4 * _stains(rng, 12))
    return colour * level[..., None].astype(np.float32), np.full(level.shape, 0.85, np.float32)


def grid(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Light grass pavers: holes of earth and grass in a grid."""
    x, y = _metres(rng.normal(0, 0.03))
    hole = np.hypot(x % 0.125 - 0.0625, y % 0.125 - 0.0625) < 0.036
    tones = rng.normal(size=(128, 128)).astype(np.float32)
    tile = tones[np.floor(y / 0.25).astype(int) % 128, np.floor(x / 0.25).astype(int) % 128]
    joint = np.minimum(np.abs(x % 0.25 - 0.125), np.abs(y % 0.25 - 0.125)) > 0.1215
    level = 0.34 * (1 + 0.07 * tile + 0.1 * _clouds(rng, 2, 5) + 0.08 * _speckle(rng)) * (1 - 0.5 * joint)
    green = np.clip(0.5 + 0.4 * _clouds(rng, 1.2, 4), 0, 1)[..., None]
    earth = green * np.array([0.05, 0.09, 0.03], np.float32) + (1 - green) * np.array([0.09, 0.07, 0.05], np.float32)
    colour = np.where(hole[..., None], earth, _grey(level, (1.0, 0.95, 0.84)))
    return colour.astype(np.float32), np.full(level.shape, 0.9, np.float32)


def tiles(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Granite slabs of 60 cm with fine dark joints."""
    tone, joint = _setts(rng, np.radians(28), 0.6, 0.6, 0.004)
    level = 0.25 * (1 + 0.09 * tone + 0.09 * _clouds(rng, 2.5, 5) + 0.1 * _speckle(rng))
    level *= (1 - 0.6 * joint) * (1 - 0.5 * _stains(rng, 18)) * (1 - 0.3 * _tracks(rng, 3))
    return _grey(level, (1.0, 0.94, 0.86)), np.full(level.shape, 0.7, np.float32)


def epoxy(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A garage floor's glossy grey-green coat, scuffed by tyres."""
    scuff = _tracks(rng, 5)
    level = 0.24 * (1 + 0.05 * _clouds(rng, 3, 5) + 0.03 * _speckle(rng)) * (1 - 0.45 * scuff)
    level *= 1 - 0.4 * _stains(rng, 8)
    roughness = 0.3 + 0.03 * _clouds(rng, 1.0, 4) + 0.2 * scuff
    return _grey(level, (0.90, 1.0, 0.95)), roughness.astype(np.float32)


KINDS: dict[str, Callable[[np.random.Generator], tuple[np.ndarray, np.ndarray]]] = {
    "asphalt": asphalt,
    "patched": patched,
    "concrete": concrete,
    "brick": brick,
    "grid": grid,
    "tiles": tiles,
    "epoxy": epoxy,
}
