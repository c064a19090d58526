"""What is finished: one synced line an image or a plate, one journal a shard, one writer a journal."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import attrs
from filelock import FileLock, Timeout

from pavemark.errors import InputError

# JSON text holds no raw tab, so the columns can be told apart without parsing 300,000 lines.
_LINE = re.compile(rb'(\d+|".*")\t(\{.*\})\t(.*)\n')

MOST_OPEN = 128
"""Journals that are open at a time: a process may have 256 files on some systems."""

Key = int | str
"""The number of an image, or the name of a plate."""


@attrs.frozen
class Shard:
    """Part `part` of `parts`, counted from zero: every image whose index leaves that remainder."""

    part: int = 0
    parts: int = 1

    def numbers(self, count: int) -> range:
        """The images of the shard, of `count` in all."""
        return range(self.part, count, self.parts)


@attrs.frozen
class Entry:
    """Where the line of a finished image stands in the journals.

    Attributes
    ----------
    path : Path
    start, end : int
        Bytes of the line in the file.
    """

    path: Path
    start: int
    end: int

    def read(self) -> tuple[bytes, bytes]:
        """Its row of the manifest and what stands beside it, such as its part of coco.json, both as JSON text."""
        return next(lines([self]))


class Journal:
    """The journal of one shard, open for writing by one process at a time. Use it in a `with` statement.

    Raises
    ------
    InputError
        When it cannot be written, or another process is writing it.
    """

    def __init__(self, out: Path, shard: Shard) -> None:
        self._path = folder(out) / f"{shard.part}-of-{shard.parts}.jsonl"
        # A file of its own: what is locked on Windows cannot be read, and others read the journal meanwhile.
        self._lock = FileLock(self._path.with_suffix(".lock"))
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._lock.acquire(timeout=0)
        except Timeout:
            what = "to it" if shard.parts == 1 else f"part {shard.part}/{shard.parts} of it"
            raise InputError(out, f"another run is writing {what}") from None
        except OSError as error:
            raise InputError(out, f"cannot be written: {error.strerror}") from None
        try:
            self._file = self._path.open("a+b", buffering=0)  # closed where the journal is left
            self._drop_torn_line()
        except OSError as error:
            self._lock.release()
            raise InputError(out, f"cannot be written: {error.strerror}") from None

    def _drop_torn_line(self) -> None:
        if self._file.seek(0, os.SEEK_END):
            self._file.seek(-1, os.SEEK_END)
            if self._file.read(1) != b"\n":
                self._file.truncate(self._path.read_bytes().rfind(b"\n") + 1)

    def append(self, key: Key, row: dict[str, Any], beside: Any) -> None:
        """Add what is finished; it is on the disk when this returns.

        Parameters
        ----------
        key : int or str
            What is said of the same key later counts.
        row : dict
            Its row of the manifest.
        beside : Any
            What else is to be known of it, as plain data.

        Raises
        ------
        InputError
            When the disk is full.
        """
        columns = (json.dumps(part, allow_nan=False, separators=(",", ":")) for part in (key, row, beside))
        data = ("\t".join(columns) + "\n").encode()
        try:
            while data:
                data = data[self._file.write(data) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            raise InputError(self._path, f"cannot be written: {error.strerror}") from None

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()
        self._lock.release()


def folder(out: Path) -> Path:
    """Where the journals of an output folder lie."""
    return out / "journal"


def entries(out: Path) -> dict[Key, Entry]:
    """All that some journal calls finished, by key."""
    return {json.loads(match[1]): entry for entry, match in _lines(out)}


def beside(out: Path) -> dict[Key, Any]:
    """What stands beside the row of all that some journal calls finished, by key."""
    return {json.loads(match[1]): json.loads(match[3]) for _, match in _lines(out)}


def lines(finished: Iterable[Entry]) -> Iterator[tuple[bytes, bytes]]:
    """What `Entry.read` gives of each, every journal opened once: on a network drive that is what takes the time."""
    with ExitStack() as opened:
        streams: dict[Path, BinaryIO] = {}
        for entry in finished:
            if entry.path not in streams:
                if len(streams) == MOST_OPEN:
                    opened.close()
                    streams.clear()
                streams[entry.path] = opened.enter_context(entry.path.open("rb"))
            stream = streams[entry.path]
            stream.seek(entry.start)
            match = _LINE.fullmatch(stream.read(entry.end - entry.start))
            yield match[2], match[3]


def _lines(out: Path) -> Iterator[tuple[Entry, re.Match[bytes]]]:
    for path in _journals(out):
        with path.open("rb") as stream:
            start = 0
            for line in stream:
                # The last line of a journal is torn where its writer was killed, or is being written just now.
                if match := _LINE.fullmatch(line):
                    yield Entry(path, start, start + len(line)), match
                start += len(line)


def versions(out: Path) -> list[dict[str, str]]:
    """What made the first image of each journal."""
    found = []
    for path in _journals(out):
        with path.open("rb") as stream:
            if match := _LINE.fullmatch(stream.readline()):
                found.append(json.loads(match[2])["versions"])
    return found


def plates(finished: Iterable[Entry]) -> dict[str, str]:
    """The hash of the plate that each input gave, by the input's name."""
    rows = (json.loads(row) for row, _ in lines(finished))
    return {row["input"]: row["plate"] for row in rows}


def newest(out: Path) -> int:
    """When a journal was last written, in the file system's nanoseconds."""
    return max((path.stat().st_mtime_ns for path in _journals(out)), default=0)


def _journals(out: Path) -> list[Path]:
    return sorted(folder(out).glob("*.jsonl"))


@contextmanager
def merging(out: Path) -> Iterator[None]:
    """One process at a time joins the journals, so that the last one to finish has read all."""
    with FileLock(folder(out) / "merging"):
        yield
