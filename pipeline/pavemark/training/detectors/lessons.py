"""What detectors learn from: images in memory with their labels, and the same as another camera might have shown it."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import cv2
import numpy as np

from pavemark.colour import quantise
from pavemark.detect.scaling import scaled

ZOOM = 0.06
"""Share by which images are enlarged and made smaller: no calibration is exact."""

SHIFT = 12.0
"""Pixels by which images are shifted, so that points fall everywhere in their cells."""

NOISE = 1 << 20
"""Numbers that noise is cut from."""

ARMS_AGREE = 0.5
"""Cosine between where an arm of a slot is and where a right-angled slot would have it: no slot leans by more."""

CONTRAST_ABOUT = 0.45


@attrs.frozen(eq=False)
class Lesson:
    """An image and its labels, in pixels of that image.

    Attributes
    ----------
    image : ndarray (H, W, 3) uint8
        Display RGB.
    points : ndarray (N, 2) float64
        Image coordinates of the marking points.
    directions : ndarray (N, 2) float64, or None
        Unit vectors in image coordinates, as `pavemark.detect.example.Example` has them.
    l_shaped : ndarray (N,) bool, or None
    slots : ndarray (M, 2) int64, or None
        Positions in `points` of p1 and p2.
    """

    image: np.ndarray
    points: np.ndarray
    directions: np.ndarray | None = None
    l_shaped: np.ndarray | None = None
    slots: np.ndarray | None = None


def at_scale(lesson: Lesson, scale: float, wanted: float) -> Lesson:
    """A lesson at another scale, both in pixels per metre."""
    image = scaled(lesson.image, scale, wanted)
    if image is lesson.image:
        return lesson
    (height, width), (new_height, new_width) = lesson.image.shape[:2], image.shape[:2]
    return attrs.evolve(lesson, image=image, points=lesson.points * (new_width / width, new_height / height))


def mirrored(lesson: Lesson, axis: int) -> Lesson:
    """The labels of a lesson whose image is mirrored; the image is left as it is.

    An L has two arms, and its direction is the one from which the other is reached by a quarter turn clockwise: in the
    mirror that is the other arm's. Where the other arm is the entrance line of a labelled slot it is known exactly;
    else it is taken to stand at a right angle. A slot lies to the left of its entrance line, so its ends change places.

    Parameters
    ----------
    lesson : Lesson
    axis : int
        0 to exchange left and right, 1 to exchange top and bottom.
    """
    points = lesson.points.copy()
    points[:, axis] = lesson.image.shape[1 - axis] - points[:, axis]
    flip = np.where(np.arange(2) == axis, -1.0, 1.0)
    slots = None if lesson.slots is None else lesson.slots[:, ::-1].copy()
    if lesson.directions is None or lesson.l_shaped is None:
        return attrs.evolve(lesson, points=points, slots=slots)
    directions = np.where(lesson.l_shaped[:, None], _other_arms(lesson), lesson.directions) * flip
    return attrs.evolve(lesson, points=points, directions=directions, slots=slots)


def _other_arms(lesson: Lesson) -> np.ndarray:
    """The second arm of every point, were it an L: unit vectors (N, 2)."""
    directions, points = lesson.directions, lesson.points
    arms = np.stack([-directions[:, 1], directions[:, 0]], -1)
    if lesson.slots is None or not len(lesson.slots):
        return arms
    first, second = lesson.slots.T
    entrance = points[second] - points[first]
    entrance = entrance / np.maximum(np.hypot(*entrance.T), 1e-9)[:, None]
    # The other arm of an L at p1 is the entrance line; at p2 a separating line, as the direction at p1 is.
    for which, exact in ((first, entrance), (second, directions[first])):
        near = (arms[which] * exact).sum(1) > ARMS_AGREE
        arms[which[near]] = exact[near]
    return arms


def noise(seed: int) -> np.ndarray:
    """Numbers of the normal distribution, which augmentation cuts its noise from: (NOISE,) float32."""
    return np.random.Generator(np.random.PCG64(seed)).standard_normal(NOISE, np.float32)


def augmented(lesson: Lesson, size: tuple[int, int], rng: np.random.Generator, grain: np.ndarray) -> Lesson:
    """A lesson as another camera might have shown it.

    Parameters
    ----------
    lesson : Lesson
    size : tuple of int
        Width and height of the result. What the image does not reach repeats its border, as for the detector's input;
        of a larger image a piece is taken.
    rng : Generator
    grain : ndarray
        From `noise`.

    Returns
    -------
    Lesson
        With an image of that size. Points that have left it are gone, and their slots with them.
    """
    flips = rng.random(2) < 0.5
    factor = float(np.exp(rng.uniform(-ZOOM, ZOOM)))
    shift = rng.uniform(-SHIFT, SHIFT, 2)
    height, width = lesson.image.shape[:2]
    signs = np.where(flips, -1.0, 1.0)
    # About the middle of the image, which comes to lie where it would in a larger input: at the upper left.
    middle = np.array([width, height]) / 2
    shift -= rng.random(2) * np.maximum(np.array([width, height]) - size, 0)
    for axis in np.flatnonzero(flips):
        lesson = mirrored(lesson, int(axis))
    matrix = np.zeros((2, 3))
    matrix[[0, 1], [0, 1]] = factor * signs
    # Continuous coordinates have the centre of the first pixel at a half.
    matrix[:, 2] = middle + shift - factor * signs * (middle - 0.5) - 0.5
    image = cv2.warpAffine(lesson.image, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    points = (lesson.points - middle) * factor + middle + shift
    return _within(attrs.evolve(lesson, image=spoilt(image, rng, grain), points=points))


def _within(lesson: Lesson) -> Lesson:
    height, width = lesson.image.shape[:2]
    kept = ((lesson.points >= 0) & (lesson.points < (width, height))).all(1)
    if kept.all():
        return lesson
    number = np.cumsum(kept) - 1
    slots = lesson.slots
    return Lesson(
        lesson.image,
        lesson.points[kept],
        None if lesson.directions is None else lesson.directions[kept],
        None if lesson.l_shaped is None else lesson.l_shaped[kept],
        None if slots is None else number[slots[kept[slots].all(1)]],
    )


def spoilt(image: np.ndarray, rng: np.random.Generator, grain: np.ndarray) -> np.ndarray:
    """Other light, other colours, less sharpness, noise: (H, W, 3) uint8."""
    if rng.random() < 0.3:
        # Towards grey or away from it.
        share = float(rng.uniform(0.3, 1.5))
        image = cv2.transform(image, share * np.eye(3) + (1 - share) / 3)
    image = cv2.LUT(image, _tones(rng))
    if rng.random() < 0.25:
        image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(0.4, 1.3)))
    if rng.random() < 0.5:
        at = int(rng.integers(max(1, len(grain) - image.size)))
        cut = np.resize(grain[at : at + image.size], image.shape)
        image = cv2.add(image, cut * np.float32(rng.uniform(0, 10)), dtype=cv2.CV_8U)
    return image


def _tones(rng: np.random.Generator) -> np.ndarray:
    """What becomes of each value of each channel: (1, 256, 3) uint8."""
    tone = np.linspace(0, 1, 256)[:, None] ** np.exp(rng.normal(0, 0.2))
    tone = (tone - CONTRAST_ABOUT) * np.exp(rng.normal(0, 0.2)) + CONTRAST_ABOUT
    tone = tone * np.exp(rng.normal(0, 0.15)) * np.exp(rng.normal(0, 0.05, 3)) + rng.normal(0, 0.04)
    return quantise(tone * 255)[None]


def canvas(lessons: Sequence[Lesson], stride: int) -> tuple[int, int]:
    """Width and height, whole strides, that every image fits into."""
    height, width = np.max([lesson.image.shape[:2] for lesson in lessons], 0)
    return int(-(-width // stride) * stride), int(-(-height // stride) * stride)
