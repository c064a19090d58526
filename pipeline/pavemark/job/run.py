"""A run: whatever a job still lacks is made, and what is there is joined into one dataset."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import attrs

from pavemark.background.index import Entry
from pavemark.errors import InputError
from pavemark.job import journal
from pavemark.job.config import Job
from pavemark.job.crew import Answer, Crew, Task
from pavemark.job.dataset import join
from pavemark.job.exactness import Exactness, exactness
from pavemark.job.folder import RECORD, Folder, claim, spare, sweep
from pavemark.job.inputs import entries, makers, settled
from pavemark.job.journal import Journal, Shard
from pavemark.job.order import place
from pavemark.job.progress import Progress
from pavemark.records import unstructure

SOME_LACK = 1
"""Exit code when an input image was left out or an image failed."""


RECYCLE = 250
"""Images after which a worker is replaced: Blender may keep a little of all it has drawn. A start costs five images."""

PATIENCE = 900.0
"""Seconds after which an image counts as stuck. The inpainting of a very large one takes longest."""


@attrs.frozen
class Machine:
    """How a run uses the machine. None of it changes a bit of what is made.

    Attributes
    ----------
    command : tuple of str
        Starts a worker.
    workers : int
        Processes at a time.
    recycle : int
        Images after which a process is replaced.
    patience : float
        Seconds after which an image counts as stuck.
    """

    command: tuple[str, ...]
    workers: int
    recycle: int = RECYCLE
    patience: float = PATIENCE


def run(job: Job, out: Path, shard: Shard, machine: Machine, progress: Progress) -> int:
    """Make what a job, or one shard of it, still lacks.

    Returns
    -------
    int
        Exit code: 0, 1 when an input image was left out or an image failed, 128 + the signal when it was stopped.

    Raises
    ------
    InputError
        When the job cannot be done: no usable image, an output folder that cannot be written or holds another job.
    """
    job = settled(job)
    if job.plates is None:
        makers(job)
    exact = exactness(job)
    found, alone = entries(job)
    folder = Folder.of(out, job)
    spare(out, folder.folders, (job.images, job.masks, job.plates), RECORD)
    with Journal(out, shard) as kept:
        claim(out, job, found, exact)
        sweep(out, folder.folders)
        for line in alone:
            progress.tell(f"left out: {line}")
        done = folder.finished()
        missing = [number for number in shard.numbers(job.count) if number not in done]
        plates = journal.plates(done.values()) if missing else {}
        run = Run(job, exact, folder, found, kept, progress, plates, len(alone))
        with progress.of(len(missing)):
            run.make(missing, machine)
    # Of a journal that is open, Windows tells only later when it was written.
    join(folder)
    progress.end(run.summary(shard, len(missing)))
    return run.exit_code


@attrs.define
class Run:
    """A run under way, and what has come of it so far."""

    job: Job
    exact: Exactness | None
    folder: Folder
    entries: tuple[Entry, ...]
    kept: Journal
    progress: Progress
    plates: dict[str, str]
    alone: int
    made: int = 0
    failed: int = 0
    left_out: int = 0
    unusable: set[int] = attrs.field(factory=set)
    stopped_by: int | None = None

    def make(self, missing: list[int], machine: Machine) -> None:
        """Make images until none is missing or a signal stops it."""
        setup = {"job": attrs.asdict(self.job), "out": str(self.folder.out), "patience": machine.patience}
        if self.exact is not None:
            # Read once: whatever becomes of its file, all workers go by one table.
            setup["exact"] = unstructure(self.exact)
        size = min(machine.workers, len(missing))
        versions = journal.versions(self.folder.out)
        with Crew(machine.command, setup, size, machine.recycle) as crew, crew.heeding_signals():
            for answer in crew.work(self._tasks(missing)):
                if answer.task is None:
                    versions = versions or [answer.message["versions"]]
                    self._hold_against(versions, answer.message["versions"])
                else:
                    self._take(answer)
        self.stopped_by = crew.stopped_by
        if crew.lost:
            sweep(self.folder.out, self.folder.folders)
        if len(self.unusable) == len(self.entries):
            raise InputError(self._inputs, f"none of its {len(self.entries)} images can be used")

    def _tasks(self, missing: Iterable[int]) -> Iterator[Task]:
        for number in missing:
            which = place(number, len(self.entries), self.job.seed)
            if which in self.unusable:
                self._leave_out()
            else:
                entry = self.entries[which]
                yield Task(number, str(entry.image), entry.mask and str(entry.mask))

    def _take(self, answer: Answer) -> None:
        number, message = answer.task.index, answer.message
        if answer.say == "done":
            self._hold_plate(message["row"])
            self.kept.append(number, message["row"], message["coco"])
            self.made += 1
            self.progress.step(lacking=False)
        elif answer.say == "unusable":
            which = place(number, len(self.entries), self.job.seed)
            if len(self.entries) == 1:
                raise InputError(message["where"], message["what"])
            if which not in self.unusable:
                self.progress.tell(f"left out: {message['where']}: {message['what']}")
            self.unusable.add(which)
            self._leave_out()
        else:
            log(self.folder.out, f"image {number}", message["trace"])
            self.progress.tell(f"image {number} failed: {message['what']} ({self.folder.out / LOG} has more)")
            self.failed += 1
            self.progress.step(lacking=True)

    def _leave_out(self) -> None:
        self.left_out += 1
        self.progress.step(lacking=True)

    def _hold_plate(self, row: dict[str, Any]) -> None:
        if self.plates.setdefault(row["input"], row["plate"]) != row["plate"]:
            raise InputError(
                self._inputs / row["input"],
                "it or its mask has changed since images were made of it: put it back, or use another output folder",
            )

    @property
    def _inputs(self) -> Path:
        return self.entries[0].image.parent

    def _hold_against(self, there: list[dict[str, str]], here: dict[str, str]) -> None:
        for before in there:
            for name, version in before.items():
                if here.get(name) != version:
                    raise InputError(
                        self.folder.out,
                        f"begun with {name} {version}, this is {here.get(name)}: use that version, or another folder",
                    )

    @property
    def exit_code(self) -> int:
        """As `run` returns it."""
        if self.stopped_by is not None:
            return 128 + self.stopped_by
        return SOME_LACK if self.failed or self.unusable or self.alone else 0

    def summary(self, shard: Shard, missing: int) -> str:
        """What there is now, in one line, where so many images had been missing."""
        wanted = len(shard.numbers(self.job.count))
        whose = f"part {shard.part}/{shard.parts}: " if shard.parts > 1 else ""
        there = wanted - missing + self.made
        told = [f"{whose}{there} of {wanted} images in {self.folder.out}, {self.made} of them made now"]
        if self.stopped_by is not None:
            told.append("stopped; the same command goes on from here")
        if self.unusable:
            told.append(f"{self.left_out} left out for {len(self.unusable)} of {len(self.entries)} input images")
        if self.failed:
            told.append(f"{self.failed} failed, see {self.folder.out / LOG}")
        return "; ".join(told)


LOG = "errors.log"


def log(out: Path, what: str, trace: str) -> None:
    """Keep what a developer wants to see and a user does not; on a full disk it is lost."""
    with contextlib.suppress(OSError), (out / LOG).open("a", encoding="utf-8", newline="\n") as stream:
        stream.write(f"{what}\n{trace.rstrip()}\n\n")
