"""Training runs: each is one detector, kept under the hash of all that it depends on."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Iterable, Sequence
from functools import cache, lru_cache
from pathlib import Path

import attrs
import numpy as np

from pavemark import files
from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.select.scoring import versions
from pavemark.study.design import Training

CODE = (
    "training/detectors/*.py",
    "study/lessons.py",
    "detect/scaling.py",
    "detect/reading.py",
    "background/reading.py",
)
"""Modules of the package that a detector depends on."""


@attrs.frozen
class Run:
    """One detector to be trained.

    Attributes
    ----------
    examples : tuple of Example
        What it learns from.
    steps, seed : int
    training : Training
    scale : float
        Pixels per metre at which it looks.
    start : Run or None
        The run whose weights it begins with.
    """

    examples: tuple[Example, ...] = attrs.field(eq=False, repr=False)
    steps: int
    seed: int
    training: Training
    scale: float
    start: Run | None = None

    def key(self) -> str:
        """Hash of all that the detector depends on: pictures, labels, settings, code and the version of torch.

        Raises
        ------
        InputError
            When torch is missing, or a picture cannot be read.
        """
        told = {
            "torch": _torch(),
            **versions(),
            "examples": [content(example) for example in self.examples],
            "steps": self.steps,
            "seed": self.seed,
            "family": self.training.family,
            "batch": self.training.batch,
            "scale": self.scale,
            "start": None if self.start is None else self.start.key(),
            "code": _code(),
        }
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:32]


def model(run: Run, folder: Path) -> Path:
    """Where the detector of a run lies."""
    return _path(run.key(), folder)


def train(run: Run, folder: Path, key: str | None = None) -> Path:
    """Train the detector of a run, unless it is there, and those that it starts from.

    Parameters
    ----------
    run : Run
    folder : Path
        Of the study.
    key : str or None
        Of the run, where it is known: else every picture is read for it.

    Returns
    -------
    Path
        The model, ONNX; its weights lie beside it.

    Raises
    ------
    InputError
        When torch is missing, or a picture cannot be read.
    """
    path = _path(key or run.key(), folder)
    weights = path.with_suffix(".pt")
    if path.exists() and weights.exists():
        return path
    start = None if run.start is None else train(run.start, folder).with_suffix(".pt")
    try:
        # torch takes seconds to load, and only who trains has it.
        from pavemark.study.lessons import learnt  # noqa: PLC0415
    except ImportError as error:
        raise InputError("study", f"{error.name} is missing: pip install 'pavemark[train]'") from None
    begun = None if start is None else start.read_bytes()
    state = path.with_suffix(".state")
    exported, kept = learnt(run, begun, state)
    files.write(weights, kept)
    files.write(path, exported)
    state.unlink(missing_ok=True)
    return path


def _path(key: str, folder: Path) -> Path:
    return folder / "models" / f"{key}.onnx"


def digest(examples: Iterable[Example]) -> str:
    """Hash of names, pictures, labels and places: what was judged by others has another."""
    told = [[example.name, *content(example), example.groups] for example in examples]
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:32]


def content(example: Example) -> list:
    """What an example is, as JSON may hold it: the hash of its picture, and its labels."""
    labels = [None if each is None else np.asarray(each).tolist() for each in (example.points, example.directions)]
    shapes = [None if each is None else np.asarray(each).tolist() for each in (example.l_shaped, example.slots)]
    return [picture_hash(example.image), example.frame.scale, *labels, *shapes]


@cache
def picture_hash(image: Path) -> str:
    """SHA-256 of the file of a picture, read once.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    try:
        return hashlib.sha256(image.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(image, f"cannot be read: {error.strerror}") from None


def _torch() -> str:
    try:
        return importlib.metadata.version("torch")
    except importlib.metadata.PackageNotFoundError:
        raise InputError("study", "torch is missing: pip install 'pavemark[train]'") from None


@lru_cache(maxsize=1)
def _code() -> str:
    """Hash of the modules that say how a detector is trained, and how what it learns from is read."""
    package = Path(__file__).parents[1]
    told = hashlib.sha256()
    for module in sorted(module for where in CODE for module in package.glob(where)):
        told.update(module.read_bytes())
    return told.hexdigest()


def chosen_by_parts(examples: Sequence[Example], parts: int, seed: int) -> list[tuple[Example, ...]]:
    """The examples in equal parts, drawn from a seed."""
    order = np.random.Generator(np.random.PCG64(seed)).permutation(len(examples))
    return [tuple(examples[number] for number in sorted(order[part::parts].tolist())) for part in range(parts)]
