"""A function run in a process of its own, so that its memory is its own and a crash of it is told in a line."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import attrs
import cv2

from pavemark.accuracy.clock import spent
from pavemark.errors import InputError

THREADS = 1
"""Threads of OpenCV, in all its copies, and of OpenMP in the process; networks have one as well
(`pavemark.background.onnx`)."""


@attrs.frozen(eq=False)
class Answer:
    """What came of a call.

    Attributes
    ----------
    value : Any
        What the function returned.
    seconds : float
        Processor time of the call alone, see `pavemark.accuracy.clock`.
    peak_mb : float
        Most memory (resident, 10⁶ bytes) that the process has held so far; nan where the system is
        not Linux.
    """

    value: Any
    seconds: float
    peak_mb: float


class Apart:
    """A process that calls one function, as often as it is asked to.

    Parameters
    ----------
    function : callable
        Of a module, so that the process can import it.
    name : str
        Of what it does, for errors.
    """

    def __init__(self, function: Callable[..., Any], name: str) -> None:
        self._function = function
        self._name = name
        self._process = None

    def __enter__(self) -> Apart:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def __call__(self, *arguments: Any) -> Answer:
        """Call the function there.

        Raises
        ------
        InputError
            When it raised anything, or its process died.
        """
        if self._process is None:
            self._start()
        try:
            self._pipe.send(arguments)
            fault, *answer = self._pipe.recv()
        except (EOFError, OSError):
            self._process.join()
            code = self._process.exitcode
            self._end()
            raise InputError(self._name, f"its process died with code {code}: is there enough memory?") from None
        if fault is not None:
            raise InputError(self._name, fault)
        return Answer(*answer)

    def _start(self) -> None:
        # A fork would begin with the memory of this process, and with its locks.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._function), daemon=True)
        self._process.start()
        theirs.close()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None


def _serve(pipe: Connection, function: Callable[..., Any]) -> None:
    # Ctrl-C is for the process that asks; it ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(THREADS)
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), str(THREADS))
    while True:
        try:
            arguments = pipe.recv()
        except EOFError:
            return
        start = spent()
        try:
            value, fault = function(*arguments), None
        except InputError as error:
            value, fault = None, str(error)
        except Exception as error:  # whatever a method does wrong is its own fault and no one else's
            value, fault = None, f"{type(error).__name__}: {error}"
        pipe.send((fault, value, spent() - start, _peak()))


def _peak() -> float:
    # Of the process as it is since it began to run this program: getrusage counts what its parent held as well.
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return float("nan")
    return int(status.partition("VmHWM:")[2].split()[0]) * 1024 / 1e6
