"""How a detector of the study fares on the test places, the confidence that counts chosen on the validation places."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import attrs

from pavemark.detect.detection import Detector
from pavemark.detect.example import Example
from pavemark.evaluate.curve import best_threshold
from pavemark.evaluate.judge import judged, judged_together
from pavemark.evaluate.results import plain, plain_curve, result
from pavemark.evaluate.tally import Judged
from pavemark.study.design import Row


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
