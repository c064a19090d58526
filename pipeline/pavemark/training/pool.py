"""Views drawn ahead of the training, kept in one file that training reads at random."""

from __future__ import annotations

import hashlib
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
import scipy
from filelock import FileLock, Timeout

from pavemark import system
from pavemark.errors import InputError
from pavemark.training import views
from pavemark.training.canvas import SIDE

MARKING, GROUND = 1, 2
"""Bits of the fourth channel."""


DRAWS = ("bodies", "canvas", "floors", "gaps", "light", "paint", "pool", "views")
"""Modules beside this one by which the pixels of views are told; others are cameras, colour and ground."""


def drawn(folder: Path, count: int, seed: int, workers: int, tell: Callable[[int], None]) -> np.ndarray:
    """The views of a pool; those that are not there yet are drawn.

    Parameters
    ----------
    folder : Path
        Where the pool is kept: 0.9 MB a view. The file is named by seed, count and what it was drawn with, code and
        libraries: what others drew is not taken.
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
        When the folder cannot be written, its disk has no room for all of them, another process draws them, or one
        that draws was ended.
    """
    path = folder / f"views-{seed}-{count}-{_drawn_with()}.npy"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(path.with_suffix(".lock"), blocking=False):
            return _filled(path, count, seed, workers, tell)
    except Timeout:
        raise InputError(path, "is being drawn by another process: when it has done so, this command uses it") from None
    except BrokenProcessPool:
        what = f"{workers}: one was ended, as where memory runs out: fewer use less, and what is drawn stays"
        raise InputError("--workers", what) from None
    except OSError as error:
        raise InputError(folder, f"cannot be written: {error.strerror}") from None


def _filled(path: Path, count: int, seed: int, workers: int, tell: Callable[[int], None]) -> np.ndarray:
    done, shape = path.with_suffix(".done"), (count, SIDE, SIDE, 4)
    there = _there(path, done, shape)
    pool = np.lib.format.open_memmap(path, "r+") if there else _room(path, done, shape)
    tell(there)
    for number, view in _drawn(range(there, count), seed, workers):
        pool[number] = view
        # What is not counted is drawn again: the count follows the pixels, and not too often.
        if number % 50 == 49 or number == count - 1:
            pool.flush()
            done.write_text(str(number + 1), encoding="utf-8", newline="\n")
        tell(number + 1)
    return pool


def drawing() -> list[Path]:
    """The modules by which the pixels of views are told."""
    here = Path(__file__).parent
    package = here.parent
    others = [*sorted((package / "cameras").glob("*.py")), package / "colour.py", package / "ground.py"]
    return [*(here / f"{name}.py" for name in DRAWS), *others]


@lru_cache(maxsize=1)
def _drawn_with() -> str:
    """Hash of what draws: code, and the libraries, which may differ in the last bit."""
    told = hashlib.sha256(f"{np.__version__} {cv2.__version__} {scipy.__version__}".encode())
    for module in drawing():
        told.update(module.read_bytes())
    return told.hexdigest()[:12]


def _there(path: Path, done: Path, shape: tuple[int, ...]) -> int:
    """How many views a file holds; none where it is not whole or nothing tells of it."""
    try:
        counted = int(done.read_text(encoding="utf-8"))
        pool = np.lib.format.open_memmap(path, "r")
        whole = (pool.shape, pool.dtype) == (shape, np.uint8) and pool.nbytes < path.stat().st_size
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
    crew = ProcessPoolExecutor(workers, get_context("spawn"), _alone)
    try:
        tasks = [(number, seed) for number in numbers]
        yield from zip(numbers, crew.map(_view, tasks, chunksize=2), strict=True)
    finally:
        crew.shutdown(cancel_futures=True)


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
