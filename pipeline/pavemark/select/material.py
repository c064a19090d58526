"""The kept images with their labels in the folder of the selection, so that it is a dataset of its own."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Collection, Iterable
from pathlib import Path, PurePosixPath
from typing import Any

from pavemark import files
from pavemark.detect.reading import MANIFEST, manifest, source
from pavemark.errors import InputError
from pavemark.select.candidate import Candidate

WAYS = ("link", "copy")

_ALWAYS = ("labels/dmpr", "scenes")
"""What a dataset is read by, whatever its manifest lists."""


def materialise(dataset: Path, out: Path, kept: Iterable[Candidate], way: str, step: Callable[[], None]) -> None:
    """Put the files of images into a folder, and the record of the job that made them.

    A folder that holds a selection of the dataset before it grew loses the files of images that are no longer kept.

    Parameters
    ----------
    dataset : Path
        A dataset or a selection.
    out : Path
    kept : iterable of Candidate
        Images of it.
    way : str
        "link": hard links, where the file system has none of them symbolic ones, where it has neither copies.
        "copy": files that have nothing to do with those of the dataset.
    step : callable
        Called after each image.

    Raises
    ------
    InputError
        When a file of the dataset lacks, or one cannot be written.
    """
    put = _linked if way == "link" else _copied
    folder, names = source(dataset), {each.name for each in kept}
    _drop(out, names)
    # Read by programs that may write it anew as the dataset grows: never a link.
    _copied(folder / "job.json", out / "job.json")
    for image, line in manifest(dataset):
        if image in names:
            for name in _files(line):
                put(folder / name, out / name)
            step()


def _drop(out: Path, names: Collection[str]) -> None:
    """Remove the files of images that a folder lists and that are not among the names."""
    if not (out / MANIFEST).exists():
        return
    kept: set[str] = set()
    gone: set[str] = set()
    for image, line in manifest(out):
        (kept if image in names else gone).update(_files(line))
    try:
        for name in sorted(gone - kept):
            (out / name).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(out / name, f"cannot be removed: {error.strerror}") from None


def _files(line: dict[str, Any]) -> list[str]:
    """The files of an image, from the dataset's folder."""
    listed = {PurePosixPath(name) for name in line["files"]}
    # A list that leads out of its folder would lead out of ours.
    listed = {str(name) for name in listed if not name.is_absolute() and ".." not in name.parts}
    stem = PurePosixPath(next(name for name in listed if name.startswith("images/"))).stem
    return sorted(listed | {f"{folder}/{stem}.json" for folder in _ALWAYS})


def _copied(original: Path, target: Path) -> None:
    try:
        data = original.read_bytes()
    except OSError as error:
        raise InputError(original, f"cannot be read: {error.strerror}") from None
    files.write(target, data)


def _linked(original: Path, target: Path) -> None:
    if not original.is_file():
        raise InputError(original, "is not there: the dataset lacks a file of an image that is kept")
    if target.exists() and target.samefile(original):
        return
    part = files.aside(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        part.unlink(missing_ok=True)
        # A symbolic link in a dataset that is a selection itself is followed: what it leads to is what is meant.
        real = original.resolve()
        try:
            part.hardlink_to(real)
        except OSError:
            try:
                part.symlink_to(files.relative(real, target.parent.resolve()))
            except OSError:
                shutil.copyfile(real, part)
        part.replace(target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(target, f"cannot be written: {error.strerror}") from None
