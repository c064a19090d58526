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

    @property
    def matrix(self) -> np.ndarray:
        """`to_world` as a homography (3, 3), image → world, float64."""
        width, height = self.size
        return np.array([[1 / self.scale, 0, -width / 2], [0, -1 / self.scale, height / 2], [0, 0, 1]])

    def pixel_centres(self) -> np.ndarray:
        """World positions (H, W, 2) of the pixel centres, in metres."""
        u, v = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        return self.to_world(np.stack([u, v], -1))

    def contains(self, uv: np.ndarray) -> np.ndarray:
        """Whether image coordinates (..., 2) lie inside the picture, bool (...)."""
        uv = np.asarray(uv)
        return (uv[..., 0] >= 0) & (uv[..., 0] < self.width) & (uv[..., 1] >= 0) & (uv[..., 1] < self.height)


WORST_CONDITION = 1e7
"""Largest condition number of a homography: beyond it less than half of float64's digits are left."""


def homography(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The map of Eq. 1, `s·[x', y', 1] = H·[x, y, 1]`, that takes points of one plane to those of another.

    The normalised direct linear transform (Hartley, 1997); more than four pairs are met in the least-squares sense.

    Parameters
    ----------
    source, target : ndarray (N, 2)
        At least four corresponding points in any units.

    Returns
    -------
    ndarray (3, 3), float64
        Of Frobenius norm 1, positive scale s at the source points.

    Raises
    ------
    ValueError
        When the points are fewer than four; when they leave the map undetermined or singular, as three of four on a
        line do, or lie so far off that their own digits do not tell them apart: the condition number is told; when no
        map has all of them on one side of its vanishing line, as where two corners of a quadrilateral are exchanged.

    Examples
    --------
    >>> square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    >>> project(homography(square, 3 * square + 5), np.array([0.5, 0.5]))
    array([6.5, 6.5])
    """
    source, target = (np.asarray(points, np.float64) for points in (source, target))
    if source.shape != target.shape or source.ndim != 2 or source.shape[1] != 2 or len(source) < 4:
        raise ValueError(f"{source.shape} and {target.shape} points: at least four pairs are allowed")
    if not (np.isfinite(source).all() and np.isfinite(target).all()):
        raise ValueError("points are not finite: finite coordinates are allowed")
    to_unit, to_unit_target = _normalising(source), _normalising(target)
    _, singular, rows = np.linalg.svd(equations(project(to_unit, source), project(to_unit_target, target)))
    normalised = rows[8].reshape(3, 3)
    condition = max(
        singular[0] / max(singular[7], np.finfo(float).tiny),
        np.linalg.cond(normalised),
        # How much further the points lie from their origin than from each other.
        *(np.abs(to_unit[:2, 2]).max() for to_unit in (to_unit, to_unit_target)),
    )
    if condition > WORST_CONDITION:
        raise ValueError(
            f"condition number {condition:.1e}: up to {WORST_CONDITION:.0e} is allowed; "
            "four points, no three of them on a line and their origin not far off, determine a homography"
        )
    matrix = np.linalg.solve(to_unit_target, normalised @ to_unit)
    matrix /= np.linalg.norm(matrix)
    project(matrix, source)
    return matrix * np.sign(matrix[2] @ (*source[0], 1.0))


def equations(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The direct linear transform of Eq. 1: rows (2N, 9) that are nought times the homography, read row by row.

    Parameters
    ----------
    source, target : ndarray (N, 2)
        Corresponding points; how well the equations are conditioned depends on their units and origin.
    """
    (x, y), (p, q) = source.T, target.T
    one, none = np.ones_like(x), np.zeros_like(x)
    first = np.stack([x, y, one, none, none, none, -p * x, -p * y, -p], -1)
    second = np.stack([none, none, none, x, y, one, -q * x, -q * y, -q], -1)
    return np.concatenate([first, second])


def project(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (..., 2) as a homography (3, 3) maps them (Eq. 1), float64.

    Raises
    ------
    ValueError
        When the points lie on the map's vanishing line or on both sides of it.
    """
    points = np.asarray(points, np.float64)
    mapped = points @ matrix[:, :2].T + matrix[:, 2]
    scale = mapped[..., 2:]
    if scale.size and not (scale.min() > 0 or scale.max() < 0):
        raise ValueError("points lie beyond the homography's vanishing line: points on one side of it are allowed")
    return mapped[..., :2] / scale


def _normalising(points: np.ndarray) -> np.ndarray:
    """The similarity (3, 3) that moves points to the origin and scales their root mean square distance to √2."""
    centre = points.mean(0)
    spread = np.sqrt(((points - centre) ** 2).sum(1).mean() / 2)
    if spread == 0:
        raise ValueError("condition number inf: all points are one; four points, no three on a line, are allowed")
    return np.array([[1 / spread, 0, -centre[0] / spread], [0, 1 / spread, -centre[1] / spread], [0, 0, 1]])
