"""A function run in a process of its own, so that its memory is its own and a crash of it is told in a line."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

import attrs
import cv2

from pavemark.accuracy.clock import spent
from pavemark.errors import InputError
from pavemark.system import peak, uninterrupted

THREADS = 1
"""Threads of OpenCV and of linear algebra, in all their copies, in the process; networks have one as well
(`pavemark.onnx`)."""

_THREADS = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), str(THREADS)
)


@attrs.frozen(eq=False)
class Answer:
    """What came of a call.

    Attributes
    ----------
    value : Any
        What the function returned.
    seconds : float
        Processor time of the call alone, see `pavemark.accuracy.clock`; the mean where it was called more than once.
    peak_mb : float
        Most memory (resident, 10⁶ bytes) that the process has held so far; nan on macOS.
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
    least : float
        Seconds of processor time for which it is called over and over, each time it is asked to: what takes
        microseconds cannot be timed once.
    patience : float or None
        Seconds after which the process is given up, with what it does; None waits for ever.
    """

    def __init__(
        self, function: Callable[..., Any], name: str, least: float = 0.0, patience: float | None = None
    ) -> None:
        self._function = function
        self._name = name
        self._least = least
        self._patience = patience
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
            When it raised anything, its process died, or patience ended.
        """
        if self._process is None:
            self._start()
        try:
            self._pipe.send(arguments)
            if not self._pipe.poll(self._patience):
                self._end()
                raise InputError(self._name, f"gave no answer within {self._patience:g} s")
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
        arguments = theirs, self._function, self._least
        process = context.Process(target=_serve, args=arguments, daemon=True)
        # The environment is read when a library is loaded, which is before the process is asked for anything.
        with _uninterrupted(), _environment(_THREADS):
            process.start()
            self._process = process
        theirs.close()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None


def _serve(pipe: Connection, function: Callable[..., Any], least: float) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(THREADS)
    while True:
        try:
            arguments = pipe.recv()
        except EOFError:
            return
        value, seconds, fault = None, float("nan"), None
        try:
            value, seconds = _timed(function, arguments, least)
        except InputError as error:
            fault = str(error)
        except Exception as error:  # whatever a method does wrong is its own fault and no one else's
            fault = f"{type(error).__name__}: {error}"
        pipe.send((fault, value, seconds, peak()))


def _timed(function: Callable[..., Any], arguments: tuple[Any, ...], least: float) -> tuple[Any, float]:
    """What a call returns and how long it takes; called twice as often each time until that can be told."""
    calls = 1
    while True:
        start = spent()
        for _ in range(calls):
            value = function(*arguments)
        seconds = spent() - start
        if seconds >= least:
            return value, seconds / calls
        calls *= 2


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Entered to start a process that Ctrl-C does not reach: it is for this one, which ends the other.

    A process that is stopped half-way through its start would tell of it in a traceback.
    """
    came = []
    handler = signal.signal(signal.SIGINT, lambda *_: came.append(True))
    try:
        with uninterrupted():
            yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if came:
        raise KeyboardInterrupt


@contextmanager
def _environment(more: Mapping[str, str]) -> Iterator[None]:
    """Entered to start a process with more in its environment than this one has."""
    before = dict(os.environ)
    os.environ.update(more)
    try:
        yield
    finally:
        for name in more:
            if name in before:
                os.environ[name] = before[name]
            else:
                del os.environ[name]
