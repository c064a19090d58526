"""A folder that tells which images of a dataset are kept, and has them as well where that is asked for."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark import __version__, files
from pavemark.detect.reading import (
    MANIFEST,
    SELECTION,
    Unlabelled,
    examples,
    examples_or_faults,
    hold_labelled,
    manifest,
    picture,
    source,
)
from pavemark.errors import InputError
from pavemark.records import read_json
from pavemark.select import report, scores
from pavemark.select.candidate import Candidate
from pavemark.select.choice import Wanted, chosen
from pavemark.select.material import materialise
from pavemark.select.origin import dataset_hash, mark
from pavemark.select.scores import Scores
from pavemark.select.shards import Origin


@attrs.frozen
class Outcome:
    """What came of a selection.

    Attributes
    ----------
    kept : int
        Images.
    images : int
        That they were chosen from.
    left_out : int
        Images of the dataset that have no score and cannot be read.
    """

    kept: int
    images: int
    left_out: int


def select(
    dataset: Path,
    scored: Path,
    out: Path,
    wanted: Wanted,
    learner: Path | None = None,
    real: Path | None = None,
    way: str | None = None,
    step: Callable[[], None] = lambda: None,
    tell: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Select images of a dataset; the same call again makes the same folder.

    `selection.json` tells what was asked for, `manifest.jsonl` lists the kept images, and `report.html` shows them.
    The folder is a dataset to `pavemark.detect.reading.examples` as soon as its manifest is there.

    Parameters
    ----------
    dataset : Path
        What `pavemark render` made, or a selection of it.
    scored : Path
        Scores of its images, those of more images among them or not.
    out : Path
    wanted : Wanted
    learner : Path or None
        Scores under the detector that is to learn, for the strategy "learnable".
    real : Path or None
        Scores of real images under the detector of `scored`, for the strategy "like-real".
    way : str or None
        One of `pavemark.select.material.WAYS`: the images and labels are put into the folder.
    step : callable
        Called after each image that is put there.
    tell : callable
        Told a line of each image that is left out.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        When dataset and scores do not belong together, an image that can be read has no score, one that is kept has
        changed since, so many images cannot be kept, the dataset lacks files, or the folder cannot be written or holds
        something else.
    """
    reference = scores.read(scored)
    other = None if learner is None else scores.read(learner)
    both = [reference] if other is None else [reference, other]
    shown = None if real is None else _seen(scores.read(real), reference)
    gone = unreadable(dataset, both)
    candidates, *_ = [of_dataset(each, dataset, gone) for each in both]
    files.writable(out)
    kept = chosen(candidates, wanted, other and other.losses(), reference.embeddings, shown)
    hold_as_scored(dataset, {each.name for each in kept}, both)
    for fault in gone.values():
        tell(f"left out: {fault}")
    told = record(dataset, out, wanted, reference.origin, other and other.origin, shown, way is not None)
    claim(out, dataset, told)
    files.sweep(out)
    if way is not None:
        materialise(dataset, out, kept, way, step)
    files.write(out / report.NAME, report.report(dataset, candidates, kept, told))
    write(out, dataset, kept)
    return Outcome(len(kept), len(candidates), len(gone))


def unreadable(dataset: Path, scored: Sequence[Scores]) -> dict[str, InputError]:
    """Images of a dataset that lack a score and cannot have one, by their pictures or labels.

    Parameters
    ----------
    dataset : Path
    scored : sequence of Scores
        An image lacks a score where one of them has none.

    Returns
    -------
    dict of str to InputError
        By name, what is wrong; in the order of the dataset, and none beyond the first that lacks a score and can be
        read, for which `of_dataset` refuses the scores: they may lack any number of images that nobody has scored yet.

    Raises
    ------
    InputError
        When the scores are of another dataset.
    """
    for each in scored:
        _hold_of(each, dataset)
    there = set.intersection(*({each.name for each in one.candidates} for one in scored))
    lacking = {name for name, _ in manifest(dataset) if name not in there}
    found: dict[str, InputError] = {}
    for example in examples_or_faults(dataset, only=lambda _, name: name in lacking) if lacking else ():
        try:
            if isinstance(example, Unlabelled):
                raise example.fault
            hold_labelled(example)
            picture(example)
        except InputError as error:
            found[example.name] = error
        else:
            break
    return found


def of_dataset(scores: Scores, dataset: Path, without: Container[str] = ()) -> list[Candidate]:
    """The scored images that a dataset lists, in its order.

    Parameters
    ----------
    scores : Scores
    dataset : Path
    without : container of str
        Names of images that are left out.

    Raises
    ------
    InputError
        When the scores are of another dataset, or it lists images that have none, or one twice.
    """
    _hold_of(scores, dataset)
    by_name = {each.name: each for each in scores.candidates}
    found: dict[str, Candidate] = {}
    lacking, first = 0, ""
    for name, _ in manifest(dataset):
        if name in found:
            raise InputError(dataset / MANIFEST, f"{name}: is listed twice: once is allowed")
        if name in without:
            continue
        if name in by_name:
            found[name] = by_name[name]
        else:
            lacking, first = lacking + 1, first or name
    if lacking:
        raise InputError(
            scores.folder,
            f"lacks {lacking} of the images of {dataset}, the first is {first}: pavemark score adds those it can read",
        )
    return list(found.values())


