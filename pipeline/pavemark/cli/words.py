"""What the commands' options have in common."""

from __future__ import annotations

import os
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from pavemark.errors import InputError
from pavemark.job.config import merge, setting
from pavemark.job.run import LOG, log


class Folder(click.Path):
    """A path that was given: an unset variable of a shell script is not the working directory."""

    def convert(self, value, param, ctx):
        if not str(value):
            self.fail("it is empty: a folder is needed", param, ctx)
        return super().convert(value, param, ctx)


def cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
    except (InputError, BrokenPipeError):
        raise
    except Exception as error:
        log(out, "the run", traceback.format_exc())
        raise InputError(out / LOG, f"an unexpected fault is told there ({type(error).__name__}: {error})") from error
