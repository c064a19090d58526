"""A sweep: detectors that learn from the first N images of a selection, for several N and seeds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import attrs

from pavemark import files
from pavemark.detect.example import Example
from pavemark.detect.learned import opened
from pavemark.detect.reading import examples
from pavemark.errors import InputError
from pavemark.evaluate.matching import TOLERANCE
from pavemark.records import read_json
from pavemark.select import scores as scored
from pavemark.select.choice import Wanted, chosen
from pavemark.select.selection import hold_as_scored, of_dataset, unreadable
from pavemark.study import runs
from pavemark.study.design import Training
from pavemark.study.judging import JUDGED, hold_judgeable, judge, judged_by
from pavemark.study.leakage import hold_apart, hold_no_plate
from pavemark.study.runs import Run
from pavemark.study.training import Tell, train_all

FINEST = 30.0
"""Pixels per metre that detectors look at unless told otherwise, where the images have more."""


@attrs.frozen(eq=False)
class Sweep:
    """What is swept.

    Attributes
    ----------
    dataset, scores : Path
        Of a Pavemark dataset, or a selection of one.
    test, validation : Path
        Datasets: figures are those of the test images, at the confidence of the best F1 of the validation images.
    keep : tuple of int
        How many images are learned from, in any order.
    seeds : int
        Of the training: 0 to this, without it.
    strategy, seed
        As for `pavemark.select.choice.Wanted`: one order for all, so that fewer images are part of more.
    training : Training
    height : float or None
        Metres down a picture of the test and validation images, where their lists lack it.
    scale : float or None
        Pixels per metre that detectors look at; None for that of the first image of the dataset, up to `FINEST`.
    """

    dataset: Path
    scores: Path
    test: Path
    validation: Path
    keep: tuple[int, ...]
    seeds: int = 3
    strategy: str = "cfds"
    seed: int = 0
    training: Training = attrs.field(factory=Training)
    height: float | None = None
    scale: float | None = None

    def __attrs_post_init__(self) -> None:
        if not self.keep:
            raise InputError("--keep", "is missing: at least one number of images is allowed")
        for number in self.keep:
            if number < 1:
                raise InputError("--keep", f"{number}: 1 or more is allowed")
            if self.keep.count(number) > 1:
                raise InputError("--keep", f"{number} is given twice: each number once is allowed")
        if self.seeds < 1:
            raise InputError("--seeds", f"{self.seeds}: 1 or more is allowed")
        if self.test.resolve() == self.validation.resolve():
            raise InputError("--validation", f"{self.validation}: is the test set: another dataset is allowed")


@attrs.frozen(eq=False)
class Trial:
    """A detector of a sweep, and how it fares.

    Attributes
    ----------
    keep, seed : int
    model : Path
    figures : dict
        As `pavemark.study.judging.judge` tells them.
    """

    keep: int
    seed: int
    model: Path
    figures: dict[str, Any]


def sweep(wanted: Sweep, folder: Path, workers: int, tell: Tell, left_out: Tell) -> list[Trial]:
    """Train and judge the detectors of a sweep; what is there is not made again.

    Parameters
    ----------
    wanted : Sweep
    folder : Path
        Where models and results are kept, under hashes of all that they depend on.
    workers : int
        Processes that train.
    tell : callable
        Told a line now and then.
    left_out : callable
        Told a line of each image of the dataset that cannot be scored.

    Returns
    -------
    list of Trial
        By numbers of images, each with its seeds in their order.

    Raises
    ------
    InputError
        When a dataset cannot be read or lacks images, dataset and scores do not belong together, images that are
        judged by are learned from, or torch is missing.
    """
    parts = {part: list(examples(getattr(wanted, part), wanted.height)) for part in JUDGED}
    hold_judgeable({f"--{part} {getattr(wanted, part)}": parts[part] for part in parts})
    hold_no_plate(wanted.dataset, [*parts["validation"], *parts["test"]])
    order = _order(wanted, left_out)
    hold_apart({**{f"--{part}": parts[part] for part in parts}, "DATASET": order})
    scale = min(FINEST, order[0].frame.scale) if wanted.scale is None else wanted.scale
    made = [
        (keep, seed, Run(tuple(order[:keep]), wanted.training.steps, seed, wanted.training, scale))
        for keep in sorted(wanted.keep)
        for seed in range(wanted.seeds)
    ]
    train_all([(f"{keep} images, seed {seed}", run) for keep, seed, run in made], folder, workers, tell)
    return [_judged(keep, seed, runs.model(run, folder), parts, folder, tell) for keep, seed, run in made]


def _order(wanted: Sweep, left_out: Tell) -> list[Example]:
    """The images of the most that are kept, the first to be kept first."""
    found = scored.read(wanted.scores)
    gone = unreadable(wanted.dataset, [found])
    candidates = of_dataset(found, wanted.dataset, gone)
    for fault in gone.values():
        left_out(f"left out: {fault}")
    asked = Wanted(wanted.strategy, max(wanted.keep), wanted.seed)
    names = [each.name for each in chosen(candidates, asked, None, found.embeddings)]
    kept = set(names)
    hold_as_scored(wanted.dataset, kept, [found])
    by_name = {example.name: example for example in examples(wanted.dataset, only=lambda _, name: name in kept)}
    return [by_name[name] for name in names]


def _judged(keep: int, seed: int, model: Path, parts: dict[str, list[Example]], folder: Path, tell: Tell) -> Trial:
    path = folder / "results" / f"{judged_by([model], parts, TOLERANCE)}.json"
    if not path.exists():
        tell(f"judged: {keep} images, seed {seed}")
        figures = judge([opened(model)], None, parts, TOLERANCE)
        files.write(path, json.dumps(figures, indent=1, sort_keys=True) + "\n")
    return Trial(keep, seed, model, read_json(path))
