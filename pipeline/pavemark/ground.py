"""The frame: where a pixel lies on the ground, at any size and scale, and the homography of Eq. 1."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.records import within


@attrs.frozen
class Frame:
    """A picture of the ground seen straight from above.

    The world has Blender's axes in metres, its origin at the frame's centre, Y up in the picture. Image
    coordinates (u, v) are continuous, u right, v down, 0…W and 0…H; the centre of pixel k lies at k + 0.5.

    Attributes
    ----------
    width, height : int
        Pixels.
    scale : float
        Pixels per metre. The default is 60: 600 px are 10 m.
    """

    width: int = attrs.field(default=600, validator=within(8, 16384))
    height: int = attrs.field(default=600, validator=within(8, 16384))
    scale: float = attrs.field(default=60.0, validator=within(1.0, 10000.0))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in metres."""
        return self.width / self.scale, self.height / self.scale

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        """Image coordinates (..., 2) in pixels → world (..., 2) in metres, float64."""
        uv = np.asarray(uv, np.float64)
        x = uv[..., 0] / self.scale - self.width / (2 * self.scale)
        y = self.height / (2 * self.scale) - uv[..., 1] / self.scale
        return np.stack([x, y], -1)

    def to_image(self, xy: np.ndarray) -> np.ndarray:
        """World (..., 2) in metres → image coordinates (..., 2) in pixels, float64."""
        xy = np.asarray(xy, np.float64)
        u = (xy[..., 0] + self.width / (2 * self.scale)) * self.scale
        v = (self.height / (2 * self.scale) - xy[..., 1]) * self.scale
        return np.stack([u, v], -1)

    def pixel_centres(self) -> np.ndarray:
        """World positions (H, W, 2) of the pixel centres, in metres."""
        u, v = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        return self.to_world(np.stack([u, v], -1))

    def contains(self, uv: np.ndarray) -> np.ndarray:
        """Whether image coordinates (..., 2) lie inside the picture, bool (...)."""
        uv = np.asarray(uv)
        return (uv[..., 0] >= 0) & (uv[..., 0] < self.width) & (uv[..., 1] >= 0) & (uv[..., 1] < self.height)
