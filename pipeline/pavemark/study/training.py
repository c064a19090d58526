"""Many runs trained at a time, each in a process of its own; those whose detectors are there are not trained again."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from pavemark import files, system
from pavemark.errors import InputError
from pavemark.study import runs
from pavemark.study.runs import Run

Tell = Callable[[str], None]


def train_all(wanted: Iterable[tuple[str, Run]], folder: Path, workers: int, tell: Tell) -> None:
    """Train what lacks, several at a time.

    When it is stopped, or one of them fails, those that are being trained are ended, and leave no file half-written;
    so are they when this process is killed.

    Parameters
    ----------
    wanted : iterable of (str, Run)
        Runs, and what each is called when it is told of. Runs of one key are trained once.
    folder : Path
        The detectors go to `models` in it, named by the key of their run.
    workers : int
        Processes, each with one thread, so that a detector does not depend on their number.
    tell : callable
        Told a line after each.

    Raises
    ------
    InputError
        When torch is missing, a picture cannot be read, or a process was ended by someone else.
    """
    lacking = {run.key(): (called, run) for called, run in wanted if not runs.model(run, folder).exists()}
    if not lacking:
        return
    # Two that start from one run would both train it.
    starts = {run.start.key(): (called, run.start) for called, run in lacking.values() if run.start is not None}
    for batch in (starts, lacking):
        if batch:
            _train(batch, folder, workers, tell)


def _train(wanted: dict[str, tuple[str, Run]], folder: Path, workers: int, tell: Tell) -> None:
    context = multiprocessing.get_context("spawn")
    files.sweep(folder / "models")
    with ProcessPoolExecutor(min(workers, len(wanted)), mp_context=context, initializer=_led) as pool:
        try:
            # Ctrl-C in a terminal goes to all that run in it: here alone it is decided when a process ends.
            with system.uninterrupted():
                # To tell a key each picture is read: once is enough.
                tasks = {pool.submit(runs.train, run, folder, key): called for key, (called, run) in wanted.items()}
            for number, task in enumerate(as_completed(tasks), 1):
                task.result()
                tell(f"trained {number}/{len(tasks)}: {tasks[task]}")
        except BaseException as error:
            # A pool that is shut down no longer tells its processes.
            processes = list((pool._processes or {}).values())
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            for process in processes:
                process.join()
            files.sweep(folder / "models")
            if isinstance(error, BrokenProcessPool):
                raise InputError(
                    "--workers", f"{workers}: one was ended, as where memory runs out: fewer use less"
                ) from None
            raise


def _led() -> None:
    """Have this process of a pool heed no Ctrl-C, and end with the one that started it, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    # Whoever is killed tells its pool nothing: it would train for hours, and then wait for more forever.
    multiprocessing.parent_process().join()
    os._exit(1)
