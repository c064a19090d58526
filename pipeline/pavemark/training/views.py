"""Views of our own: what an around-view monitor shows of a car park that we draw, with the truth about every pixel."""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import attrs
import cv2
import numpy as np

from pavemark.cameras import sensor, stitch
from pavemark.cameras.rig import Fisheye, mounts
from pavemark.colour import quantise
from pavemark.ground import Frame
from pavemark.training import bodies, floors, light, paint
from pavemark.training.canvas import SIDE

SCALE = 48.0
"""Pixels per metre at which the networks work."""

Kind = Literal["any", "garage", "pavers", "full", "crossing"]

KINDS: tuple[Kind, ...] = ("any", "garage", "any", "full", "any", "garage", "pavers", "any", "crossing", "any")
"""Kinds of view, in turn. Half are of any kind; the others are what a network that has seen those alone gets wrong:
streaks of lamps on a smooth floor that look like lines, cars on either side, lines of stones in a floor of stones, the
wide bars of crossings."""

RIGS = 12
"""Sets of cameras that views are seen with. Their maps are worked out once."""


@attrs.frozen(eq=False)
class View:
    """A picture and its truth.

    Attributes
    ----------
    image : ndarray (SIDE, SIDE, 3) uint8
        Display sRGB.
    marking, ground : ndarray (SIDE, SIDE) bool
        Where there is a marking to be seen; where there is bare ground or marking.
    """

    image: np.ndarray
    marking: np.ndarray
    ground: np.ndarray


@attrs.frozen(eq=False)
class Camera:
    """One camera of a rig, with its maps.

    Attributes
    ----------
    foot : ndarray (2,)
        The ground below it, pixels of the view.
    height : float
        Metres.
    polar : tuple of ndarray (SIDE, SIDE) float32
        Radians about the foot, pixels from it.
    seen_at : ndarray (SIDE, SIDE, 2) float32
        Where its picture shows each pixel of the view.
    lies_at : ndarray (h, w, 2) float32
        Where each pixel of its picture lies in the view; far outside where it sees no ground.
    share : ndarray (SIDE, SIDE) float32
        How much of each pixel of the view comes from it.
    """

    foot: np.ndarray
    height: float
    polar: tuple[np.ndarray, np.ndarray]
    seen_at: np.ndarray
    lies_at: np.ndarray
    share: np.ndarray


@attrs.frozen(eq=False)
class Rig:
    """A car with its cameras.

    Attributes
    ----------
    scale : float
        Pixels per metre of what they are stitched to: about SCALE, since no user's is quite known.
    cameras : tuple of Camera
    car : ndarray (SIDE, SIDE) bool
        Where the car is.
    """

    scale: float
    cameras: tuple[Camera, ...]
    car: np.ndarray


@lru_cache(maxsize=RIGS)
def rig(number: int) -> Rig:
    """Rig `number` of RIGS."""
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(number, spawn_key=(1,))))
    scale = SCALE * float(np.exp(rng.uniform(np.log(0.72), np.log(1.5))))
    frame = Frame(SIDE, SIDE, scale)
    ego = stitch.Ego(
        length=float(rng.uniform(3.6, 4.9)),
        width=float(rng.uniform(1.7, 2.1)),
        front=float(np.radians(rng.uniform(12, 35))),
        rear=float(np.radians(rng.uniform(12, 38))),
        feather=float(rng.choice([0.005, 0.03, 0.1, 0.4])),
        ragged=float(rng.choice([0.0, 0.03])),
    )
    fisheye = Fisheye(int(np.exp(rng.uniform(np.log(330), np.log(900)))))
    shares = stitch.sectors(frame, ego)
    cameras = []
    for side, mount in mounts(ego.length - 0.1, ego.width - 0.1).items():
        seen_at = stitch.lookup(frame, fisheye, mount)
        left, top, right, bottom = stitch.window(seen_at, shares[side], fisheye.size)
        v, u = np.mgrid[top:bottom, left:right]
        lies_at = mount.to_ground(fisheye.unproject(np.stack([u + 0.5, v + 0.5], -1)))
        lies_at = np.nan_to_num(frame.to_image(lies_at), nan=-1e4).clip(-1e4, 1e4)
        foot = frame.to_image(np.array(mount.position[:2]))
        v, u = np.mgrid[0:SIDE, 0:SIDE].astype(np.float32) + 0.5
        polar = np.arctan2(v - foot[1], u - foot[0]), np.hypot(u - foot[0], v - foot[1])
        cameras.append(
            Camera(
                foot,
                mount.position[2],
                polar,
                seen_at - np.float32([left, top]),
                lies_at.astype(np.float32),
                shares[side],
            )
        )
    return Rig(scale, tuple(cameras), stitch.silhouette(frame, ego, rng))


