"""A detector, or several together, judged by a set of labelled images: one picture at a time is in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from pavemark.detect.detection import Detection, Detector
from pavemark.detect.example import Example
from pavemark.detect.reading import picture
from pavemark.errors import InputError
from pavemark.evaluate.ensembles import voted
from pavemark.evaluate.found import Found, Marks, found, true_slots
from pavemark.evaluate.matching import NONE, TOLERANCE, matched, radius
from pavemark.evaluate.tally import Judged, Tally

Finder = Callable[[Example], Found]
"""Opens the picture of an example and finds what is there."""


def judged(detector: Detector, examples: Iterable[Example], tolerance: float = TOLERANCE) -> Judged:
    """Judge a detector.

    Parameters
    ----------
    detector : Detector
    examples : iterable of Example
        Read once, one after the other.
    tolerance : float
        Of Eq. 3, pixels at 60 px/m.

    Raises
    ------
    InputError
        When a picture cannot be read; when the detector fails, or finds what is no detection: naming image and model;
        and as `of_found`.
    """
    find = finder([detector])
    return of_found(((example, find(example)) for example in examples), tolerance)


def judged_together(
    detectors: Sequence[Detector], examples: Iterable[Example], vote: str, tolerance: float = TOLERANCE
) -> Judged:
    """Judge what several detectors find together.

    Parameters
    ----------
    detectors : sequence of Detector
        In any order.
    examples : iterable of Example
        Read once, one after the other.
    vote : str
        One of `pavemark.evaluate.ensembles.VOTES`.
    tolerance : float
        Of Eq. 3, pixels at 60 px/m; also how near two detectors mean the same.

    Raises
    ------
    InputError
        As `judged`.
    """
    find = finder(detectors, vote, tolerance)
    return of_found(((example, find(example)) for example in examples), tolerance)


def finder(detectors: Sequence[Detector], vote: str | None = None, tolerance: float = TOLERANCE) -> Finder:
    """What one detector finds where there is no vote, or several together."""

    def find(example: Example) -> Found:
        image = picture(example)
        each = [_found_by(detector, example, image) for detector in detectors]
        return each[0] if vote is None else voted(each, vote, radius(example.frame, tolerance))

    return find


def of_detections(examples: Iterable[Example], detections: Iterable[Detection], tolerance: float = TOLERANCE) -> Judged:
    """Judge what was found before: a detection for each example, in their order.

    Raises
    ------
    ValueError
        When there are more of one than of the other, or a detection is none.
    InputError
        As `of_found`.
    """
    return of_found(
        ((example, found(detection)) for example, detection in zip(examples, detections, strict=True)), tolerance
    )


def of_votes(
    examples: Iterable[Example],
    detections: Iterable[Sequence[Detection]],
    vote: str,
    tolerance: float = TOLERANCE,
) -> Judged:
    """Judge what several detectors found before, together: for each example a detection of each of them.

    Parameters
    ----------
    examples : iterable of Example
    detections : iterable of sequence of Detection
        In the order of the examples; as many for each of them as there are detectors.
    vote : str
        One of `pavemark.evaluate.ensembles.VOTES`.
    tolerance : float
        As `judged_together` takes it.

    Raises
    ------
    ValueError
        As `of_detections`.
    InputError
        As `of_found`.
    """
    return of_found(
        (
            (example, voted([found(detection) for detection in each], vote, radius(example.frame, tolerance)))
            for example, each in zip(examples, detections, strict=True)
        ),
        tolerance,
    )


def of_found(pairs: Iterable[tuple[Example, Found]], tolerance: float = TOLERANCE) -> Judged:
    """Judge what was found: an example and what was found in it, one after the other.

    Kept are names, groups, and of all that was found the confidence and whether it is there.

    Raises
    ------
    InputError
        When there is no image, a name occurs twice, or some have slots labelled and others have not.
    """
    seen = Alike()
    groups: list[dict[str, str]] = []
    points, slots = _Counting(), _Counting()
    for example, what in pairs:
        seen.hold(example)
        near = radius(example.frame, tolerance)
        groups.append(example.groups)
        points.add(what.points, np.reshape(example.points, (-1, 2)), near)
        if seen.labelled:
            slots.add(what.slots, true_slots(example), near)
    if not seen.names:
        raise InputError("the set", "holds no image: at least one is needed")
    return Judged(tuple(seen.names), tuple(groups), points.tally(), slots.tally() if seen.labelled else None)


class Alike:
    """What the images of a set have to have in common to be judged by.

    Attributes
    ----------
    names : dict of str to None
        In their order.
    labelled : bool or None
        Whether slots are labelled; None before the first image.
    """

    def __init__(self) -> None:
        self.names: dict[str, None] = {}
        self.labelled: bool | None = None

    def hold(self, example: Example) -> None:
        """Hold that an image is like those before it.

        Raises
        ------
        InputError
            When it was there before, or has slots labelled where they have not, or has not where they have.
        """
        if example.name in self.names:
            raise InputError(example.name, "is in the set twice: once is allowed")
        slots = example.slots is not None
        if self.labelled not in (None, slots):
            few = "has slots labelled, which images before it have not" if slots else "has no slots labelled"
            raise InputError(example.name, f"{few}: a set all of whose images are labelled alike is allowed")
        self.names[example.name] = None
        self.labelled = slots


class _Counting:
    """The tally of one kind as images come."""

    def __init__(self) -> None:
        self._confidence: list[np.ndarray] = []
        self._hit: list[np.ndarray] = []
        self._truths: list[int] = []

    def add(self, marks: Marks, truth: np.ndarray, near: float) -> None:
        self._confidence.append(marks.confidence)
        self._hit.append(matched(marks, truth, near) != NONE)
        self._truths.append(len(truth))

    def tally(self) -> Tally:
        image = np.repeat(np.arange(len(self._truths)), [len(each) for each in self._confidence])
        return Tally(np.concatenate(self._confidence), np.concatenate(self._hit), image, np.array(self._truths))


def _found_by(detector: Detector, example: Example, image: np.ndarray) -> Found:
    try:
        return found(detector.detect(image, example.frame))
    except InputError as error:
        raise InputError(example.image, str(error)) from None
    except ValueError as error:
        raise InputError(example.image, f"{detector.family} {detector.version[:12]}: {error}") from None
