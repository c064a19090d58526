"""From four camera pictures to one view of the ground from above."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import cv2
import numpy as np

from pavemark.cameras.rig import SIDES, Fisheye, Mount
from pavemark.ground import Frame


@attrs.frozen
class Ego:
    """The car that carries the cameras, as the around-view monitor draws it.

    Attributes
    ----------
    length, width : float
        Metres of the blacked-out rectangle.
    front, rear : float
        Radians between the car's axis and the seams that leave its front and its rear corners.
    feather : float
        Metres over which two cameras are mixed at a seam.
    ragged : float
        Metres by which the black outline strays from the rectangle.
    """

    length: float = 4.5
    width: float = 1.9
    front: float = np.radians(24)
    rear: float = np.radians(28)
    feather: float = 0.03
    ragged: float = 0.04


def lookup(frame: Frame, fisheye: Fisheye, mount: Mount) -> np.ndarray:
    """Where a camera sees the centre of each ground pixel.

    Returns
    -------
    ndarray (H, W, 2), float32
        Pixels of the camera picture, the centre of its first pixel at (0.5, 0.5).
    """
    ground = frame.pixel_centres()
    points = np.concatenate([ground, np.zeros_like(ground[..., :1])], -1)
    return fisheye.project(mount.to_camera(points)).astype(np.float32)


def sectors(frame: Frame, ego: Ego) -> dict[str, np.ndarray]:
    """The share of each camera in each pixel, (H, W) float32; the four sum to one.

    Seams are straight lines from the corners of the car outwards.
    """
    x, y = np.moveaxis(frame.pixel_centres(), -1, 0)
    ahead = _beyond(np.abs(x), y, ego, ego.front)
    behind = _beyond(np.abs(x), -y, ego, ego.rear)
    beside = (1 - ahead) * (1 - behind)
    left = (x < 0) * beside
    shares = {"front": ahead, "left": left, "right": beside - left, "rear": behind * (1 - ahead)}
    return {side: share.astype(np.float32) for side, share in shares.items()}


def _beyond(across: np.ndarray, along: np.ndarray, ego: Ego, angle: float) -> np.ndarray:
    """0 beside to 1 beyond the pair of seams that leaves one end of the car."""
    distance = (along - ego.length / 2) * np.sin(angle) - (across - ego.width / 2) * np.cos(angle)
    # Between the corners the seams would cross under the car, where nothing is seen anyway.
    return np.clip(distance / ego.feather + 0.5, 0, 1) * (along > 0)


def silhouette(frame: Frame, ego: Ego, rng: np.random.Generator) -> np.ndarray:
    """The blacked-out car: a rectangle whose outline strays a little, (H, W) bool."""
    x, y = np.moveaxis(frame.pixel_centres(), -1, 0)
    left, right = (ego.width / 2 + _ragged(rng, ego.ragged, y / ego.length) for _ in range(2))
    rear, front = (ego.length / 2 + _ragged(rng, ego.ragged, x / ego.width) for _ in range(2))
    return (x > -left) & (x < right) & (y > -rear) & (y < front)


def _ragged(rng: np.random.Generator, amount: float, along: np.ndarray) -> np.ndarray:
    """A smooth random deviation of about `amount` over one side of the car, whose ends lie at ±1/2."""
    strength, phase = rng.normal(0, amount, 3) / (2, 3, 4), rng.uniform(0, 2 * np.pi, 3)
    return sum(strength[k] * np.cos((k + 1) * 2 * np.pi * along + phase[k]) for k in range(3))


def window(seen_at: np.ndarray, share: np.ndarray, size: int) -> tuple[int, int, int, int]:
    """The part of a camera picture that the view needs: left, top, right, bottom in pixels.

    Sixteen pixels more on each side than are sampled, so that sharpening and 8×8 blocks have their surroundings.
    """
    used = seen_at[share > 0]
    low = np.maximum(np.floor(used.min(0)) - 16, 0).astype(int)
    high = np.minimum(np.ceil(used.max(0)) + 16, size).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def stitch(
    pictures: Mapping[str, np.ndarray], seen_at: Mapping[str, np.ndarray], shares: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Mix the cameras' ground views, sampled bilinearly.

    Parameters
    ----------
    pictures : mapping of side to ndarray (h, w) or (h, w, C)
    seen_at : mapping of side to ndarray (H, W, 2) float32
        From `lookup`.
    shares : mapping of side to ndarray (H, W) float32
        From `sectors`.

    Returns
    -------
    ndarray (H, W) or (H, W, C), float32
        In the space of the pictures.
    """
    total = 0.0
    for side in SIDES:
        view = cv2.remap(
            pictures[side].astype(np.float32), seen_at[side] - np.float32(0.5), None, cv2.INTER_LINEAR, borderValue=0
        )
        total = total + view * shares[side].reshape(shares[side].shape + (1,) * (view.ndim - 2))
    return total
