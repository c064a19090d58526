"""Lamps mirrored in a smooth floor, in closed form.

Under GGX (Walter et al., 2007) the slopes of a floor's facets have the density α² / π(α² + s²)². Each point of a lamp
asks for one slope, which turns it into an eye: a lamp is a strip in the plane of slopes, and what the floor mirrors of
it is the density over that strip. Its integrals across the strip, and along it at the strip's middle, are elementary
functions, so no ray is cast. Facets that hide each other are left out; that is of the second order in the roughness.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pavemark.geometry.mirror import schlick, seen_by
from pavemark.ground import Frame
from pavemark.light import Glare, Tube

STRIP = 0.25
"""Metres up to which a lamp is taken as one strip; wider ones are cut up."""


def gleam(frame: Frame, effect: Glare, ground: np.ndarray) -> np.ndarray:
    """What a floor mirrors.

    Parameters
    ----------
    frame : Frame
    effect : Glare
    ground : ndarray (H, W) bool
        Where there is floor.

    Returns
    -------
    ndarray (H, W, 3) float32
        R, G and B, linear light; 0 where there is no floor.
    """
    here = frame.pixel_centres()[ground]
    gleams = np.zeros((len(here), 3))
    for eye, share in zip(effect.eyes, seen_by(here, effect.eyes).T, strict=True):
        seen = np.flatnonzero(share)
        # float32 is exact to 10⁻⁶ of the light here, and half the time.
        point = (here[seen, 0].astype(np.float32), here[seen, 1].astype(np.float32))
        towards = _towards(point, eye)
        for tube in effect.tubes:
            shown = _shown(point, towards, tube, effect)
            gleams[seen] += (share[seen] * shown)[:, None] * tube.radiance
    made = np.zeros((*ground.shape, 3), np.float32)
    made[ground] = gleams
    return made


Vector = tuple[np.ndarray, ...]
"""Coordinates, each (P,), of a vector at every point."""


def _shown(point: Vector, towards: Vector, tube: Tube, effect: Glare) -> np.ndarray:
    """How much (P,) of a tube's radiance the floor sends from points on to an eye that lies `towards` there."""
    alpha = np.float32(effect.roughness**2)
    along, beside = np.array(
        [(np.cos(tube.turn), np.sin(tube.turn), 0.0), (-np.sin(tube.turn), np.cos(tube.turn), 0.0)]
    )
    strips = int(np.ceil(tube.width / STRIP))
    width = tube.width / strips
    total = np.zeros_like(point[0])
    for strip in range(strips):
        middle = tube.place + (strip - (strips - 1) / 2) * width * beside
        half = _half(point, towards, middle)
        ends = [_slope(_half(point, towards, middle + side * tube.length / 2 * along)) for side in (-1, 1)]
        rims = [_slope(_half(point, towards, middle + side * width / 2 * beside)) for side in (-1, 1)]
        x, y = _unit(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])
        u, w = _slope(half)
        off = x * w - y * u
        thin = np.abs(x * (rims[1][1] - rims[0][1]) - y * (rims[1][0] - rims[0][0])) / 2
        start, end = (u * x + w * y for u, w in ends)
        facets = (_across(off + thin, alpha) - _across(off - thin, alpha)) * (
            _along(end, off, alpha) - _along(start, off, alpha)
        )
        # From the density of slopes to radiance: f cos(l) dω = F D dω_h (v·h) / (v·n).
        incidence = sum(a * b for a, b in zip(towards, half, strict=True))
        total += facets * schlick(incidence, effect.reflectance) * incidence / (towards[2] * half[2])
    return total


def _half(point: Vector, towards: Vector, place: np.ndarray) -> Vector:
    """The unit vector halfway between the directions from points on the ground to an eye and to a place."""
    return _unit(*(a + b for a, b in zip(towards, _towards(point, place), strict=True)))


def _towards(point: Vector, place: Sequence[float]) -> Vector:
    """The unit vector from points on the ground to a place."""
    x, y, height = (np.float32(part) for part in place)
    return _unit(x - point[0], y - point[1], np.full_like(point[0], height))


def _unit(*vector: np.ndarray) -> Vector:
    length = np.maximum(np.sqrt(sum(part * part for part in vector)), np.float32(1e-12))
    return tuple(part / length for part in vector)


def _slope(normal: Vector) -> Vector:
    return normal[0] / normal[2], normal[1] / normal[2]


def _across(slope: np.ndarray, alpha: float) -> np.ndarray:
    """The share of facets whose slope in one direction is less, but for a half."""
    return slope / (2 * np.sqrt(alpha**2 + slope**2))


def _along(slope: np.ndarray, other: np.ndarray, alpha: float) -> np.ndarray:
    """The share, among those of one slope in the other direction, whose slope is less, but for a half."""
    turn = slope / np.sqrt(alpha**2 + other**2)
    return (turn / (1 + turn**2) + np.arctan(turn)) / np.float32(np.pi)
