"""Meshes of what casts shadows into the picture: as plain as a shadow can be told from."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np

from pavemark.light import Caster

Parts = tuple[np.ndarray, list[Sequence[int]]]
"""Vertices (N, 3) in metres about the foot, and faces."""

SIDES = 24
"""Of what is round."""

LEAF = 0.16
"""Metres across of a clump of leaves."""

THICK = 0.25
"""Metres of a roof."""

_PROFILE = (
    (-0.5, 0.22),
    (-0.48, 0.6),
    (-0.28, 0.64),
    (-0.16, 1.0),
    (0.22, 1.0),
    (0.38, 0.62),
    (0.5, 0.56),
    (0.5, 0.22),
)
"""A car from the side: shares of its length from its middle, and of its height."""


def mesh(name: str, caster: Caster) -> bpy.types.Mesh:
    """A caster where it stands."""
    vertices, faces = _SHAPES[caster.kind](caster)
    c, s = np.cos(caster.turn), np.sin(caster.turn)
    turned = vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + (*caster.foot, 0.0)
    made = bpy.data.meshes.new(name)
    made.from_pydata(turned.tolist(), [], faces)
    return made


def _pole(caster: Caster) -> Parts:
    length, width, height = caster.size
    return _drum(length / 2, width / 2, 0.0, height)


def _roof(caster: Caster) -> Parts:
    length, width, height = caster.size
    post = min(0.1, length / 4, width / 4)
    parts = [_box((0, 0, height - min(THICK, height) / 2), (length, width, min(THICK, height)))]
    for x in (-1, 1):
        for y in (-1, 1):
            middle = (x * (length - post) / 2, y * (width - post) / 2, height / 2)
            parts.append(_box(middle, (post, post, height)))
    return _joined(parts)


def _car(caster: Caster) -> Parts:
    length, width, height = caster.size
    side = np.array([(x * length, 0.0, z * height) for x, z in _PROFILE])
    count = len(side)
    vertices = np.concatenate([np.subtract(side, (0, width / 2, 0)), np.add(side, (0, width / 2, 0))])
    faces = [list(range(count))[::-1], list(range(count, 2 * count))]
    faces += [(k, (k + 1) % count, (k + 1) % count + count, k + count) for k in range(count)]
    wheels = [
        _box((x * length, y * (width / 2 - 0.11), 0.16 * height), (0.14 * length, 0.2, 0.32 * height))
        for x in (-0.32, 0.3)
        for y in (-1, 1)
    ]
    return _joined([(vertices, faces), *wheels])


def _tree(caster: Caster) -> Parts:
    """A trunk, and a crown of clumps of leaves: light falls through between them."""
    length, width, height = caster.size
    trunk = _drum(0.03 * height, 0.03 * height, 0.0, 0.6 * height)
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(caster.seed)))
    half = np.array([length / 2, width / 2, 0.35 * height])
    # So many that a ray through the crown meets one of them on the mean.
    count = int(min(6000, 4 * half[0] * half[1] / LEAF**2))
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # Boughs: what is left out of a crown is left out whole.
    boughs = 1 + 0.35 * np.sin(directions @ rng.normal(0, 4, (3, 3)) + rng.uniform(0, 6.3, 3)).prod(1)
    middle = directions * half * (rng.random((count, 1)) ** (1 / 3)) * boughs[:, None] + (0, 0, 0.65 * height)
    one, other = rng.normal(size=(2, count, 3)) * LEAF / 2
    corners = np.stack([middle - one - other, middle + one - other, middle + one + other, middle - one + other], 1)
    return _joined([trunk, (corners.reshape(-1, 3), [tuple(range(4 * k, 4 * k + 4)) for k in range(count)])])


def _drum(across: float, along: float, bottom: float, top: float) -> Parts:
    angle = np.arange(SIDES) * 2 * np.pi / SIDES
    ring = np.stack([across * np.cos(angle), along * np.sin(angle), np.zeros(SIDES)], -1)
    vertices = np.concatenate([np.add(ring, (0, 0, bottom)), np.add(ring, (0, 0, top))])
    faces = [(k, (k + 1) % SIDES, (k + 1) % SIDES + SIDES, k + SIDES) for k in range(SIDES)]
    return vertices, [*faces, list(range(SIDES, 2 * SIDES))]


def _box(middle: Sequence[float], size: Sequence[float]) -> Parts:
    signs = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), *((k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4))]
    return np.asarray(middle) + signs * np.asarray(size) / 2, faces


def _joined(parts: Sequence[Parts]) -> Parts:
    vertices, faces, before = [], [], 0
    for points, polygons in parts:
        vertices.append(points)
        faces += [tuple(before + k for k in polygon) for polygon in polygons]
        before += len(points)
    return np.concatenate(vertices), faces


_SHAPES: dict[str, Callable[[Caster], Parts]] = {"tree": _tree, "pole": _pole, "car": _car, "roof": _roof}
