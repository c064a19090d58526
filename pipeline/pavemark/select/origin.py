"""What a dataset is, and what an image of it was when it was scored: hashes that no folder's name goes into."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path

import numpy as np

from pavemark.detect.example import Example
from pavemark.detect.reading import LISTED, SELECTION, lines, source
from pavemark.errors import InputError
from pavemark.records import read_json

GROWS = {"count", "images", "masks", "plates", "calibration"}
"""What may differ in the record of one job: how many images it has, and where its inputs lie."""


def dataset_hash(dataset: Path) -> str:
    """What a dataset is: the job that made it, or the first image of a list, its name and its picture.

    A selection is of its dataset. The labels of a list may be corrected, as those of a job's images may: `mark` knows.

    Raises
    ------
    InputError
        When it has no such file.
    """
    folder = source(dataset)
    if (folder / "job.json").exists():
        told = read_json(folder / "job.json")
        if not isinstance(told, dict):
            raise InputError(folder / "job.json", "is not the record of a job")
        return _hash(json.dumps({name: told[name] for name in told if name not in GROWS}, sort_keys=True).encode())
    if not (folder / LISTED).exists():
        raise InputError(folder, "is no dataset: a folder that pavemark render or select wrote is allowed")
    first = next(lines(folder / LISTED), (1, {}))[1].get("image")
    # Many a list begins with 000000.png.
    seen = b""
    if isinstance(first, str):
        with contextlib.suppress(OSError, ValueError):  # what cannot be read is told when it is scored
            seen = (folder / first).read_bytes()
    return _hash(json.dumps([first, _hash(seen)]).encode())


def selection_hash(dataset: Path) -> str:
    """Which images of its dataset a selection has; empty for a dataset."""
    path = dataset / SELECTION
    return _hash(_read(path)) if path.exists() else ""


def mark(example: Example) -> bytes:
    """Of the labels that an image is scored against, what it is sorted by, and the size of its file: 16 bytes."""
    # A name that is not UTF-8 is none to those who read pictures: they tell.
    told = hashlib.sha256(f"{example.name}\n{example.frame}\n".encode(errors="surrogatepass"))
    told.update(np.ascontiguousarray(example.points, "<f8").tobytes())
    told.update(json.dumps(example.groups, sort_keys=True).encode())
    with contextlib.suppress(OSError):  # what cannot be read is told when it is scored
        told.update(str(example.image.stat().st_size).encode())
    return told.digest()[:16]


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
