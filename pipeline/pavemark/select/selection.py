"""Which images of a dataset are kept, and the folder that tells it."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark import __version__, files
from pavemark.detect.reading import MANIFEST, SELECTION, manifest, source
from pavemark.errors import InputError
from pavemark.records import read_json, within
from pavemark.select import modifiers, strategies
from pavemark.select.near_duplicates import distinct
from pavemark.select.origin import dataset_hash
from pavemark.select.scores import Candidate, Scores
from pavemark.select.shards import Origin

STRATEGIES = ("cfds", "ehds", "random", "coverage", "learnable")


@attrs.frozen
class Wanted:
    """What is asked for.

    Attributes
    ----------
    strategy : str
        One of `STRATEGIES`, each a function of `pavemark.select.strategies`.
    keep : int
        Images.
    seed : int
        What is random in "random" and "coverage" follows from it.
    quantiles : int
        Of the loss, for "coverage".
    learnable : float
        Quantile of the reference's loss beyond which "learnable" keeps nothing.
    drop_hardest : float
        Share of all images, those of most loss, that are not kept whatever the strategy.
    near_duplicates : float or None
        Cosine distance of embeddings below which only the first in the strategy's order is kept.
    cap_per_plate : int or None
        Most images of a plate.
    """

    strategy: str = attrs.field(validator=attrs.validators.in_(STRATEGIES))
    keep: int = attrs.field(validator=attrs.validators.ge(1))
    seed: int = 0
    quantiles: int = attrs.field(default=4, validator=attrs.validators.ge(1))
    learnable: float = attrs.field(default=0.75, validator=within(0, 1))
    drop_hardest: float = attrs.field(default=0.0, validator=within(0, 1))
    near_duplicates: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(0, 2)))
    cap_per_plate: int | None = attrs.field(default=None, validator=attrs.validators.optional(attrs.validators.ge(1)))


def chosen(
    candidates: Sequence[Candidate],
    wanted: Wanted,
    learner: dict[str, float] | None = None,
    embeddings: Callable[[Sequence[str]], np.ndarray] | None = None,
) -> list[Candidate]:
    """The images that are kept, the first to be kept first.

    The hardest are dropped, the strategy orders the rest, and along its order near-duplicates go and plates are
    capped. What is left is dealt anew by "coverage", which is to be even whatever went; then the first are kept.

    Parameters
    ----------
    candidates : sequence of Candidate
        In any order.
    wanted : Wanted
    learner : dict of str to float or None
        Losses under the detector that is to learn, by name: "learnable" needs them.
    embeddings : callable or None
        From names to an array (N, E) float32; `near_duplicates` needs it.

    Raises
    ------
    InputError
        When fewer images are left than are to be kept, or the strategy cannot order them.
    """
    left = modifiers.without_hardest(candidates, wanted.drop_hardest)
    order = _ordered(left, wanted, learner)
    walk: Iterable[Candidate] = order
    if wanted.near_duplicates is not None:
        walk = distinct(order, embeddings([each.name for each in order]), wanted.near_duplicates)
    if wanted.cap_per_plate is not None:
        walk = modifiers.capped(walk, wanted.cap_per_plate)
    if wanted.strategy == "coverage" and walk is not order:
        walk = _ordered(list(walk), wanted, learner)
    kept = list(itertools.islice(walk, wanted.keep))
    if len(kept) < wanted.keep:
        raise InputError("--keep", f"{wanted.keep}: there are {len(kept)} of {len(candidates)} images to keep")
    return kept


def _ordered(candidates: Sequence[Candidate], wanted: Wanted, learner: dict[str, float] | None) -> list[Candidate]:
    orders = {
        "cfds": lambda: strategies.cfds(candidates),
        "ehds": lambda: strategies.ehds(candidates),
        "random": lambda: strategies.random(candidates, wanted.seed),
        "coverage": lambda: strategies.coverage(candidates, wanted.seed, wanted.quantiles),
        "learnable": lambda: strategies.learnable(candidates, learner or {}, wanted.learnable),
    }
    return orders[wanted.strategy]() if candidates else []


def of_dataset(scores: Scores, dataset: Path) -> list[Candidate]:
    """The scored images that a dataset lists, in its order.

    Raises
    ------
    InputError
        When the scores are of another dataset, or it lists images that have none, or one twice.
    """
    if scores.origin.dataset != dataset_hash(dataset):
        raise InputError(scores.folder, f"holds scores of another dataset than {dataset}")
    by_name = {each.name: each for each in scores.candidates}
    found: dict[str, Candidate] = {}
    lacking, first = 0, ""
    for name, _ in manifest(dataset):
        if name in found:
            raise InputError(dataset / MANIFEST, f"{name}: is listed twice: once is allowed")
        if name in by_name:
            found[name] = by_name[name]
        else:
            lacking, first = lacking + 1, first or name
    if lacking:
        raise InputError(scores.folder, f"lacks {lacking} of the images of {dataset}, the first is {first}")
    return list(found.values())


def record(
    dataset: Path, out: Path, wanted: Wanted, scored: Origin, learner: Origin | None, standalone: bool
) -> dict[str, Any]:
    """What `selection.json` says.

    Parameters
    ----------
    dataset, out : Path
    wanted : Wanted
    scored, learner : Origin
        Of the scores, and of those of the detector that is to learn.
    standalone : bool
        Whether the kept images with their labels are in the folder of the selection, too.
    """
    where = Path(os.path.relpath(source(dataset).absolute(), out.absolute())).as_posix()
    return {
        "dataset": "." if standalone else where,
        "source": where,
        "listed": Path(os.path.relpath(dataset.absolute(), out.absolute())).as_posix(),
        **attrs.asdict(wanted),
        "family": scored.family,
        "model": scored.model,
        "learner_family": learner and learner.family,
        "learner": learner and learner.model,
        "pavemark": __version__,
    }


def claim(out: Path, dataset: Path, told: dict[str, Any]) -> None:
    """Hold that a folder is free for a selection, or holds this one, and write its `selection.json`.

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
        if there != told:
            before = there if isinstance(there, dict) else {}
            field = next(name for name in sorted(told.keys() | before.keys()) if told.get(name) != before.get(name))
            what = f"{field} was {before.get(field)!r} and is {told.get(field)!r}"
            raise InputError(out, f"holds another selection: {what}; use another folder")
    elif out.exists() and any(not each.name.startswith(".") for each in out.iterdir()):
        raise InputError(out, f"has files and no {SELECTION} that tells of them: use another folder")
    files.write(path, json.dumps(told, indent=1, sort_keys=True) + "\n")


def write(out: Path, dataset: Path, kept: Sequence[Candidate]) -> None:
    """Write `manifest.jsonl`: the dataset's own lines of the images that are kept, in its order.

    To each are added its name, its loss and its rank, from 1, in the order of the strategy.
    """
    ranks = {each.name: (rank, each.loss) for rank, each in enumerate(kept, 1)}

    def parts() -> Iterator[bytes]:
        for name, line in manifest(dataset):
            if name in ranks:
                rank, loss = ranks[name]
                told = line | {"name": name, "loss": loss, "rank": rank}
                yield json.dumps(told, separators=(",", ":"), allow_nan=False).encode() + b"\n"

    files.write_parts(out / MANIFEST, parts())
