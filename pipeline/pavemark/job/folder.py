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
from pavemark.job.config import PATHS, Inputs, Job
from pavemark.job.exactness import Exactness
from pavemark.records import read_json, structure


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
        """Images that a journal calls finished and that are whole, ascending."""
        there = journal.entries(self.out)
        return {number: there[number] for number in sorted(self.whole().intersection(there))}

    def whole(self) -> set[int]:
        """Images whose files are all there. One listing a folder: no file of an image is opened."""
        return set.intersection(*(_numbers(self.out / folder, suffix) for _, folder, suffix in self._kinds()))

    @property
    def folders(self) -> tuple[str, ...]:
        """Where files of images lie."""
        return tuple(folder for _, folder, _ in self._kinds())


_SUFFIXES = {"dmpr": ".json", "ps2": ".mat", "yolo": ".txt"}


def stems(folder: Path, suffix: str) -> set[str]:
    """The files of a folder that end so, without that end; none where there is no folder.

    Raises
    ------
    InputError
        When it cannot be listed.
    """
    if not folder.is_dir():
        return set()
    try:
        with os.scandir(folder) as listing:
            return {entry.name.removesuffix(suffix) for entry in listing if entry.name.endswith(suffix)}
    except OSError as error:
        raise InputError(folder, f"cannot be listed: {error.strerror}") from None


def _numbers(folder: Path, suffix: str) -> set[int]:
    return {int(name) for name in stems(folder, suffix) if name.isascii() and name.isdigit()}


def _holds_files(folder: Path) -> bool:
    return any(not name.startswith(".") for name in stems(folder, ""))


def sweep(out: Path, folders: Iterable[str]) -> None:
    """Remove what killed processes left half-written in a folder and in these of its own."""
    for folder in (".", *folders):
        files.sweep(out / folder)


def spare(out: Path, folders: tuple[str, ...], inputs: Iterable[str | None], record: str) -> None:
    """Hold that nothing but what such a run has written would be written over, its inputs least of all.

    Parameters
    ----------
    out : Path
        The output folder.
    folders : tuple of str
        Where files go in it.
    inputs : iterable of str or None
        Folders of the inputs, or an image alone.
    record : str
        The file that tells of the run.

    Raises
    ------
    InputError
        When files would go where the inputs are, or there are files already and no record tells of them.
    """
    if out.exists() and not out.is_dir():
        raise InputError(out, "is a file: a folder is allowed")
    used = {Path(folder).resolve() for folder in inputs if folder is not None}
    # An image alone lies among what would be written, and need not be there under its own name.
    around = {path.parent for path in used if path.is_file()}
    for folder in (".", *folders):
        there = (out / folder).resolve()
        if there in used or (folder in folders and there in around):
            raise InputError(out / folder, "is the folder of the inputs: another folder is allowed")
    # Listed first: another shard that starts now writes the record before its first image.
    taken = [folder for folder in folders if _holds_files(out / folder)]
    if taken and not (out / record).exists():
        raise InputError(out, f"has files in {', '.join(taken)} and no {record} that tells of them: use another folder")


def claim(out: Path, job: Job, inputs: Iterable[Entry], exact: Exactness | None = None) -> None:
    """Write OUT/job.json, or hold the job against the one that is there.

    The job is written as it is resolved. The inputs count by their names: their folders are kept for the preview,
    relative to OUT, and may be others the next time. The table of errors counts by what it says. The count may grow.

    Raises
    ------
    InputError
        When the folder holds another job; the differing fields are named.
    """
    path = out / RECORD
    told = _resolved(job, inputs) | relative(job, PATHS, out)
    if exact is None:
        del told["max_error"], told["calibration"]
    else:
        told["rays"] = {"versions": exact.table.versions, "sha256": exact.table.sha256}
    if path.exists():
        there = _read(path)
        hold_against(there, told, out, "job", {"count", *PATHS})
        if _digits(there["count"]) != _digits(job.count):
            raise InputError(out, f"count = {job.count}: at most {10 ** _digits(there['count'])} is allowed there")
        told["count"] = max(told["count"], there["count"])
        if told == there:
            return
    write_record(path, told)


def recorded(out: Path) -> Job:
    """The job that a folder holds.

    Raises
    ------
    InputError
        When it holds none.
    """
    told = _read(out / RECORD)
    paths = {name: os.path.normpath(out / told[name]) for name in PATHS if isinstance(told.get(name), str)}
    return structure(Job, {name: value for name, value in (told | paths).items() if name not in _BESIDE}, out / RECORD)


RECORD = "job.json"
_BESIDE = ("inputs", "pavemark", "rays")


def _resolved(job: Job, inputs: Iterable[Entry]) -> dict[str, Any]:
    fields = attrs.asdict(job) | {"scale": job.pixels_per_metre, "metres_per_pixel": None}
    names = [[entry.name, entry.mask is not None] for entry in inputs]
    fields["inputs"] = {"images": len(names), "sha256": hashlib.sha256(json.dumps(names).encode()).hexdigest()}
    fields["pavemark"] = __version__
    return json.loads(json.dumps(fields, allow_nan=False))


def relative(inputs: Inputs, names: Iterable[str], out: Path) -> dict[str, str | None]:
    """The folders that a job starts from, as they are to be found from its output folder."""
    folders = {name: getattr(inputs, name) for name in names}
    return {name: None if folder is None else files.relative(folder, out) for name, folder in folders.items()}


def hold_against(there: dict[str, Any], here: dict[str, Any], out: Path, what: str, free: set[str]) -> None:
    """Hold what is to be made against what a folder holds; fields that are free need only be given or not.

    Raises
    ------
    InputError
        When the folder holds another job, or `what` it is called; the differing fields are named.
    """
    before, now = _flat(there), _flat(here)
    differing = [
        f"{field} was {before.get(field)!r} and is {now.get(field)!r}"
        for field in sorted(before.keys() | now.keys())
        if before.get(field) != now.get(field) and (field not in free or None in (before.get(field), now.get(field)))
    ]
    if differing:
        more = f", and {len(differing) - 3} fields more" if len(differing) > 3 else ""
        raise InputError(out, f"holds another {what}: {', '.join(differing[:3])}{more}; use another folder")


def write_record(path: Path, told: dict[str, Any]) -> None:
    """Write the record of a folder."""
    files.write(path, json.dumps(told, indent=1, sort_keys=True) + "\n")


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
    data = read_json(path)
    if not isinstance(data, dict) or not isinstance(data.get("count"), int):
        raise InputError(path, "is not the record of a job")
    return data
