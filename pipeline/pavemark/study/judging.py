"""How a detector of the study fares on the test places, the confidence that counts chosen on the validation places."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from pavemark.detect.detection import Detector
from pavemark.detect.example import Example
from pavemark.detect.reading import hold_labelled, picture
from pavemark.errors import InputError
from pavemark.evaluate.curve import best_threshold
from pavemark.evaluate.judge import Alike, judged, judged_together
from pavemark.evaluate.results import plain, plain_curve, result
from pavemark.evaluate.tally import Judged
from pavemark.select.scoring import versions
from pavemark.study import runs
from pavemark.study.design import Row

JUDGED = ("validation", "test")
"""Parts that a detector is judged by: the first chooses the confidence."""


@attrs.frozen(eq=False)
class Verdict:
    """How a row fared at one seed.

    Attributes
    ----------
    name : str
        Of the row, with its vote where it has several detectors.
    row : Row
    seed : int
    real, synthetic : int
        Images learned from.
    figures : dict
        As `judge` tells them.
    """

    name: str
    row: Row
    seed: int
    real: int
    synthetic: int
    figures: dict[str, Any]


def judged_by(models: Sequence[Path], parts: dict[str, list[Example]], tolerance: float) -> str:
    """Hash of detectors, whose files are called by what they depend on, and of all that they are judged by."""
    told = {
        **versions(),
        "models": [model.stem for model in models],
        "tolerance": tolerance,
        **{part: runs.digest(parts[part]) for part in JUDGED},
    }
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:32]


def hold_judgeable(parts: Mapping[str, Sequence[Example]]) -> None:
    """Hold, before long work, that images can be judged by.

    Parameters
    ----------
    parts : dict of str to sequence of Example
        By what a part is called.

    Raises
    ------
    InputError
        When a picture cannot be read or is of another size than its labels say, one is listed twice or is labelled
        otherwise than those before it, its marking points are not known, or there is none in a part.
    """
    for part, examples in parts.items():
        alike = Alike()
        for example in examples:
            alike.hold(example)
            hold_labelled(example)
            picture(example)
        if not any(len(example.points) for example in examples):
            raise InputError(part, "has no marking point: images with at least one are allowed")


def judge(
    detectors: Sequence[Detector], vote: str | None, parts: dict[str, list[Example]], tolerance: float
) -> dict[str, Any]:
    """Judge a detector, or several that vote, by marking points.

    Parameters
    ----------
    detectors : sequence of Detector
    vote : str or None
        One of `pavemark.evaluate.ensembles.VOTES`; None for a single detector.
    parts : dict of str to list of Example
        "validation", which chooses the confidence, and "test".
    tolerance : float
        Of Eq. 3, pixels at 60 px/m.

    Returns
    -------
    dict
        `threshold`; `test`, `validation` and, by their names, `places` of the test: results as JSON holds them; the
        `curve` of the test.
    """

    def looked(part: str) -> Judged:
        if vote is None:
            return judged(detectors[0], parts[part], tolerance)
        return judged_together(detectors, parts[part], vote, tolerance)

    validation, test = looked("validation"), looked("test")
    threshold = best_threshold(validation.points)

    def told(of: Judged) -> dict[str, Any]:
        return plain(result(of.points, threshold, of.clusters()))

    found = {
        "threshold": threshold,
        "validation": told(validation),
        "test": told(test),
        "curve": plain_curve(test.points),
        "places": {place: told(of) for place, of in test.by("place").items()},
    }
    # As it will be read back: what is made of it is the same the first time and ever after.
    return json.loads(json.dumps(found, sort_keys=True))
