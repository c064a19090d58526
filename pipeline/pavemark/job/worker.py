"""A worker: a process that makes images as it is told, one JSON line in and one out.

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
from typing import Any, TextIO

import cv2
import numpy as np
import scipy

from pavemark import __version__
from pavemark.errors import InputError
from pavemark.job.config import Job
from pavemark.job.folder import Folder
from pavemark.job.image import UnusableImage, make_image
from pavemark.layers import Renderer
from pavemark.records import structure

GRACE = 5.0
"""Seconds that an image in flight is given once the run is gone."""


def serve(make_renderer: Callable[[], Renderer]) -> None:
    """Make images until stdin ends.

    Parameters
    ----------
    make_renderer : callable
        Called once, after the worker is known to be wanted.
    """
    answers = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
    os.dup2(2, 1)
    cv2.setNumThreads(1)
    tasks = _lines()
    setup = next(tasks)
    job = structure(Job, setup["job"], "job")
    folder = Folder.of(Path(setup["out"]), job)
    try:
        renderer = make_renderer()
    except ImportError as error:
        how = "pip install 'pavemark[blender]', or use blender -b -P render.py -- JOB.toml …"
        return _answer(answers, say="fatal", where="Blender", what=f"{_one_line(error)}: {how}")
    except InputError as error:
        return _answer(answers, say="fatal", where=error.where, what=error.what)
    versions = {
        "pavemark": __version__,
        "renderer": renderer.version,
        "numpy": np.__version__,
        "opencv": cv2.__version__,
        "scipy": scipy.__version__,
    }
    _answer(answers, say="ready", versions=versions)
    for task in tasks:
        # A thread of the interpreter's own, which fires even where a renderer hangs in machine code.
        faulthandler.dump_traceback_later(setup["patience"], exit=True, file=2)
        _answer(answers, **_made(task, job, folder, renderer, versions))
        faulthandler.cancel_dump_traceback_later()


def _made(task: dict, job: Job, folder: Folder, renderer: Renderer, versions: dict[str, str]) -> dict[str, Any]:
    mask = None if task["mask"] is None else Path(task["mask"])
    try:
        row, coco = make_image(task["index"], Path(task["image"]), mask, job, folder, renderer)
    except UnusableImage as error:
        return {"say": "unusable", "where": error.where, "what": error.what}
    except InputError as error:
        return {"say": "fatal", "where": error.where, "what": error.what}
    except Exception as error:
        return {"say": "failed", "what": _one_line(error), "trace": traceback.format_exc()}
    return {"say": "done", "row": {**row, "versions": versions}, "coco": coco}


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


def installed_renderer() -> Renderer:
    """The renderer that an installed package registers as `pavemark.renderers`.

    Raises
    ------
    InputError
        When there is none.
    """
    for point in importlib.metadata.entry_points(group="pavemark.renderers"):
        return point.load()(threads=1)
    raise InputError("pavemark.renderers", "no renderer is installed: use blender -b -P render.py -- JOB.toml …")


if __name__ == "__main__":
    serve(installed_renderer)
