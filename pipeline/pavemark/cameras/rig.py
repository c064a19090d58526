"""The four fisheye cameras of a car and where they sit."""

from __future__ import annotations

import attrs
import numpy as np

SIDES = ("front", "left", "right", "rear")


@attrs.frozen
class Fisheye:
    """An equidistant fisheye: the angle from the optical axis is proportional to the distance from the centre.

    Attributes
    ----------
    size : int
        Pixels of the square picture; the image circle touches its four sides.
    fov : float
        Radians across the image circle.
    """

    size: int
    fov: float = np.radians(190.0)

    def project(self, rays: np.ndarray) -> np.ndarray:
        """Rays (..., 3) in camera axes (x right, y up, z back), any length → image coordinates (..., 2) in pixels."""
        rays = np.asarray(rays, np.float64)
        across = np.hypot(rays[..., 0], rays[..., 1])
        theta = np.arctan2(across, -rays[..., 2])
        radius = theta * self.size / self.fov
        # On the axis itself the direction in the picture is undefined and the radius is zero.
        direction = rays[..., :2] / np.where(across > 0, across, 1.0)[..., None]
        return self.size / 2 + radius[..., None] * direction * (1, -1)

    def unproject(self, uv: np.ndarray) -> np.ndarray:
        """Image coordinates (..., 2) in pixels → unit rays (..., 3) in camera axes."""
        offset = (np.asarray(uv, np.float64) - self.size / 2) * (1, -1)
        radius = np.hypot(offset[..., 0], offset[..., 1])
        theta = radius * self.fov / self.size
        direction = offset / np.where(radius > 0, radius, 1.0)[..., None]
        return np.concatenate([direction * np.sin(theta)[..., None], -np.cos(theta)[..., None]], -1)


@attrs.frozen
class Mount:
    """Where a camera sits and how it looks.

    Attributes
    ----------
    position : tuple of float
        World X, Y, Z in metres; the ground is Z = 0, the car stands at the origin and faces +Y.
    yaw, pitch, roll : float
        Radians: anticlockwise from +Y seen from above, downwards from the horizon, about the optical axis.
    """

    position: tuple[float, float, float]
    yaw: float
    pitch: float
    roll: float = 0.0

    @property
    def rotation(self) -> np.ndarray:
        """The camera's right, up and back axes as the columns of a (3, 3) matrix, float64."""
        heading = np.array([-np.sin(self.yaw), np.cos(self.yaw), 0.0])
        forward = np.cos(self.pitch) * heading - np.array([0.0, 0.0, np.sin(self.pitch)])
        level = np.array([heading[1], -heading[0], 0.0])
        upright = np.cross(level, forward)
        right = np.cos(self.roll) * level + np.sin(self.roll) * upright
        return np.stack([right, np.cross(right, forward), -forward], -1)

    def to_camera(self, points: np.ndarray) -> np.ndarray:
        """World points (..., 3) → camera axes (..., 3), metres."""
        return (np.asarray(points, np.float64) - self.position) @ self.rotation

    def to_ground(self, rays: np.ndarray) -> np.ndarray:
        """Where rays (..., 3) in camera axes meet the ground, world X, Y (..., 2); nan where they rise."""
        rays = np.asarray(rays, np.float64) @ self.rotation.T
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(rays[..., 2] < 0, -self.position[2] / rays[..., 2], np.nan)
        return np.asarray(self.position[:2]) + rays[..., :2] * reach[..., None]


def mounts(length: float, width: float) -> dict[str, Mount]:
    """The cameras in the grille, under the mirrors and over the rear plate of a car of that size in metres."""
    return {
        "front": Mount((0.0, length / 2 + 0.04, 0.66), 0.0, np.radians(32)),
        "left": Mount((-width / 2 - 0.14, 0.55, 1.02), np.radians(90), np.radians(52)),
        "right": Mount((width / 2 + 0.14, 0.55, 1.02), np.radians(-90), np.radians(52)),
        "rear": Mount((0.0, -length / 2 - 0.04, 0.88), np.radians(180), np.radians(40)),
    }


def loosened(rng: np.random.Generator, mount: Mount, spread: float) -> Mount:
    """A mount whose angles are off by a normal error of `spread` radians, as after years on the road."""
    yaw, pitch, roll = rng.normal(0.0, spread, 3)
    return attrs.evolve(mount, yaw=mount.yaw + yaw, pitch=mount.pitch + pitch, roll=mount.roll + roll)
