"""Homographies (Eq. 1) as judged by the geometry stage: estimated in several ways from pairs of points with errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial

import attrs
import cv2
import numpy as np
import shapely
from shapely.geometry import LineString

from pavemark.accuracy import marked
from pavemark.ground import Frame, equations, homography, project

FRAME = Frame()

PAIRS, DRAWS = 24, 20
"""Pairs of points a homography is estimated from, and draws of them."""

TILT = np.array([[1.0, 0.1, 0.0], [0.0, 1.2, 0.0], [0.0, 0.08, 1.0]])
"""How the camera sees the ground, before the pixels of the frame."""

ASTRAY = 60.0
"""Pixels by which a wrong pair may be off, either way: a metre."""

Estimator = Callable[[np.ndarray, np.ndarray], np.ndarray]


@attrs.frozen
class Pairs:
    """Points of the ground and where they are seen.

    Attributes
    ----------
    noise : float
        Standard deviation in pixels of where they are seen.
    distance : float
        Metres between the frame's centre and the origin, along each axis.
    wrong : int
        How many pairs of PAIRS are wrong altogether.
    """

    noise: float = 0.0
    distance: float = 0.0
    wrong: int = 0


def plain(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The direct linear transform on the coordinates as they are, not normalised.

    Parameters
    ----------
    source, target : ndarray (N, 2) float64
        At least four pairs.

    Returns
    -------
    ndarray (3, 3) float64
    """
    return np.linalg.svd(equations(source, target))[2][8].reshape(3, 3)


def opencv(source: np.ndarray, target: np.ndarray, method: int) -> np.ndarray:
    """`cv2.findHomography`, inliers within 3 pixels for the methods that look for them, as is its default.

    Raises
    ------
    ValueError
        When it finds none.
    """
    matrix, _ = cv2.findHomography(source, target, method, ransacReprojThreshold=3.0)
    if matrix is None:
        raise ValueError("cv2.findHomography found no homography")
    return matrix


METHODS = {
    "OpenCV least squares": 0,
    "OpenCV RANSAC": cv2.RANSAC,
    "OpenCV LMEDS": cv2.LMEDS,
    "OpenCV RHO": cv2.RHO,
    "OpenCV USAC MAGSAC": cv2.USAC_MAGSAC,
}
"""Of `cv2.findHomography`, by name."""


NORMALISED = "normalised DLT"


def estimating(pairs: Pairs) -> Mapping[tuple[str, str], Callable[[], list[np.ndarray]]]:
    """Ways to estimate the homographies (3, 3), world to image, of all draws."""
    estimators = {NORMALISED: homography, "plain DLT": plain}
    estimators |= {name: partial(opencv, method=method) for name, method in METHODS.items()}
    return {(name, ""): partial(_all, estimator, drawn(pairs)) for name, estimator in estimators.items()}


def _all(estimator: Estimator, draws: Sequence[tuple[np.ndarray, np.ndarray]]) -> list[np.ndarray]:
    return [estimator(world, seen) for world, seen in draws]


@cache
def drawn(pairs: Pairs) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """DRAWS of points of the world (PAIRS, 2), metres, and where they are seen (PAIRS, 2), pixels."""
    made = []
    for rng in map(np.random.default_rng, range(DRAWS)):
        world = rng.uniform(-5, 5, (PAIRS, 2))
        seen = true(world) + pairs.noise * rng.standard_normal(world.shape)
        seen[: pairs.wrong] += rng.uniform(-ASTRAY, ASTRAY, (pairs.wrong, 2))
        made.append((world + pairs.distance, seen))
    return tuple(made)


def true(world: np.ndarray) -> np.ndarray:
    """Where points (..., 2) near the frame's centre are seen, pixels.

    Both have their second axis down: of a map that mirrors, OpenCV's RHO and USAC find nothing.
    """
    return FRAME.to_image(project(TILT, world * (1, -1)))


def errors(made: Sequence[np.ndarray], pairs: Pairs) -> dict[str, float]:
    """Medians over the draws: "error", Hausdorff's distance of a row's lines, and "marking_point", its worst corner."""
    corners = marked.marking_points()
    outline = np.concatenate([stroke.path for stroke in marked.row()])
    far, off = [], []
    for matrix in made:
        far.append(
            shapely.hausdorff_distance(LineString(true(outline)), LineString(_mapped(matrix, outline, pairs.distance)))
        )
        off.append(np.linalg.norm(_mapped(matrix, corners, pairs.distance) - true(corners), axis=-1).max())
    return {"error": float(np.median(far)), "marking_point": float(np.median(off))}


def _mapped(matrix: np.ndarray, local: np.ndarray, distance: float) -> np.ndarray:
    """As `project`, but that a map gone wrong may put the ground on both sides of its horizon."""
    mapped = (local + distance) @ matrix[:, :2].T + matrix[:, 2]
    return mapped[..., :2] / mapped[..., 2:]
