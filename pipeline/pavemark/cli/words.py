"""What the commands' options have in common."""

from __future__ import annotations

import _thread
import math
import signal
import sys
import threading
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from pavemark.errors import InputError
from pavemark.job.config import merge, setting
from pavemark.job.journal import Shard
from pavemark.job.progress import EVERY
from pavemark.job.run import LOG, log
from pavemark.system import reader_gone

LAST_SEED = 2**32 - 1
"""The largest seed that all who draw by it take."""


class Folder(click.Path):
    """A path that was given: an unset variable of a shell script is not the working directory."""

    kind = "folder"

    def convert(self, value, param, ctx):
        if not str(value):
            self.fail(f"it is empty: a {self.kind} is needed", param, ctx)
        return super().convert(value, param, ctx)


class File(Folder):
    """The same of a file."""

    kind = "file"


class Number(click.FloatRange):
    """A number within a range; click lets pass what is none."""

    def convert(self, value, param, ctx):
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value}: a finite number is allowed", param, ctx)
        return number


class Part(click.ParamType):
    """A part of the work, for one of several machines."""

    name = "K/N"

    def convert(self, value, param, ctx):
        part, _, parts = value.partition("/")
        if not (part.isdecimal() and parts.isdecimal() and int(part) < int(parts)):
            self.fail(f"{value!r}: allowed is K/N with K from 0 to N - 1, such as 3/16", param, ctx)
        return Shard(int(part), int(parts))


def led(command):
    """Options for a program that runs the command: told often how far it is, and stopped by the end of its stdin."""

    def leash(context: click.Context, option: click.Parameter, value: bool) -> None:
        if value:
            # A Blender program has a handler of its own, which would keep it from stopping.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            threading.Thread(target=_until_stdin_ends, daemon=True).start()

    command = click.option("--every", type=click.FloatRange(0.0), default=EVERY, help="Seconds a line.", hidden=True)(
        command
    )
    # Whoever is killed closes no door behind him, but his end of the pipe closes.
    return click.option("--leash", is_flag=True, expose_value=False, callback=leash, hidden=True)(command)


def _until_stdin_ends() -> None:
    while sys.stdin.read(1):
        pass
    # As Ctrl-C would. It wakes nobody; a crew looks for it by itself, see `pavemark.job.crew.HEED`.
    _thread.interrupt_main()


def told(settings: Iterable[str], options: dict[str, Any]) -> dict[str, Any]:
    """What a command line says, as a job file would say it: lines of `--set`, and options, which count more."""
    said: dict[str, Any] = {}
    for text in settings:
        said = merge(said, setting(text))
    return said | {name: value for name, value in options.items() if value is not None}


@contextmanager
def faults_kept(out: Path) -> Iterator[None]:
    """Entered for a run: a fault of the program is kept for its developers in the output folder."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        if isinstance(error, OSError) and reader_gone(error):
            raise
        log(out, "the run", traceback.format_exc())
        raise InputError(out / LOG, f"an unexpected fault is told there ({type(error).__name__}: {error})") from error
