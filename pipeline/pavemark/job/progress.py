"""What a user sees of a run: a bar in a terminal, a line now and then elsewhere, nothing when asked to be quiet."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from pavemark.errors import one_line
from pavemark.job.clock import now

EVERY = 5.0
"""Seconds between two lines."""


class Progress(Protocol):
    """Told of every image; what must be reported goes to stderr, the rest to stdout."""

    def of(self, total: int) -> contextmanager:
        """Entered while `total` images are made."""
        ...

    def step(self, lacking: bool) -> None:
        """One image is made, or will be lacking."""
        ...

    def tell(self, line: str) -> None:
        """Report an image that is left out or failed."""
        ...

    def end(self, line: str) -> None:
        """Say what came of it all."""
        ...


class Quiet:
    """Says nothing but what went wrong."""

    @contextmanager
    def of(self, total: int) -> Iterator[None]:
        yield

    def step(self, lacking: bool) -> None:
        pass

    def tell(self, line: str) -> None:
        print(one_line(line), file=sys.stderr, flush=True)

    def end(self, line: str) -> None:
        pass


class Lines(Quiet):
    """A line every few seconds."""

    def __init__(self, what: str, every: float) -> None:
        self._what = what
        self._every = every

    @contextmanager
    def of(self, total: int) -> Iterator[None]:
        self._total, self._count, self._lacking = total, 0, 0
        self._start = self._told = now()
        yield

    def step(self, lacking: bool) -> None:
        self._count += 1
        self._lacking += lacking
        if now() - self._told >= self._every:
            self._told = now()
            rate = self._count / (self._told - self._start)
            left = _span((self._total - self._count) / rate)
            print(
                f"{self._count}/{self._total}  {rate:.1f} {self._what}/s  {left} left{_lack(self._lacking)}", flush=True
            )

    def end(self, line: str) -> None:
        print(line, flush=True)


class Terminal(Quiet):
    """A bar with rate and time left."""

    def __init__(self, what: str) -> None:
        self._what = what

    @contextmanager
    def of(self, total: int) -> Iterator[None]:
        self._lacking = 0
        self._start = now()
        # A stderr that leads elsewhere is not drawn above the bar: it must reach where it leads.
        self._bar = Bar(
            TextColumn(self._what),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[lack]}"),
            console=Console(file=sys.stdout),
            redirect_stderr=sys.stderr.isatty(),
            transient=True,
        )
        with self._bar:
            self._task = self._bar.add_task("", total=total, rate="", lack="")
            yield

    def step(self, lacking: bool) -> None:
        self._lacking += lacking
        count = self._bar.tasks[0].completed + 1
        rate = f"{count / (now() - self._start):.1f}/s"
        self._bar.update(self._task, advance=1, rate=rate, lack=_lack(self._lacking))

    def end(self, line: str) -> None:
        print(line, flush=True)


def shown(quiet: bool, what: str = "images", every: float = EVERY) -> Progress:
    """The progress that suits where stdout leads; `what` is counted, and told every so many seconds."""
    if quiet:
        return Quiet()
    return Terminal(what) if sys.stdout.isatty() else Lines(what, every)


def _lack(count: int) -> str:
    return f"  {count} lacking" if count else ""


def _span(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}"
