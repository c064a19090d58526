"""Datasets as detectors learn from them: at one scale, and in memory as far as it reaches."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from pavemark.detect.example import Example
from pavemark.detect.reading import AT_A_TIME, picture
from pavemark.detect.scaling import size_at
from pavemark.errors import InputError
from pavemark.training.detectors.lessons import Lesson, at_scale

MEMORY = 2 * 10**9
"""Bytes of images that a set keeps; those beyond are read whenever they are looked at."""

LARGEST = 640
"""Pixels a side of what is learnt from at a time."""


class Lessons(Sequence[Lesson]):
    """The lessons of labelled images, read when they are first looked at.

    Parameters
    ----------
    examples : sequence of Example
    pixels_per_metre : float
        The scale that they are brought to.
    memory : int
        Bytes of images that are kept.
    """

    def __init__(self, examples: Sequence[Example], pixels_per_metre: float, memory: int = MEMORY) -> None:
        self._examples = examples
        self._scale = pixels_per_metre
        self._left = memory
        self._kept: dict[int, Lesson] = {}

    def __len__(self) -> int:
        return len(self._examples)

    def __getitem__(self, at: int) -> Lesson:
        if at in self._kept:
            return self._kept[at]
        lesson = _read(self._examples[at], self._scale)
        if lesson.image.nbytes <= self._left:
            self._left -= lesson.image.nbytes
            self._kept[at] = lesson
        return lesson


def _read(example: Example, pixels_per_metre: float) -> Lesson:
    lesson = Lesson(picture(example), example.points, example.directions, example.l_shaped, example.slots)
    return at_scale(lesson, example.frame.scale, pixels_per_metre)


def largest(examples: Sequence[Example], pixels_per_metre: float, stride: int) -> tuple[int, int]:
    """Width and height, whole strides, that every image fits into at a scale; up to LARGEST."""
    sizes = [
        size_at((example.frame.width, example.frame.height), example.frame.scale, pixels_per_metre)
        for example in examples
    ]
    width, height = (min(LARGEST, -(-max(sides) // stride) * stride) for sides in zip(*sizes, strict=True))
    return width, height


def digest(examples: Sequence[Example]) -> str:
    """A hash of names, labels and pictures: what tells datasets apart.

    Raises
    ------
    InputError
        When a picture cannot be read.
    """
    told = hashlib.sha256()
    with ThreadPoolExecutor(AT_A_TIME) as crew:
        for example, seen in zip(examples, crew.map(_hashed, [example.image for example in examples]), strict=True):
            frame = example.frame
            labels = (example.points, example.directions, example.l_shaped, example.slots)
            known = [None if each is None else each.tolist() for each in labels]
            told.update(json.dumps([example.name, frame.width, frame.height, frame.scale, seen, *known]).encode())
    return told.hexdigest()


def _hashed(image: Path) -> str:
    try:
        with image.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(image, f"cannot be read: {error.strerror}") from None
