"""Views drawn ahead of the training, kept in one file that training reads at random."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np

from pavemark import system
from pavemark.errors import InputError
from pavemark.training import views
from pavemark.training.canvas import SIDE

MARKING, GROUND = 1, 2
"""Bits of the fourth channel."""


def drawn(folder: Path, count: int, seed: int, workers: int, tell: Callable[[int], None]) -> np.ndarray:
    """The views of a pool; those that are not there yet are drawn.

    Parameters
    ----------
    folder : Path
        Where the pool is kept: 0.9 MB a view.
    count, seed : int
        View i depends on the seed and i alone.
    workers : int
        Processes that draw.
    tell : callable
        Told the number of views that are there, as it grows.

    Returns
    -------
    ndarray (count, SIDE, SIDE, 4) uint8
        R, G, B in display sRGB, and the bits MARKING and GROUND. It is read from the disk as it is used.

    Raises
    ------
    InputError
        When the folder cannot be written, or its disk has no room for all of them.
    """
    path = folder / f"views-{seed}-{count}.npy"
    done = path.with_suffix(".done")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        there = _there(path, done)
        pool = np.lib.format.open_memmap(path, "r+") if there else _room(path, done, (count, SIDE, SIDE, 4))
        tell(there)
        for number, view in _drawn(range(there, count), seed, workers):
            pool[number] = view
            # What is not counted is drawn again: the count follows the pixels, and not too often.
            if number % 50 == 49 or number == count - 1:
                pool.flush()
                done.write_text(str(number + 1), encoding="utf-8", newline="\n")
            tell(number + 1)
    except OSError as error:
        raise InputError(folder, f"cannot be written: {error.strerror}") from None
    return pool


def _there(path: Path, done: Path) -> int:
    """How many views a file holds; none where it is not whole or nothing tells of it."""
    try:
        counted = int(done.read_text(encoding="utf-8"))
        whole = np.lib.format.open_memmap(path, "r").nbytes < path.stat().st_size
    except (OSError, ValueError):
        return 0
    return counted if whole else 0


def _room(path: Path, done: Path, shape: tuple[int, ...]) -> np.ndarray:
    """A file with room for all views."""
    done.unlink(missing_ok=True)
    np.lib.format.open_memmap(path, "w+", np.uint8, shape)
    # A disk that is full is no error to a file that is mapped: it ends the process.
    try:
        with path.open("r+b") as stream:
            system.reserve(stream)
    except OSError:
        path.unlink()
        raise
    return np.lib.format.open_memmap(path, "r+")


def _drawn(numbers: range, seed: int, workers: int) -> Iterator[tuple[int, np.ndarray]]:
    # Fresh processes: threads of torch and OpenCV do not survive a fork.
    with get_context("spawn").Pool(workers, _alone) as crew:
        tasks = ((number, seed) for number in numbers)
        yield from zip(numbers, crew.imap(_view, tasks, chunksize=2), strict=True)


def _alone() -> None:
    cv2.setNumThreads(1)
    # Ctrl-C reaches every process of a terminal; the one that started these ends them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _view(task: tuple[int, int]) -> np.ndarray:
    number, seed = task
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(number,))))
    view = views.sample(rng, kind=views.KINDS[number % len(views.KINDS)])
    bits = view.marking * np.uint8(MARKING) + view.ground * np.uint8(GROUND)
    return np.dstack([view.image, bits.astype(np.uint8)])
