"""A file is there whole or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import os
import socket
import tempfile
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from pavemark import system
from pavemark.errors import InputError

_HOST = socket.gethostname().replace(".", "-")


def write(path: Path, data: bytes | str) -> None:
    """Write a file aside, sync it and rename it into place.

    Parameters
    ----------
    path : Path
        Its folder is made where it lacks.
    data : bytes or str
        Text is written as UTF-8.

    Raises
    ------
    InputError
        When the folder or the file cannot be written, or the disk is full; nothing is left behind.
    """
    write_parts(path, [data.encode() if isinstance(data, str) else data])


def write_parts(path: Path, parts: Iterable[bytes]) -> None:
    """As `write`, for a file that need not fit in memory: its parts follow each other."""
    path = Path(path)
    part = aside(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("wb") as stream:
                stream.writelines(parts)
                stream.flush()
                os.fsync(stream.fileno())
            system.replace(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}") from None


def writable(folder: Path) -> None:
    """Hold that files can be written into a folder, which need not be there yet: asked before long work.

    Raises
    ------
    InputError
        When they cannot.
    """
    there = next((path for path in (folder.absolute(), *folder.absolute().parents) if path.exists()), None)
    if there is None:
        raise InputError(folder, "cannot be written: there is no such drive")
    try:
        # Only to try tells: permissions are not all that can be in the way.
        tempfile.TemporaryDirectory(dir=there).cleanup()
    except OSError as error:
        raise InputError(folder, f"cannot be written: {there}: {error.strerror}") from None


LONG = 100
"""Bytes of a name beyond which what is written aside is called by its hash: a file system takes 255 with all of it."""


def aside(path: Path) -> Path:
    """Where this process writes what is to become `path`, or to be read back once and removed."""
    # Host and process: shards on several machines, containers above all, share process ids and write into one folder.
    name = path.name
    if len(os.fsencode(name)) > LONG:
        name = hashlib.sha256(os.fsencode(name)).hexdigest()[:32]
    return path.with_name(f".{name}.{_HOST}.{os.getpid()}.part")


def sweep(folder: Path) -> None:
    """Remove from a folder what writers of this host left aside when they were killed."""
    for part in Path(folder).glob(f".*.{_HOST}.*.part"):
        if not system.alive(int(part.name.split(".")[-2])):
            with contextlib.suppress(PermissionError):  # in a folder for all, another user's
                part.unlink(missing_ok=True)


def relative(path: str | Path, start: Path) -> str:
    """A path as it is to be found from a folder: what a record says, with / on every system.

    On Windows none leads from one drive to another: it is absolute there.
    """
    try:
        return Path(os.path.relpath(path, start)).as_posix()
    except ValueError:
        return Path(path).absolute().as_posix()


def png(image: np.ndarray) -> bytes:
    """A PNG of an (H, W, 3) RGB array of uint8, or of an (H, W) mask of uint8 or uint16."""
    # Pictures with noise do not repeat: Huffman codes alone are half the time of a search, and 5 % smaller too.
    # Masks are runs.
    strategy = cv2.IMWRITE_PNG_STRATEGY_RLE
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
        strategy = cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY
    settings = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, strategy]
    return cv2.imencode(".png", image, settings)[1].tobytes()