def sample(rng: np.random.Generator, painted: bool = True, kind: Kind = "any") -> View:
    """Draw a view.

    Parameters
    ----------
    rng : Generator
    painted : bool
        Whether there may be markings. The same stream gives the same ground without them.
    kind : str
        One of KINDS.
    """
    cast = rng.spawn(6)
    seen_by = rig(int(cast[0].integers(RIGS)))
    scale = seen_by.scale
    turn = _turn(cast[0])
    slots = paint.rows(cast[0], scale, turn)
    floor = floors.sample(cast[1], scale, turn, {"garage": "epoxy", "pavers": "pavers"}.get(kind))
    albedo, marked = floor.albedo, np.zeros((SIDE, SIDE), np.float32)
    if painted:
        main = paint.colour(cast[2])
        for coat in paint.sample(cast[2], scale, turn, slots, kind == "crossing"):
            colour = main if cast[2].random() < 0.6 else paint.colour(cast[2])
            albedo = paint.laid_on(cast[2], albedo, coat, colour, 0.6 if kind == "pavers" else paint.INLAID)
            marked = np.maximum(marked, coat)
    standing = []
    if cast[3].random() < 0.8 or kind == "full":
        standing = bodies.sample(cast[3], scale, turn, slots, kind == "full")
    lit = light.sample(cast[4], scale, kind == "garage")
    below = lit.level * bodies.shade_below(standing, lit.sun, scale)[..., None]
    lamps, gloss = (0, 9), floor.gloss
    if kind == "garage":
        # Of the streaks about a camera its sector shows a quarter.
        lamps, gloss = (8, 40), np.maximum(gloss, 0.5)
    image, free = _seen(cast[5], seen_by, albedo * below, gloss, standing, lit, lamps)
    ground = free & ~seen_by.car
    if cast[5].random() < 0.85:
        image[seen_by.car] = 0
    else:
        image[seen_by.car] = cast[5].integers(0, 256, 3)
    return View(image, (marked > 0.5) & ground, ground)


def _turn(rng: np.random.Generator) -> float:
    """Direction of the entrance lines: along the car or across it, or, now and then, anyhow."""
    if rng.random() < 0.85:
        return float(rng.choice([np.pi / 2, np.pi / 2, np.pi / 2, 0.0]) + rng.normal(0, 0.1))
    return float(rng.uniform(0, np.pi))


def _seen(
    rng: np.random.Generator,
    seen_by: Rig,
    ground: np.ndarray,
    gloss: np.ndarray,
    standing: list[bodies.Body],
    lit: light.Light,
    lamps: tuple[int, int],
) -> tuple[np.ndarray, np.ndarray]:
    """The stitched picture (SIDE, SIDE, 3) uint8, and where it shows ground (SIDE, SIDE) bool."""
    image = np.zeros((SIDE, SIDE, 3), np.float32)
    free = np.zeros((SIDE, SIDE), np.float32)
    ambient = lit.level.mean((0, 1))
    balance = rng.normal(0, 0.04, 2)
    for camera in seen_by.cameras:
        picture = ground.copy()
        if lit.glare:
            mirrored = lit.glare * gloss * light.streaks(rng, camera.polar, seen_by.scale, lamps)
            picture += mirrored[..., None] * float(ground.mean())
        seen_ground = np.ones((SIDE, SIDE), np.uint8)
        shapes = bodies.seen(standing, camera.foot, camera.height, seen_by.scale)
        bodies.draw(picture, seen_ground, [(shape, colour * ambient) for shape, colour in shapes])
        upright = seen_ground == 0
        if upright.any():
            factor, mirrored = bodies.smear(rng, camera.polar)
            surface = picture * factor[..., None] + (mirrored[..., None] * ambient).astype(np.float32)
            picture[upright] = surface[upright]
        lens = cv2.remap(picture, camera.lies_at - 0.5, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
        electronics = sensor.sample(rng, lit.noise, lit.exposure)
        electronics = attrs.evolve(
            electronics,
            balance=tuple(part + shift for part, shift in zip(electronics.balance, (*balance, 0.0), strict=True)),
            quality=int(rng.integers(55, 95)),
            sharpen=float(rng.uniform(0.0, 1.8)),
        )
        taken = sensor.develop(lens, np.ones(lens.shape[:2], bool), electronics).astype(np.float32)
        view = cv2.remap(taken, camera.seen_at - 0.5, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        image += view * camera.share[..., None]
        free += seen_ground * camera.share
    return quantise(image), free > 0.5
