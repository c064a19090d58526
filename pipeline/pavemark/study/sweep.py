"""A sweep: detectors that learn from the first N images of a selection, for several N and seeds."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs

from pavemark import __version__, files
from pavemark.detect.example import Example
from pavemark.detect.learned import opened
from pavemark.detect.reading import examples, hold_labelled, manifest, of_both
from pavemark.errors import InputError
from pavemark.evaluate.matching import TOLERANCE
from pavemark.records import read_json
from pavemark.select import scores as scored
from pavemark.select.choice import Wanted, chosen
from pavemark.select.selection import hold_as_scored, of_dataset, unreadable
from pavemark.study import runs
from pavemark.study.design import Training
from pavemark.study.judging import judge
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


def sweep(wanted: Sweep, folder: Path, workers: int, tell: Tell) -> list[Trial]:
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
    parts = {part: list(examples(getattr(wanted, part), wanted.height)) for part in ("validation", "test")}
    _hold_of_use(parts["validation"], parts["test"], wanted)
    hold_no_leak(wanted.dataset, [*parts["validation"], *parts["test"]])
    order = _order(wanted, tell)
    scale = min(FINEST, order[0].frame.scale) if wanted.scale is None else wanted.scale
    made = [
        (keep, seed, Run(tuple(order[:keep]), wanted.training.steps, seed, wanted.training, scale))
        for keep in sorted(wanted.keep)
        for seed in range(wanted.seeds)
    ]
    train_all([(f"{keep} images, seed {seed}", run) for keep, seed, run in made], folder, workers, tell)
    by = runs.digest([*parts["validation"], *parts["test"]])
    return [_judged(keep, seed, runs.model(run, folder), parts, by, folder, tell) for keep, seed, run in made]


def _order(wanted: Sweep, tell: Tell) -> list[Example]:
    """The images of the most that are kept, the first to be kept first."""
    found = scored.read(wanted.scores)
    gone = unreadable(wanted.dataset, [found])
    candidates = of_dataset(found, wanted.dataset, gone)
    for fault in gone.values():
        tell(f"left out: {fault}")
    asked = Wanted(wanted.strategy, max(wanted.keep), wanted.seed)
    names = [each.name for each in chosen(candidates, asked, None, found.embeddings)]
    kept = set(names)
    hold_as_scored(wanted.dataset, kept, [found])
    by_name = {example.name: example for example in examples(wanted.dataset, only=lambda _, name: name in kept)}
    return [by_name[name] for name in names]


def _hold_of_use(validation: Sequence[Example], test: Sequence[Example], wanted: Sweep) -> None:
    """Hold that there is something to find, and that no image that figures are of chooses the confidence."""
    for example in (*validation, *test):
        hold_labelled(example)
    for option, part in (("--validation", validation), ("--test", test)):
        if not any(len(example.points) for example in part):
            where = getattr(wanted, option.removeprefix("--"))
            raise InputError(option, f"{where}: has no marking point: images with at least one are allowed")
    for example in of_both(validation, test):
        raise InputError("--validation", f"{wanted.validation}: {example.name} is a test image: others are allowed")


def hold_no_leak(dataset: Path, judged: Iterable[Example]) -> None:
    """Hold that no image of a dataset is on a plate that was made of an image that is judged by.

    A plate is called as the image it was made of. Where an image that is judged by was painted on a plate itself, it is
    that plate that counts.

    Parameters
    ----------
    dataset : Path
    judged : iterable of Example

    Raises
    ------
    InputError
        When one is: what is judged by must not be learned from.
    """
    plates = {Path(str(line.get("input", ""))).stem: name for name, line in manifest(dataset)}
    for example in judged:
        plate = Path(example.groups.get("plate") or example.image).stem
        if plate in plates:
            raise InputError(
                dataset,
                f"{plates[plate]}: its plate, {plate}, is that of {example.image}, which is judged by: others may be",
            )


def _judged(
    keep: int, seed: int, model: Path, parts: dict[str, list[Example]], by: str, folder: Path, tell: Tell
) -> Trial:
    path = folder / "results" / f"{model.stem}-{by}.json"
    told = read_json(path) if path.exists() else None
    if not isinstance(told, dict) or told.get("pavemark") != __version__:
        tell(f"judged: {keep} images, seed {seed}")
        told = {"pavemark": __version__, "figures": judge([opened(model)], None, parts, TOLERANCE)}
        files.write(path, json.dumps(told, indent=1, sort_keys=True) + "\n")
    return Trial(keep, seed, model, told["figures"])
