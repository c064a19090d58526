"""The images in which a detector is most wrong, and what it found in them, drawn over the picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pavemark.detect.example import Example
from pavemark.detect.reading import picture
from pavemark.evaluate.found import Found, Marks, true_slots
from pavemark.evaluate.matching import NONE, TOLERANCE, matched, radius
from pavemark.evaluate.tally import POINTS, SLOTS, Judged

TRUE, HIT, FALSE, MISSED = (60, 220, 60), (70, 170, 255), (255, 50, 50), (255, 225, 0)
"""Colours of what is there and was found, of what was found where it is, of what was found and is not there, and of
what is there and was not found."""

WIDTHS = (3, 3, 1, 1)
"""Pixels of the lines: thick for what is there, and over it thin for what was found."""

COLUMNS = ("image", "there green, found blue, false red, missed yellow")
"""What the views of `Mistakes` are."""


def worst(judged: Judged, thresholds: Mapping[str, float], most: int) -> list[str]:
    """Names of the images with most false positives and misses, at most so many; none that has no mistake.

    They are counted by slots where those are labelled; of equals by points; of equals still, by name.

    Parameters
    ----------
    judged : Judged
    thresholds : mapping of str to float
        The least confidence of what counts, for each of `Judged.kinds`.
    most : int
    """
    wrong = [sum(tally.mistakes(thresholds[kind])) for kind, tally in judged.kinds.items()]
    order = sorted((*(-count for count in counts), name) for *counts, name in zip(*wrong, judged.names, strict=True))
    return [name for *counts, name in order[:most] if any(counts)]


class Mistakes:
    """An image with its mistakes, a strip of a contact sheet (`pavemark.job.contact_sheet.Strip`).

    Attributes
    ----------
    title : str
    size : tuple of int
        Width and height of the picture.
    """

    def __init__(
        self, example: Example, found: Found, thresholds: Mapping[str, float], tolerance: float = TOLERANCE
    ) -> None:
        self._example = example
        near = radius(example.frame, tolerance)
        self._kinds = [_sorted_out(found.points, thresholds[POINTS], np.reshape(example.points, (-1, 2)), near)]
        if example.slots is not None:
            self._kinds.insert(0, _sorted_out(found.slots, thresholds[SLOTS], true_slots(example), near))
        _, missed, false, _ = self._kinds[0]
        self.title = f"{example.name}: {len(false)} false, {len(missed)} missed"
        self.size = (example.frame.width, example.frame.height)

    def tiles(self, scale: float) -> Sequence[np.ndarray]:
        """The picture, and what was found over it; see `pavemark.job.contact_sheet.Strip.tiles`."""
        image = picture(self._example)
        size = [int(np.ceil(side * scale)) for side in self.size]
        tile = cv2.resize(image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)
        drawn = tile.copy()
        for kind in self._kinds:
            for places, colour, width in zip(kind, (TRUE, MISSED, FALSE, HIT), WIDTHS, strict=True):
                for place in places * scale:
                    _draw(drawn, place, colour, width)
        return [tile, drawn]


def _sorted_out(marks: Marks, threshold: float, truth: np.ndarray, near: float) -> tuple[np.ndarray, ...]:
    """Where those that were found lie, those that were missed, false positives, and where those found were found."""
    kept = marks.confidence >= threshold
    places = marks.places[kept]
    truths = matched(Marks(places, marks.confidence[kept]), truth, near)
    found = np.isin(np.arange(len(truth)), truths)
    return truth[found], truth[~found], places[truths == NONE], places[truths != NONE]


_SHIFT = 4


def _draw(tile: np.ndarray, place: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
    """A point as a ring; a pair as an arrow from p1 to p2."""
    # cv2 counts from the centre of the first pixel.
    fixed = [int(value) for value in ((place - 0.5) * (1 << _SHIFT)).round()]
    if len(fixed) == 2:
        cv2.circle(tile, fixed, 5 << _SHIFT, colour, max(1, width - 1), cv2.LINE_AA, _SHIFT)
    else:
        cv2.arrowedLine(tile, fixed[:2], fixed[2:], colour, width, cv2.LINE_AA, _SHIFT, 0.15)