def hold_as_scored(dataset: Path, names: Container[str], scored: Iterable[Scores]) -> None:
    """Hold that images and their labels are what they were when they were scored.

    Only of those that are kept: to look at the labels of all would take as long as to score them.

    Parameters
    ----------
    dataset : Path
    names : container of str
        Of images that have scores.
    scored : iterable of Scores

    Raises
    ------
    InputError
        When one has changed or has gone.
    """
    known = [(each.folder, each.marks(names)) for each in scored]
    for example in examples(dataset, only=lambda _, name: name in names):
        now = mark(example)
        for folder, marks in known:
            if marks[example.name] != now:
                what = "it or its labels have changed since it was scored" if example.image.exists() else "has gone"
                raise InputError(example.image, f"{what}: pavemark score brings {folder} up to date")


def _seen(real: Scores, reference: Scores) -> np.ndarray:
    """What real images look like to the detector that scored the candidates."""
    if real.origin.model != reference.origin.model:
        theirs, ours = real.origin.model[:12], reference.origin.model[:12]
        raise InputError(
            real.folder, f"holds scores of the detector {theirs}: of {ours}, as {reference.folder}, are allowed"
        )
    return real.embeddings([each.name for each in real.candidates])


def _hold_of(scores: Scores, dataset: Path) -> None:
    if scores.origin.dataset != dataset_hash(dataset):
        raise InputError(scores.folder, f"holds scores of another dataset than {dataset}")


def record(
    dataset: Path,
    out: Path,
    wanted: Wanted,
    scored: Origin,
    learner: Origin | None,
    shown: np.ndarray | None,
    standalone: bool,
) -> dict[str, Any]:
    """What `selection.json` says.

    Parameters
    ----------
    dataset, out : Path
    wanted : Wanted
    scored, learner : Origin
        Of the scores, and of those of the detector that is to learn.
    shown : ndarray (R, E) or None
        Embeddings of real images.
    standalone : bool
        Whether the kept images with their labels are in the folder of the selection, too.
    """
    where = files.relative(source(dataset).absolute(), out.absolute())
    return {
        "dataset": "." if standalone else where,
        "source": where,
        "listed": files.relative(dataset.absolute(), out.absolute()),
        **attrs.asdict(wanted),
        "family": scored.family,
        "model": scored.model,
        "learner_family": learner and learner.family,
        "learner": learner and learner.model,
        # In whatever order they were scored.
        "real": None if shown is None else hashlib.sha256(b"".join(sorted(map(bytes, shown)))).hexdigest(),
        "pavemark": __version__,
    }


def claim(out: Path, dataset: Path, told: dict[str, Any]) -> None:
    """Hold that a folder is free for a selection, or holds this one, and write its `selection.json`.

    Parameters
    ----------
    out, dataset : Path
    told : dict
        What `record` says.

    Raises
    ------
    InputError
        When other files would be written over.
    """
    if out.absolute() in (dataset.absolute(), source(dataset).absolute()):
        raise InputError(out, "is the folder of the dataset: another folder is allowed")
    if out.exists() and not out.is_dir():
        raise InputError(out, "is a file: a folder is allowed")
    path = out / SELECTION
    if path.exists():
        there = read_json(path)
        before = there if isinstance(there, dict) else {}
        for field in sorted(told.keys() | before.keys()):
            if told.get(field) != before.get(field):
                what = f"{field} was {before.get(field)!r} and is {told.get(field)!r}"
                raise InputError(out, f"holds another selection: {what}; use another folder")
    elif out.exists() and any(not each.name.startswith(".") for each in out.iterdir()):
        raise InputError(out, f"has files and no {SELECTION} that tells of them: use another folder")
    files.write(path, json.dumps(told, indent=1, sort_keys=True) + "\n")


def write(out: Path, dataset: Path, kept: Sequence[Candidate]) -> None:
    """Write `manifest.jsonl`: the dataset's own lines of the images that are kept, in its order.

    To each are added its name, its loss and its rank, from 1, in the order of the strategy.

    Parameters
    ----------
    out, dataset : Path
    kept : sequence of Candidate
        The first to be kept first.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    ranks = {each.name: (rank, each.loss) for rank, each in enumerate(kept, 1)}

    def parts() -> Iterator[bytes]:
        for name, line in manifest(dataset):
            if name in ranks:
                rank, loss = ranks[name]
                told = line | {"name": name, "loss": loss, "rank": rank}
                yield json.dumps(told, separators=(",", ":"), allow_nan=False).encode() + b"\n"

    files.write_parts(out / MANIFEST, parts())
