"""The workers of a run, seen from the run: hired, recycled, replaced when they die."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import subprocess
import tempfile
import threading
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

from pavemark import system
from pavemark.errors import InputError

ATTEMPTS = 2
"""An image whose worker dies is tried once more: memory runs out for reasons that pass."""

STILLBORN = 3
"""So many workers in a row that die before they are ready are no accident."""

HEED = 0.2
"""Seconds between looks for a signal: on Windows none interrupts a wait."""

_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")}


class Task(NamedTuple):
    """An image or a plate to make: its number, the input image and its mask.

    A plate that is `mended` is made of its own masks in place of the given one. Where one is made `again`, files of its
    may be written over.
    """

    index: int
    image: str
    mask: str | None
    mended: bool = False
    again: bool = False


class Answer(NamedTuple):
    """What came of a task, or, without one, that a worker is ready."""

    task: Task | None
    say: str
    message: dict[str, Any]


class Worker:
    """One process and what it is busy with."""

    def __init__(self, command: Sequence[str], setup: dict[str, Any], inbox: SimpleQueue) -> None:
        self.task: Task | None = None
        self.ready = False
        self.retired = False
        self.served = 0
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 - read when the worker has died
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            env={**os.environ, **_ONE_THREAD},
            # Ctrl-C in a terminal goes to all that run in it: the run alone decides when a worker ends.
            **system.apart(),
        )
        self.pid = self._process.pid
        self._send(setup)
        threading.Thread(target=self._listen, args=(inbox,), daemon=True).start()

    def _listen(self, inbox: SimpleQueue) -> None:
        for line in self._process.stdout:
            # Anything else is what Blender prints, or an answer cut short by death.
            if line.startswith(b'{"say": ') and line.endswith(b"\n"):
                inbox.put((self, json.loads(line)))
        inbox.put((self, None))

    def _send(self, message: Any) -> None:
        # A broken pipe is a death, which the listening thread reports; Windows calls it an invalid argument.
        with contextlib.suppress(OSError):
            self._process.stdin.write(json.dumps(message).encode() + b"\n")
            self._process.stdin.flush()

    def give(self, task: Task) -> None:
        """Hand it a task."""
        self.task = task
        self.served += 1
        self._send(task._asdict())

    def retire(self) -> None:
        """Let it end by itself."""
        self.retired = True
        with contextlib.suppress(OSError):
            self._process.stdin.close()

    def end(self) -> bool:
        """Have it gone when this returns; whether it had to be killed."""
        try:
            # An idle worker is given the moment that Blender takes to leave.
            self._process.wait(timeout=2.0 if self.ready and self.task is None else 0.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return True
        return False

    def last_words(self) -> str:
        """How it died, and what it printed last."""
        code = self._process.wait()
        how = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
        self._stderr.seek(0, os.SEEK_END)
        self._stderr.seek(max(0, self._stderr.tell() - 10_000))
        return f"{self._stderr.read().decode(errors='replace').strip()}\n{how}".strip()


class Crew:
    """Workers that make images or plates. Use it in a `with` statement: afterwards no process is left.

    Parameters
    ----------
    command : sequence of str
        Starts a worker.
    setup : dict
        What a worker is told first.
    size : int
        Workers at a time.
    recycle : int
        Images after which a worker is replaced by a fresh one.
    """

    def __init__(self, command: Sequence[str], setup: dict[str, Any], size: int, recycle: int) -> None:
        self._command = command
        self._setup = setup
        self._size = size
        self._recycle = recycle
        self._inbox: SimpleQueue = SimpleQueue()
        self._workers: list[Worker] = []
        self._stillborn = 0
        self._stopping = self._dropping = False
        self.lost = False
        """Whether a worker ended otherwise than by itself, and may have left files aside."""
        self.stopped_by: int | None = None
        """The signal that stopped it."""

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *error: object) -> None:
        for worker in self._workers:
            worker.retire()
        for worker in self._workers:
            self.lost |= worker.end()

    def stop(self) -> None:
        """Give out no more tasks; the second time, drop those in flight. May be called from a signal handler."""
        self._dropping = self._stopping
        self._stopping = True
        self._inbox.put((None, None))

    @contextmanager
    def heeding_signals(self) -> Iterator[None]:
        """Entered while Ctrl-C and SIGTERM are to stop it."""

        def stop(number: int, frame: object) -> None:
            self.stopped_by = number
            self.stop()

        before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in before.items():
                # None stands for a handler that is not Python's, as a Blender program has one.
                signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def work(self, tasks: Iterable[Task]) -> Iterator[Answer]:
        """Do tasks and yield what came of each, in the order in which they are ready.

        Yields
        ------
        Answer
            "ready" without a task when a worker has started; else what the worker says of its task, or "died" with
            its last words when a worker died at every attempt.

        Raises
        ------
        InputError
            When workers cannot be started, or one says that the whole job cannot be done.
        """
        waiting = _Waiting(iter(tasks))
        while True:
            if not self._stopping:
                self._give_out(waiting)
            busy = any(worker.task for worker in self._workers)
            if self._dropping or (not busy and (self._stopping or not waiting)):
                return
            worker, message = self._heard()
            if worker is None:
                continue
            if message is None:
                yield from self._bury(worker, waiting)
            elif message["say"] == "fatal":
                raise InputError(message["where"], message["what"])
            elif message["say"] == "ready":
                worker.ready, self._stillborn = True, 0
                yield Answer(None, "ready", message)
            else:
                task, worker.task = worker.task, None
                if worker.served >= self._recycle:
                    worker.retire()
                yield Answer(task, message["say"], message)

    def _heard(self) -> tuple[Worker | None, dict[str, Any] | None]:
        while True:
            try:
                return self._inbox.get(timeout=HEED)
            except Empty:
                continue

    def _give_out(self, waiting: _Waiting) -> None:
        for worker in self._workers:
            if worker.ready and not worker.retired and worker.task is None and waiting:
                worker.give(waiting.pop())
        serving = sum(not worker.retired for worker in self._workers)
        if waiting:
            for _ in range(serving, self._size):
                self._workers.append(Worker(self._command, self._setup, self._inbox))

    def _bury(self, worker: Worker, waiting: _Waiting) -> Iterator[Answer]:
        self._workers.remove(worker)
        if worker.retired:
            return
        worker.retire()
        self.lost = True
        words = worker.last_words()
        if not worker.ready:
            self._stillborn += 1
            if self._stillborn >= STILLBORN:
                raise InputError(self._command[0], f"no worker starts: {words.splitlines()[-1]}")
        if worker.task and not waiting.again(worker.task):
            yield Answer(worker.task, "died", {"what": f"its worker {words.splitlines()[-1]}", "trace": words})


class _Waiting:
    """Tasks that are to be given out; true while there are any."""

    def __init__(self, tasks: Iterator[Task]) -> None:
        self._tasks = tasks
        self._next: deque[Task] = deque()
        self._deaths: Counter[Task] = Counter()

    def __bool__(self) -> bool:
        if not self._next:
            self._next.extend(itertools.islice(self._tasks, 1))
        return bool(self._next)

    def pop(self) -> Task:
        return self._next.popleft()

    def again(self, task: Task) -> bool:
        """Whether a task whose worker died is given out once more."""
        self._deaths[task] += 1
        if self._deaths[task] >= ATTEMPTS:
            return False
        self._next.appendleft(task)
        return True
