"""The output folder: which files an image has, which images are there, and whose job it holds."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs

from pavemark import __version__, files
from pavemark.background.index import Entry
from pavemark.errors import InputError
from pavemark.job import journal
from pavemark.job.config import Job
from pavemark.records import structure


@attrs.frozen
class Folder:
    """Where the files of a job lie.

    Attributes
    ----------
    out : Path
    formats : tuple of str
        Label formats of the job.
    digits : int
        Of an image's number in file names.
    """

    out: Path
    formats: tuple[str, ...]
    digits: int

    @classmethod
    def of(cls, out: Path, job: Job) -> Folder:
        """The folder of a job: six digits, or as many as its count needs."""
        return cls(out, job.formats, _digits(job.count))

    def paths(self, index: int) -> dict[str, Path]:
        """Every file that image `index` has, by what it holds."""
        name = f"{index:0{self.digits}d}"
        return {what: self.out / folder / f"{name}{suffix}" for what, folder, suffix in self._kinds()}

    def _kinds(self) -> list[tuple[str, str, str]]:
        kinds = [("image", "images", ".png"), ("mask", "masks", ".png"), ("slots", "slots", ".png")]
        kinds += [(name, f"labels/{name}", suffix) for name, suffix in _SUFFIXES.items() if name in self.formats]
        return [*kinds, ("scene", "scenes", ".json")]

    def finished(self) -> dict[int, journal.Entry]:
        """Images that a journal calls finished and whose files are all there, ascending.

        One listing a folder: no file of an image is opened.
        """
        there = journal.entries(self.out)
        done = set(there).intersection(*(_numbers(self.out / folder, suffix) for _, folder, suffix in self._kinds()))
        return {number: there[number] for number in sorted(done)}

    def taken(self) -> list[str]:
        """The folders in which there are files, whosever they are."""
        return [folder for _, folder, _ in self._kinds() if _holds_files(self.out / folder)]

    def sweep(self) -> None:
        """Remove what killed processes left half-written."""
        for folder in (".", *(folder for _, folder, _ in self._kinds())):
            files.sweep(self.out / folder)


_SUFFIXES = {"dmpr": ".json", "ps2": ".mat", "yolo": ".txt"}


def _holds_files(folder: Path) -> bool:
    if not folder.is_dir():
        return False
    with os.scandir(folder) as listing:
        return any(not entry.name.startswith(".") for entry in listing)


def _numbers(folder: Path, suffix: str) -> set[int]:
    if not folder.is_dir():
        return set()
    with os.scandir(folder) as listing:
        names = [entry.name.removesuffix(suffix) for entry in listing if entry.name.endswith(suffix)]
    return {int(name) for name in names if name.isascii() and name.isdigit()}


def spare(folder: Folder, job: Job) -> None:
    """Hold that nothing but images of a job would be written over, the inputs least of all.

    Raises
    ------
    InputError
        When the folder is that of the inputs, or has no job.json and yet files where images of a job would go.
    """
    out = folder.out
    if out.resolve() in {Path(inputs).resolve() for inputs in (job.images, job.masks) if inputs is not None}:
        raise InputError(out, "is the folder of the inputs: another folder is allowed")
    # Listed first: another shard that starts now writes job.json before its first image.
    taken = folder.taken()
    if taken and not (out / RECORD).exists():
        raise InputError(out, f"has files in {', '.join(taken)} and no {RECORD} that tells of them: use another folder")


def claim(out: Path, job: Job, inputs: Iterable[Entry]) -> None:
    """Write OUT/job.json, or hold the job against the one that is there.

    The job is written as it is resolved. The inputs count by their names: their folders are kept for the preview,
    relative to OUT, and may be others the next time. The count may grow.

    Raises
    ------
    InputError
        When the folder holds another job; the differing fields are named.
    """
    path = out / RECORD
    told = _resolved(job, inputs) | {name: _relative(getattr(job, name), out) for name in _FOLDERS}
    if path.exists():
        there = _read(path)
        _hold_against(there, told, out)
        told["count"] = max(told["count"], there["count"])
        if told == there:
            return
    files.write(path, json.dumps(told, indent=1, sort_keys=True) + "\n")


def recorded(out: Path) -> Job:
    """The job that a folder holds.

    Raises
    ------
    InputError
        When it holds none.
    """
    told = _read(out / RECORD)
    folders = {name: os.path.normpath(out / told[name]) for name in _FOLDERS if isinstance(told.get(name), str)}
    return structure(
        Job, {name: value for name, value in (told | folders).items() if name not in _BESIDE}, out / RECORD
    )


RECORD = "job.json"
_FOLDERS = ("images", "masks")
_BESIDE = ("inputs", "pavemark")


def _resolved(job: Job, inputs: Iterable[Entry]) -> dict[str, Any]:
    fields = attrs.asdict(job) | {"scale": job.pixels_per_metre, "metres_per_pixel": None}
    names = [[entry.name, entry.mask is not None] for entry in inputs]
    fields["inputs"] = {"images": len(names), "sha256": hashlib.sha256(json.dumps(names).encode()).hexdigest()}
    fields["pavemark"] = __version__
    return json.loads(json.dumps(fields, allow_nan=False))


def _relative(folder: str | None, out: Path) -> str | None:
    return None if folder is None else Path(os.path.relpath(folder, out)).as_posix()


def _hold_against(there: dict[str, Any], here: dict[str, Any], out: Path) -> None:
    free = {"count", *_FOLDERS}
    before, now = _flat(there), _flat(here)
    differing = [
        f"{field} was {before.get(field)!r} and is {now.get(field)!r}"
        for field in sorted((before.keys() | now.keys()) - free)
        if before.get(field) != now.get(field)
    ]
    if differing:
        more = f", and {len(differing) - 3} fields more" if len(differing) > 3 else ""
        raise InputError(out, f"holds another job: {', '.join(differing[:3])}{more}; use another folder")
    if _digits(there["count"]) != _digits(here["count"]):
        raise InputError(out, f"count = {here['count']}: at most {10 ** _digits(there['count'])} is allowed there")


def _digits(count: int) -> int:
    return max(6, len(str(count - 1)))


def _flat(data: dict[str, Any], above: str = "") -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for name, value in data.items():
        if isinstance(value, dict):
            fields |= _flat(value, f"{above}{name}.")
        else:
            fields[f"{above}{name}"] = value
    return fields


def _read(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"not a JSON file: {error}") from None
    if not isinstance(data, dict) or not isinstance(data.get("count"), int):
        raise InputError(path, "is not the record of a job")
    return data
