"""The light on a floor of our own: sun and shade, lamps, and the lamps' streaks on a smooth floor."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from pavemark.training.canvas import SIDE, clouds, fill


@attrs.frozen(eq=False)
class Light:
    """How a view is lit.

    Attributes
    ----------
    level : ndarray (SIDE, SIDE, 3) float32
        Light on flat ground, 1 in the open.
    sun : ndarray (2,) or None
        Metres of shadow for a metre of height, in image axes.
    glare : float
        Light that a mirror of a floor would reflect, in units of what the ground sends back; 0 without lamps.
    exposure : float
        Mean linear light of the pictures.
    noise : float
        Of the sensors, 1 in daylight.
    """

    level: np.ndarray
    sun: np.ndarray | None
    glare: float
    exposure: float
    noise: float


def sample(rng: np.random.Generator, scale: float, garage: bool = False) -> Light:
    """Draw the light of a view at `scale` pixels per metre; in a `garage`, dim and full of lamps."""
    if garage:
        lit = _indoors(rng, scale)
        glare = np.exp(rng.uniform(np.log(0.8), np.log(6.0)))
        return attrs.evolve(lit, glare=float(glare), exposure=float(np.exp(rng.uniform(np.log(0.03), np.log(0.15)))))
    if rng.random() < 0.5:
        return _indoors(rng, scale)
    sun = None
    level = np.ones((SIDE, SIDE), np.float32) * (1 + 0.05 * clouds(rng, 4 * scale, 2))
    shade = np.ones(3)
    if rng.random() < 0.6:
        angle = rng.uniform(0, 2 * np.pi)
        sun = np.array([np.cos(angle), np.sin(angle)]) * rng.uniform(0.2, 1.5)
        if rng.random() < 0.5:
            level *= 1 - rng.uniform(0.4, 0.8) * _shadow(rng)
        if rng.random() < 0.3:
            leaves = np.clip(0.5 + rng.uniform(1, 4) * clouds(rng, rng.uniform(0.3, 1.2) * scale, 3), 0, 1)
            level *= 1 - rng.uniform(0.3, 0.75) * leaves
        # Shade is lit by the sky alone, and blue.
        shade = np.array([0.85, 1.0, 1.2])
    tinted = level[..., None] * (shade + (1 - shade) * np.clip(level, 0, 1)[..., None])
    return Light(tinted.astype(np.float32), sun, 0.5 * (rng.random() < 0.2), float(rng.uniform(0.1, 0.3)), 1.0)


def _indoors(rng: np.random.Generator, scale: float) -> Light:
    level = np.full((SIDE, SIDE), rng.uniform(0.15, 1.0), np.float32)
    v, u = np.mgrid[0:SIDE, 0:SIDE].astype(np.float32)
    for _ in range(int(rng.integers(0, 5))):
        x, y = rng.uniform(-0.2, 1.2, 2) * SIDE
        reach = rng.uniform(1.0, 3.5) * scale
        level += rng.uniform(0.1, 1.0) * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * reach**2))
    tint = 1 + rng.normal(0, 0.08, 3)
    glare = np.exp(rng.uniform(np.log(0.3), np.log(5.0))) if rng.random() < 0.75 else 0.0
    exposure = float(np.exp(rng.uniform(np.log(0.03), np.log(0.3))))
    return Light(
        (level[..., None] * tint).astype(np.float32), None, float(glare), exposure, float(rng.uniform(0.8, 1.8))
    )


def _shadow(rng: np.random.Generator) -> np.ndarray:
    """The shadow of something outside the view, straight-edged or ragged, (SIDE, SIDE) float32."""
    sheet = np.zeros((SIDE, SIDE), np.float32)
    angle, reach = rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5) * SIDE
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    steps = np.linspace(-1, 1, int(rng.choice([2, 6, 40])))
    ragged = rng.normal(0, rng.uniform(0, 30), len(steps))
    edge = [SIDE / 2 + across * (reach + r) + along * s * SIDE for s, r in zip(steps, ragged, strict=True)]
    far = [edge[-1] + across * 2 * SIDE, edge[0] + across * 2 * SIDE]
    if rng.random() < 0.3:
        wide = rng.uniform(0.05, 0.3) * SIDE
        far = [edge[-1] + across * wide, edge[0] + across * wide]
    fill(sheet, np.array(edge + far), 1.0)
    return cv2.GaussianBlur(sheet, (0, 0), float(rng.uniform(0.5, 6)))


def streaks(
    rng: np.random.Generator, polar: tuple[np.ndarray, np.ndarray], scale: float, lamps: tuple[int, int] = (0, 9)
) -> np.ndarray:
    """What a smooth floor mirrors of lamps, windows and bodies: streaks that run away from the camera.

    Parameters
    ----------
    rng : Generator
    polar : tuple of ndarray (SIDE, SIDE) float32
        Radians about the camera's foot, and pixels from it.
    scale : float
    lamps : tuple of int
        Between how many streaks there are; the second is not reached.

    Returns
    -------
    ndarray (SIDE, SIDE) float32
        0 and more.
    """
    angle, distance = polar
    metres = distance / np.float32(scale)
    total = np.zeros((SIDE, SIDE), np.float32)
    # Rough floors draw lamps out far and wide, smooth ones into lines as thin as markings.
    widest = np.exp(rng.uniform(np.log(0.05), np.log(0.5)))
    longest = rng.uniform(2.0, 7.0)
    for _ in range(int(rng.integers(*lamps))):
        off = np.abs((angle - rng.uniform(-np.pi, np.pi) + np.pi) % (2 * np.pi) - np.pi)
        near, long = rng.uniform(0.3, 4), rng.uniform(0.2, longest)
        # A lamp's image is as wide in metres as the lamp, or as its floor is rough.
        width = np.exp(rng.uniform(np.log(0.015), np.log(widest))) / np.maximum(near, 0.5)
        profile = np.exp(-(np.clip((metres - near) / long, -4, 4) ** 2)) * (metres > 0.2)
        total += rng.uniform(0.1, 1.5) * np.exp(-((off / width) ** 2)) * profile
    if rng.random() < 0.6:
        knots = np.cumsum(rng.normal(size=181)) * 0.2 + rng.normal(size=181) * rng.uniform(0.1, 0.8)
        knots -= np.linspace(knots[0], knots[-1], 181)
        comb = np.interp(angle, np.linspace(-np.pi, np.pi, 181), knots).astype(np.float32)
        rough = 0.6 + 0.4 * clouds(rng, scale, 3)
        total += rng.uniform(0.05, 0.35) * np.clip(comb, 0, None) * rough * np.clip(metres / 1.5, 0, 1)
    return np.clip(total, 0, None)
