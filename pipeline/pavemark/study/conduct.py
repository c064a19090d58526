"""Conducting a study: whatever it still lacks is made, a row after the other, and the tables are written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import attrs
import numpy as np

from pavemark import files
from pavemark.detect.example import Example
from pavemark.detect.learned import opened
from pavemark.detect.reading import picture
from pavemark.errors import InputError
from pavemark.evaluate.ensembles import VOTES
from pavemark.job.progress import shown
from pavemark.records import read_json
from pavemark.select import scores as scored
from pavemark.select.choice import LIKE_REAL
from pavemark.select.scores import Scores
from pavemark.select.scoring import score, versions
from pavemark.study import pools, runs
from pavemark.study.design import ALL, Row, Study
from pavemark.study.judging import JUDGED, Verdict, hold_judgeable, judge, judged_by
from pavemark.study.leakage import hold_apart
from pavemark.study.places import split
from pavemark.study.rows import Data, real, synthetic
from pavemark.study.runs import Run
from pavemark.study.training import Tell, train_all


@attrs.frozen(eq=False)
class Trial:
    """A row at one seed: the detectors to be trained for it, and how many images they learn from.

    Attributes
    ----------
    row : Row
    seed : int
    runs : tuple of Run
        One, or one a part.
    real, synthetic : int
        Images of each kind.
    """

    row: Row
    seed: int
    runs: tuple[Run, ...]
    real: int
    synthetic: int


def conduct(study: Study, folder: Path, workers: int, tell: Tell, only_told: bool = False) -> list[Verdict]:
    """Make what a study still lacks.

    Parameters
    ----------
    study : Study
    folder : Path
        Where plates, pools, models, scores and results are kept: results under the hash of all they depend on.
    workers : int
        Processes that train, each with one thread, so that a detector does not depend on their number.
    tell : callable
        Told a line now and then.
    only_told : bool
        Whether rows whose detectors are there are told, no other is trained, and no image is made.

    Returns
    -------
    list of Verdict
        In the order of the rows, each row's seeds in their order.

    Raises
    ------
    InputError
        When something is missing, or of no use.
    """
    parts = split(study)
    if not only_told:  # long work is before it
        hold_apart(parts)
        hold_judgeable({part: parts[part] for part in JUDGED})
        _hold_shares(study, len(parts["train"]))
        _hold_parts(study, len(parts["train"]))
    made = pools.there(study, folder) if only_told else pools.make(study, parts["train"], folder, workers)
    data = Data(
        tuple(parts["train"]),
        {pool: tuple(pools.learnt_from(path, parts["train"])) for pool, path in made.items()},
    )
    if not only_told:
        _hold_parts(study, len(parts["train"]), {pool: len(images) for pool, images in data.pools.items()})
    first = next(row for row in study.rows if row.name == study.judge)
    trial = trials(study, [first], data)[0]
    if only_told and not _trained(trial, folder):
        raise InputError(folder, f"has no detector of {study.judge!r}, which judges: without --told it is trained")
    _train([trial], folder, workers, tell)
    wanted = sorted({pool for row in study.rows if row.strategy != ALL for pool in row.pools})
    data = attrs.evolve(data, scores=_scores(wanted, made, trial, folder, workers, tell))
    rows = study.rows
    if any(row.strategy == LIKE_REAL for row in study.rows):
        data = attrs.evolve(data, seen=_seen(data.real, runs.model(trial.runs[0], folder)))
    learning = {row.learner: trials(study, [row.learner], data)[0] for row in rows if row.learner}
    if only_told:
        learning = {learner: trial for learner, trial in learning.items() if _trained(trial, folder)}
        rows = [row for row in rows if row.learner is None or row.learner in learning]
    _train([*learning.values()], folder, workers, tell)
    scores = {
        learner: _scores(learner.pools, made, trial, folder, workers, tell) for learner, trial in learning.items()
    }
    data = attrs.evolve(data, learners=scores)
    wanted_trials = trials(study, rows, data)
    if only_told:
        wanted_trials = [trial for trial in wanted_trials if _trained(trial, folder)]
    _train(wanted_trials, folder, workers, tell)
    return [verdict for trial in wanted_trials for verdict in _verdicts(study, trial, parts, folder)]


def trials(study: Study, rows: Iterable[Row], data: Data) -> list[Trial]:
    """The detectors of rows, with what each learns from."""
    return [_trial(study, row, seed, data) for row in rows for seed in row.seeds]


def _trial(study: Study, row: Row, seed: int, data: Data) -> Trial:
    real_ones, drawn = real(row, data, seed), synthetic(row, data, seed)
    training = study.training

    def run(examples: Sequence[Example], steps: int, start: Run | None = None) -> Run:
        return Run(tuple(examples), steps, seed, training, study.scale, start)

    if row.fine_tune:
        made = (run(real_ones, training.fine_tune_steps, run(drawn, training.steps)),)
    elif row.parts > 1:
        made = tuple(run(part, training.steps) for part in runs.chosen_by_parts([*real_ones, *drawn], row.parts, seed))
    else:
        made = (run([*real_ones, *drawn], training.steps),)
    return Trial(row, seed, made, len(real_ones), len(drawn))


def _hold_shares(study: Study, real: int) -> None:
    """Hold that rows of a share of the real images have one at least."""
    for row in study.rows:
        if row.real and not round(row.real * real):
            raise InputError(
                f"rows: {row.name}", f"real = {row.real:g}: is no image of {real}: {1 / real:g} and more are allowed"
            )


def _hold_parts(study: Study, real: int, images: Mapping[str, int] | None = None) -> None:
    """Hold that each part of a row has an image; of rows that keep whole pools as soon as those are there."""
    for row in study.rows:
        whole = row.pools if row.keep is None else ()
        if whole and images is None:
            continue
        many = (row.keep or 0) + sum(images[pool] for pool in whole) + round(row.real * real)
        if many < row.parts:
            raise InputError(f"rows: {row.name}", f"parts = {row.parts}: up to {many}, its images, are allowed")


def _trained(trial: Trial, folder: Path) -> bool:
    return all(runs.model(run, folder).exists() for run in trial.runs)


def _train(wanted: Sequence[Trial], folder: Path, workers: int, tell: Tell) -> None:
    """Train what lacks."""
    of_each = [(f"{trial.row.name}, seed {trial.seed}", run) for trial in wanted for run in trial.runs]
    train_all(of_each, folder, workers, tell)


def _scores(
    wanted: Sequence[str], made: dict[str, Path], trial: Trial, folder: Path, workers: int, tell: Tell
) -> dict[str, Scores]:
    """Of each pool, by the detector of a row."""
    found, model = {}, runs.model(trial.runs[0], folder)
    by = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode()).hexdigest()[:8]
    for pool in wanted:
        out = folder / "scores" / f"{model.stem}-{by}" / pool
        tell(f"scores of {pool}")
        score(made[pool], lambda: opened(model), out, shown(True), workers)
        found[pool] = scored.read(out)
    return found


def _seen(real: Sequence[Example], model: Path) -> np.ndarray:
    """What real images look like to a detector."""
    detector = opened(model)
    return np.array([detector.embedding(picture(example), example.frame) for example in real], np.float32)


def _verdicts(study: Study, trial: Trial, parts: dict[str, list[Example]], folder: Path) -> list[Verdict]:
    models = [runs.model(run, folder) for run in trial.runs]
    votes = [None] if len(models) == 1 else list(VOTES)
    path = folder / "results" / f"{judged_by(models, parts, study.tolerance)}.json"
    there = read_json(path) if path.exists() else {}
    verdicts = []
    for vote in votes:
        name = vote or "alone"
        if name not in there:
            there[name] = judge([opened(model) for model in models], vote, parts, study.tolerance)
            files.write(path, json.dumps(there, sort_keys=True) + "\n")
        called = trial.row.name if vote is None else f"{trial.row.name}, {vote}"
        verdicts.append(Verdict(called, trial.row, trial.seed, trial.real, trial.synthetic, there[name]))
    return verdicts
