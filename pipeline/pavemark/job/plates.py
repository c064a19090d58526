"""A run that makes plates: a folder of images in, a folder of plates out, to be looked at and mended before use."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark import __version__, files
from pavemark.background import cache
from pavemark.background.index import Entry
from pavemark.background.reading import read_image
from pavemark.background.stock import FOLDERS, RECORD, ROWS, Row, begun, halves, paths, stock
from pavemark.colour import quantise
from pavemark.errors import InputError
from pavemark.job import journal
from pavemark.job.config import Inputs
from pavemark.job.contact_sheet import drawn, scaled, spread
from pavemark.job.crew import Answer, Crew, Task
from pavemark.job.folder import hold_against, relative, spare, stems, sweep, write_record
from pavemark.job.inputs import entries, makers
from pavemark.job.journal import Journal, Shard
from pavemark.job.plate_worker import sha256, stamp
from pavemark.job.progress import Progress
from pavemark.job.run import LOG, SOME_LACK, Machine, log
from pavemark.records import from_json, read_json, structure, to_json, unstructure

WORKER = (sys.executable, "-m", "pavemark.job.plate_worker")
"""Starts a worker."""

SHEET = "sheet.png"

MOST = 24
"""Plates on the sheet."""

AT_A_TIME = 16
"""Plates whose files are asked after at a time."""

COLUMNS = ("before", "mask", "plate", "ground")

_MARKING, _NO_GROUND = (255, 0, 200), (120, 0, 0)


def make(inputs: Inputs, out: Path, machine: Machine, progress: Progress) -> int:
    """Make the plates that a folder still lacks, and draw its contact sheet.

    A plate counts as made when the journal says so and its files are there. One whose masks in the folder hands have
    mended is filled anew as these say, unless the plate was edited too: then it stays. When an image or its given mask
    has changed, its plate is made anew, unless hands have mended it: then that is told, and it stays. A mended mask is
    never written over: a plate whose file was removed is filled again from it.

    Returns
    -------
    int
        Exit code: 0, 1 when an image was left out, refused, left as it is or failed, 128 + the signal when it was
        stopped.

    Raises
    ------
    InputError
        When nothing can be done: no usable image, an output folder that cannot be written or holds other plates.
    """
    told = _settings(inputs, out)
    found, alone = entries(inputs)
    spare(out, FOLDERS, (inputs.images, inputs.masks), RECORD)
    with Journal(out, Shard()) as kept:
        _claim(out, told)
        sweep(out, FOLDERS)
        for line in alone:
            progress.tell(f"left out: {line}")
        run = Run(inputs, out, found, kept, progress, len(alone))
        lacking = run.lacking()
        with progress.of(len(lacking)):
            run.make(lacking, machine)
        run.join()
        shown = run.draw() if run.stopped_by is None else None
    progress.end(run.summary(shown))
    return run.exit_code


def _settings(inputs: Inputs, out: Path) -> dict[str, Any]:
    """What is to stand in PLATES/plates.json."""
    return {
        **relative(inputs, _INPUTS, out),
        "scale": inputs.pixels_per_metre,
        **makers(inputs),
        "mask": None if inputs.masks is None else json.loads(to_json(inputs.mask)),
        "versions": {"pavemark": __version__, **cache.LIBRARIES},
    }


def _claim(out: Path, told: dict[str, Any]) -> None:
    """Write PLATES/plates.json, or hold what is to be made against what is there."""
    path = out / RECORD
    if path.exists():
        there = read_json(path)
        if not isinstance(there, dict):
            raise InputError(path, "is not the record of a folder of plates")
        hold_against(there, told, out, "set of plates", set(_INPUTS))
        if there == told:
            return
    write_record(path, told)


_INPUTS = ("images", "masks")


class Mended(InputError):
    """What is asked for would undo what hands have done to a plate."""


_BY_HAND = "which hands have mended: remove its files in plates, masks and ground to have it made anew"


@attrs.define
class Run:
    """A run under way, and what has come of it so far."""

    inputs: Inputs
    out: Path
    entries: tuple[Entry, ...]
    kept: Journal
    progress: Progress
    alone: int
    known: dict[str, journal.Entry] = attrs.field(init=False)
    done: dict[str, journal.Entry] = attrs.field(init=False)
    made: int = 0
    failed: dict[str, str] = attrs.field(factory=dict)
    left: set[str] = attrs.field(factory=set)
    refused: dict[str, str] = attrs.field(factory=dict)
    stopped_by: int | None = None

    def __attrs_post_init__(self) -> None:
        self._look()

    def _look(self) -> None:
        """Which plates some journal tells of, and of which of these all files are there, whole. None is opened."""
        self.known = journal.entries(self.out)
        whole = set(self.known).intersection(*(stems(self.out / folder, ".png") for folder in FOLDERS))
        whole -= halves(self.out)
        self.done = {name: self.known[name] for name in whole}

    def lacking(self) -> list[Entry]:
        """The images whose plate is not made, or whose files are not as they were. None of them is opened."""
        stamps = journal.beside(self.out)
        # A drive far off answers late, but many questions at a time.
        with ThreadPoolExecutor(AT_A_TIME) as crew:
            kept = crew.map(lambda each: self._as_was(each, stamps), self.entries)
            return [each for each, as_was in zip(self.entries, kept, strict=True) if not as_was]

    def _as_was(self, entry: Entry, stamps: dict[str, dict[str, list[int]]]) -> bool:
        if entry.name not in self.done:
            return False
        where = {"image": entry.image, "mask": entry.mask, **paths(self.out, entry.name)}
        try:
            return all(stamp(where[role]) == known for role, known in stamps[entry.name].items())
        except InputError:
            return False

    def make(self, lacking: list[Entry], machine: Machine) -> None:
        """Make plates until none is lacking or a signal stops it."""
        setup = {"inputs": attrs.asdict(self.inputs), "out": str(self.out), "patience": machine.patience}
        size = min(machine.workers, len(lacking))
        with Crew(machine.command, setup, size, machine.recycle) as crew, crew.heeding_signals():
            for answer in crew.work(self._tasks(lacking, crew)):
                if answer.task is not None:
                    self._take(answer, lacking[answer.task.index])
        self.stopped_by = crew.stopped_by
        self._look()
        if crew.lost:
            sweep(self.out, FOLDERS)

    def _tasks(self, lacking: list[Entry], crew: Crew) -> Iterator[Task]:
        for number, entry in enumerate(lacking):
            if crew.stopped_by is not None:
                return
            try:
                task = self._task(number, entry)
            except Mended as mended:
                self.progress.tell(f"left as it is: {mended}")
                self.left.add(entry.name)
                self.progress.step(lacking=False)
                continue
            except InputError as error:
                self._refuse(entry, error.where, error.what)
                continue
            if task is None:
                self.progress.step(lacking=False)
            else:
                yield task

    def _task(self, number: int, entry: Entry) -> Task | None:
        """How its plate is to be made; None where it is as it should be.

        Raises
        ------
        Mended
            When the plate would be made anew although hands have mended it.
        InputError
            When a file cannot be read, or one is missing that belongs to what hands have mended.
        """
        known = self.known.get(entry.name)
        anew = Task(number, str(entry.image), entry.mask and str(entry.mask), again=known is not None)
        own = paths(self.out, entry.name)
        there = {kind: path for kind, path in own.items() if path.exists()}
        if known is None or not there:
            return anew
        row = structure(Row, json.loads(known.read()[0]), self.out)
        # What a run that was killed has written over is its own work, not that of hands.
        half = begun(self.out, entry.name)
        written = [row.files]
        if half.exists():
            row = from_json(Row, half)
            written.append(row.files)
        given = {"image": entry.image} if entry.mask is None else {"image": entry.image, "mask": entry.mask}
        hashes = {"image": row.sha256} if row.mask is None else {"image": row.sha256, "mask": row.mask}
        stamps = {role: stamp(path) for role, path in {**given, **there}.items() if role != "plates"}
        edited = {
            kind
            for kind, path in there.items()
            if sha256(path) not in {each[path.relative_to(self.out).as_posix()] for each in written}
        }
        changed = {role: sha256(path) for role, path in given.items()} != hashes
        if edited or row.mended:
            if changed:
                raise Mended(entry.image, f"it or its mask has changed since its plate was made, {_BY_HAND}")
            if not {"masks", "ground"} <= there.keys():
                lost = next(own[kind] for kind in ("masks", "ground") if kind not in there)
                raise Mended(lost, f"is missing and belongs to a plate {_BY_HAND}")
            if "plates" not in there or ("plates" not in edited and (edited or half.exists())):
                return anew._replace(mended=True)
        elif changed or there != own or half.exists():
            return anew
        self._keep(entry.name, unstructure(row), stamps)
        return None

    def _keep(self, name: str, row: dict[str, Any], stamps: dict[str, list[int]]) -> None:
        self.kept.append(name, row, stamps)
        begun(self.out, name).unlink(missing_ok=True)

    def _take(self, answer: Answer, entry: Entry) -> None:
        message = answer.message
        if answer.say == "done":
            self._keep(entry.name, message["row"], message["stamps"])
            self.made += 1
            self.progress.step(lacking=False)
        elif answer.say == "unusable":
            self._refuse(entry, message["where"], message["what"])
        else:
            log(self.out, entry.image.name, message["trace"])
            self.progress.tell(f"{entry.image} failed: {message['what']} ({self.out / LOG} has more)")
            self.failed[entry.name] = f"failed: {message['what']}"
            self.progress.step(lacking=True)

    def _refuse(self, entry: Entry, where: str, what: str) -> None:
        self.progress.tell(f"refused: {where}: {what}")
        self.refused[entry.name] = f"{Path(where).name}: {what}"
        self.progress.step(lacking=True)

    def join(self) -> None:
        """Write PLATES/plates.jsonl: what is known of each plate, and why an image has none, by name.

        Raises
        ------
        InputError
            When it cannot be written, or every image is refused.
        """
        if not self.done and len(self.refused) == len(self.entries):
            raise InputError(self.inputs.images, f"none of its {len(self.entries)} images can be used")
        files.write_parts(self.out / ROWS, self._lines())

    def _lines(self) -> Iterator[bytes]:
        # Where an image failed there may be a plate of what it was before.
        lacking = self.refused | self.failed
        names = sorted(self.done.keys() | lacking.keys())
        rows = journal.lines(self.done[name] for name in names if name not in lacking)
        for name in names:
            why = lacking.get(name)
            row = json.loads(next(rows)[0]) if why is None else {"name": name, "refused": why}
            yield json.dumps(row, allow_nan=False).encode() + b"\n"

    def draw(self) -> Path | None:
        """Draw PLATES/sheet.png: up to 24 plates as their files are now, spread evenly over those of the images.

        Those left as hands have mended them are not on it: their images are others now.

        Returns
        -------
        Path or None
            None where no image has a plate.

        Raises
        ------
        InputError
            When a file of a plate that was edited cannot be used.
        """
        missing = self.refused.keys() | self.failed.keys() | self.left
        there = [entry for entry in self.entries if entry.name in self.done and entry.name not in missing]
        if not there:
            return None
        path = self.out / SHEET
        files.write(path, files.png(drawn([_Sample(entry, self.out) for entry in spread(there, MOST)], COLUMNS)))
        return path

    @property
    def exit_code(self) -> int:
        """As `make` returns it."""
        if self.stopped_by is not None:
            return 128 + self.stopped_by
        return SOME_LACK if self.failed or self.refused or self.left or self.alone else 0

    def summary(self, sheet: Path | None) -> str:
        """What there is now, in one line."""
        lacking = self.refused.keys() | self.failed.keys()
        there = sum(entry.name in self.done and entry.name not in lacking for entry in self.entries)
        told = [f"{there} of {len(self.entries)} plates in {self.out}, {self.made} of them made now"]
        if self.stopped_by is not None:
            told.append("stopped; the same command goes on from here")
        if self.refused:
            told.append(f"{len(self.refused)} refused")
        if self.left:
            told.append(f"{len(self.left)} left as hands have mended them")
        if self.failed:
            told.append(f"{len(self.failed)} failed, see {self.out / LOG}")
        if gone := len(self.done.keys() - {entry.name for entry in self.entries}):
            told.append(f"{gone} more of images that are not in {self.inputs.images}")
        if sheet is not None:
            told.append(f"to be looked at: {sheet}")
        return "; ".join(told)


class _Sample:
    """A plate and what is shown of it."""

    def __init__(self, entry: Entry, out: Path) -> None:
        self._entry = entry
        self._stock = stock(out)
        self.title = entry.name
        self.size = self._stock.row(entry.name).size

    def tiles(self, scale: float) -> Sequence[np.ndarray]:
        """See `pavemark.job.contact_sheet.Strip.tiles`."""
        plate = self._stock.plate(self._entry.name)
        before = read_image(self._entry.image)
        views = (
            before,
            _over(before, plate.markings),
            plate.image,
            np.where(plate.ground[..., None], plate.image, _NO_GROUND),
        )
        return [scaled(quantise(view), scale) for view in views]


def _over(image: np.ndarray, markings: np.ndarray) -> np.ndarray:
    """The image a little darker, the markings in a colour that no ground has."""
    return np.where(markings[..., None], _MARKING, 0.7 * image)
