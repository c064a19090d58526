"""How long a clean plate takes: markings found, hole filled, at a full view's size and at a half-view's."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from statistics import median

import attrs
import cv2
import numpy as np

from pavemark.accuracy.apart import Apart
from pavemark.accuracy.cases import FEW, Sample, some
from pavemark.accuracy.fills import Crew
from pavemark.accuracy.holes import around
from pavemark.accuracy.watcher import Watcher
from pavemark.background.finding import SEGMENTERS
from pavemark.errors import InputError
from pavemark.ground import Frame

FRAMES = (Frame(600, 600, 60.0), Frame(96, 300, 1 / 0.044))
"""10 m × 10 m, and 4.2 m × 13.2 m."""

TRIED = 4
"""Images looked at for each that is timed: some have no marking."""


@attrs.frozen
class Speed:
    """A row of speed.csv: medians over the images.

    Attributes
    ----------
    width, height : int
        Pixels.
    segmenter, inpainter : str
    images : int
        How many were timed.
    segment_seconds, fill_seconds : float
        Processor time, one thread.
    plates_per_minute : float
        60 over the sum of both.
    """

    width: int
    height: int
    segmenter: str
    inpainter: str
    images: int
    segment_seconds: float
    fill_seconds: float
    plates_per_minute: float


@attrs.frozen(eq=False)
class Picture:
    """An image, cut and scaled to a frame, with the hole that its markings make."""

    image: np.ndarray
    hole: np.ndarray
    keep_out: np.ndarray


def speeds(sample: Sample, crew: Crew, most: int, watcher: Watcher) -> list[Speed]:
    """Time every segmenter and every inpainter on the same pictures.

    Each method has worked once before: to load a library or a network is not counted. The holes are those of the
    masks, or of what the sample's segmenter finds, whichever segmenter is timed.

    Parameters
    ----------
    sample : Sample
    crew : Crew
        The inpainters.
    most : int
        Images to time with; they are spread evenly over those that have a marking.
    watcher : Watcher
    """
    rows = []
    with ExitStack() as stack:
        finders = {}
        for name in SEGMENTERS:
            finder = stack.enter_context(Apart(find, name))
            try:
                finder(name, np.full((64, 64, 3), 128, np.uint8), Frame(64, 64))
            except InputError as error:
                watcher.tell(f"{error}; the segmenter is not timed")
                continue
            finders[name] = finder
        pictures = {frame: _pictures(sample, frame, most) for frame in FRAMES}
        with watcher.of(sum(map(len, pictures.values()))):
            for frame, shown in pictures.items():
                rows += _timed(frame, shown, finders, crew, watcher)
    return rows


def _timed(
    frame: Frame, shown: Sequence[Picture], finders: dict[str, Apart], crew: Crew, watcher: Watcher
) -> list[Speed]:
    found, filled = ({name: [] for name in names} for names in (finders, crew.methods))
    for picture in shown:
        for name, finder in finders.items():
            try:
                found[name].append(finder(name, picture.image, frame).seconds)
            except InputError as error:
                watcher.tell(str(error))
        for name, answer in crew.fill(picture.image, picture.hole, picture.keep_out, watcher.tell):
            filled[name].append(answer.seconds)
        watcher.step(False)
    return [
        _row(frame, finder, method, found[finder], filled[method])
        for finder in finders
        for method in crew.methods
        if found[finder] and filled[method]
    ]


def find(name: str, image: np.ndarray, frame: Frame) -> None:
    """Find markings and ground, for a process of its own."""
    SEGMENTERS[name].find(image, frame)


def _row(frame: Frame, finder: str, method: str, found: Sequence[float], filled: Sequence[float]) -> Speed:
    segment, fill = median(found), median(filled)
    return Speed(frame.width, frame.height, finder, method, len(filled), segment, fill, 60 / (segment + fill))


def _pictures(sample: Sample, frame: Frame, most: int) -> tuple[Picture, ...]:
    """The images that have a marking, at most so many, as large as the frame; what they show is of another scale."""
    size = (frame.width, frame.height)
    made = []
    for entry in some(sample.entries, TRIED * most):
        try:
            plate = sample.plate(entry)
        except InputError:
            continue  # it was told of by the judge
        if plate.markings.mean() < FEW:
            continue
        crop = _crop(plate.source.shape, size)
        image = cv2.resize(plate.source[crop], size, interpolation=cv2.INTER_AREA)
        marking, ground = (
            cv2.resize(mask[crop].astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
            for mask in (plate.markings, plate.ground)
        )
        hole = around(marking, frame) & ground
        if hole.any() and (ground & ~hole).any():
            made.append(Picture(image, hole, ~ground))
    return some(made, most)


def _crop(shape: tuple[int, ...], size: tuple[int, int]) -> tuple[slice, slice]:
    """The largest part of a picture, in its middle, that has the proportions of a size (width, height)."""
    height, width = shape[:2]
    share = min(width / size[0], height / size[1])
    wide, high = round(share * size[0]), round(share * size[1])
    top, left = (height - high) // 2, (width - wide) // 2
    return slice(top, top + high), slice(left, left + wide)
