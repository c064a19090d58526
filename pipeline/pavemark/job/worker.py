"""A worker: a process that makes images, or plates, as it is told, one JSON line in and one out.

Tasks come on stdin. Answers go to what was stdout when the process started; from then on stdout leads to stderr, so
that whatever a renderer prints disturbs nobody. A worker ends when its stdin does, and so never outlives the run.
"""

from __future__ import annotations

import faulthandler
import importlib.metadata
import json
import os
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Protocol, TextIO

import cv2
import numpy as np
import scipy

from pavemark import __version__
from pavemark.errors import InputError
from pavemark.job.config import Job
from pavemark.job.exactness import Exactness
from pavemark.job.folder import Folder
from pavemark.job.image import make_image
from pavemark.job.inputs import UnusableImage
from pavemark.layers import Renderer
from pavemark.records import structure

GRACE = 5.0
"""Seconds that an image in flight is given once the run is gone."""


class Craft(Protocol):
    """What a worker makes."""

    versions: dict[str, str]
    """Of all that what it makes depends on."""

    def make(self, task: dict[str, Any]) -> dict[str, Any]:
        """Do a task; what is to be said of it when it is done.

        Raises
        ------
        UnusableImage
            When the task's input cannot be used.
        InputError
            When no task can be done.
        """
        ...


def serve(make_renderer: Callable[[], Renderer]) -> None:
    """Make images until stdin ends.

    Parameters
    ----------
    make_renderer : callable
        Called once, after the worker is known to be wanted.
    """
    attend(lambda setup: Images(setup, make_renderer))


def attend(learn: Callable[[dict[str, Any]], Craft]) -> None:
    """Do tasks until stdin ends.

    Parameters
    ----------
    learn : callable
        From what the worker is told first to what it makes. May raise `InputError`.
    """
    answers = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8", newline="\n")
    os.dup2(2, 1)
    cv2.setNumThreads(1)
    tasks = _lines()
    setup = next(tasks)
    try:
        craft = learn(setup)
    except InputError as error:
        return _answer(answers, say="fatal", where=error.where, what=error.what)
    _answer(answers, say="ready", versions=craft.versions)
    for task in tasks:
        # A thread of the interpreter's own, which fires even where a renderer hangs in machine code.
        faulthandler.dump_traceback_later(setup["patience"], exit=True, file=2)
        _answer(answers, **_made(task, craft))
        faulthandler.cancel_dump_traceback_later()


class Images:
    """Synthetic images, drawn by a renderer.

    Raises
    ------
    InputError
        When there is no renderer.
    """

    def __init__(self, setup: dict[str, Any], make_renderer: Callable[[], Renderer]) -> None:
        self._job = structure(Job, setup["job"], "job")
        self._exact = structure(Exactness, setup["exact"], "job") if "exact" in setup else None
        self._folder = Folder.of(Path(setup["out"]), self._job)
        self._renderer = started(make_renderer)
        self.versions = versions() | {"renderer": self._renderer.version}

    def make(self, task: dict[str, Any]) -> dict[str, Any]:
        """See `Craft.make`."""
        mask = None if task["mask"] is None else Path(task["mask"])
        row, coco = make_image(
            task["index"], Path(task["image"]), mask, self._job, self._folder, self._renderer, self._exact
        )
        return {"row": {**row, "versions": self.versions}, "coco": coco}


def versions() -> dict[str, str]:
    """Of Pavemark and of the libraries whose bits end up in what it makes."""
    return {
        "pavemark": __version__,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
        "scipy": scipy.__version__,
    }


def _made(task: dict[str, Any], craft: Craft) -> dict[str, Any]:
    try:
        return {"say": "done", **craft.make(task)}
    except UnusableImage as error:
        return {"say": "unusable", "where": error.where, "what": error.what}
    except InputError as error:
        return {"say": "fatal", "where": error.where, "what": error.what}
    except Exception as error:
        return {"say": "failed", "what": _one_line(error), "trace": traceback.format_exc()}


def _answer(answers: TextIO, **message: Any) -> None:
    # The line break before it closes a line that something else may have begun.
    answers.write("\n" + json.dumps(message, allow_nan=False) + "\n")


def _lines() -> Iterator[Any]:
    inbox: SimpleQueue[str] = SimpleQueue()

    def read() -> None:
        for line in sys.stdin:
            inbox.put(line)
        inbox.put("")
        threading.Event().wait(GRACE)
        os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    return map(json.loads, iter(inbox.get, ""))


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def started(make_renderer: Callable[[], Renderer]) -> Renderer:
    """A renderer.

    Raises
    ------
    InputError
        When what it needs is not installed.
    """
    try:
        return make_renderer()
    except ImportError as error:
        how = "pip install 'pavemark[blender]', or use blender -b -P render.py -- JOB.toml …"
        raise InputError("Blender", f"{_one_line(error)}: {how}") from None


def installed_renderer() -> Renderer:
    """The renderer that an installed package registers as `pavemark.renderers`.

    Raises
    ------
    InputError
        When there is none, or what it needs is not installed.
    """
    found = list(importlib.metadata.entry_points(group="pavemark.renderers"))
    if not found:
        raise InputError("pavemark.renderers", "no renderer is installed: use blender -b -P render.py -- JOB.toml …")
    return started(lambda: found[0].load()(threads=1))


if __name__ == "__main__":
    serve(installed_renderer)
