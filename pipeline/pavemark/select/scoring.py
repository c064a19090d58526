"""The point loss of every image of a dataset, kept shard by shard, so that a run that was stopped goes on."""

from __future__ import annotations

import importlib.metadata
import itertools
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

import attrs
import cv2
import numpy as np

from pavemark import __version__, files
from pavemark.detect import reading
from pavemark.detect.detection import Detector
from pavemark.detect.example import Example
from pavemark.detect.reading import Unlabelled
from pavemark.errors import InputError
from pavemark.select import shards
from pavemark.select.origin import dataset_hash, mark, selection_hash
from pavemark.select.point_loss import point_loss
from pavemark.select.shards import Origin, Row

ROWS = 1024
"""Images of a shard, in the order of the dataset. What is stopped loses at most so many."""


class Watcher(Protocol):
    """Told how far it is; `pavemark.job.progress.Progress` is one."""

    def of(self, total: int) -> AbstractContextManager:
        """Entered while `total` images are scored."""

    def step(self, lacking: bool) -> None:
        """One image is scored, or will be lacking."""

    def tell(self, line: str) -> None:
        """Report what goes wrong."""


@attrs.frozen
class Outcome:
    """What came of a run.

    Attributes
    ----------
    images : int
        Images of the part that was asked for.
    made : int
        Scored now; the others had been before, or lack.
    lacking : int
        Images that cannot be scored.
    """

    images: int
    made: int
    lacking: int


def score(
    dataset: Path,
    opened: Callable[[], Detector],
    out: Path,
    watcher: Watcher,
    workers: int = 1,
    part: tuple[int, int] = (0, 1),
    height: float | None = None,
) -> Outcome:
    """Score what a folder of shards still lacks.

    Parameters
    ----------
    dataset : Path
        As `pavemark.detect.reading.examples` takes it.
    opened : callable
        Opens the detector; once a thread, for no two of them ask the same one.
    out : Path
        Folder of the shards. The bytes of a shard depend on its images, the detector and the libraries' versions
        alone.
    watcher : Watcher
    workers : int
        Threads: onnxruntime and what decodes images let others run.
    part : tuple of int
        (K, N): the shards whose number leaves the remainder K when divided by N.
    height : float or None
        As `examples` takes it.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        When the dataset cannot be read, the detector is of no use, the folder cannot be written or holds scores of
        another dataset, of another detector or by other versions, or none of the images can be scored.
    """
    detector = opened()
    origin = _origin(dataset, detector)
    files.writable(out)
    files.sweep(out)
    kept = _Kept(out, origin, watcher)
    count = reading.count(dataset)
    if not count:
        raise InputError(dataset, "holds no image: at least one is needed")
    mine = range(part[0], -(-count // ROWS), part[1])
    images = sum(min(ROWS, count - number * ROWS) for number in mine)
    kept.drop_beyond(mine, part)
    before = sum(len(kept.rows(number, loud=True)) for number in mine)
    judge = _Judge(opened)
    made, lacking, empty = 0, 0, []
    with watcher.of(max(0, images - before)), _threads(workers) as pool:
        for number, span in _spans(_of(dataset, height, mine), mine):
            there = kept.rows(number)
            here = {row.mark: row for row in there}
            marks = list(pool(_marked, span))
            missing = [example for example, each in zip(span, marks, strict=True) if each not in here]
            fresh: dict[str, Row] = {}
            for example, result in zip(missing, pool(judge.row, missing), strict=True):
                if isinstance(result, Row):
                    fresh[example.name] = result
                else:
                    watcher.tell(f"not scored: {result}")
                watcher.step(lacking=not isinstance(result, Row))
            rows = [here.get(each) or fresh.get(example.name) for example, each in zip(span, marks, strict=True)]
            rows = [row for row in rows if row is not None]
            _hold_alike(rows, dataset)
            made, lacking = made + len(fresh), lacking + len(span) - len(rows)
            if not rows:
                empty.append(shards.path_of(out, number))
            elif [row.mark for row in rows] != [row.mark for row in there]:  # others, or in another order
                shards.write(shards.path_of(out, number), number, rows, origin)
    if lacking == images and images:
        raise InputError(dataset, f"none of its {images} images can be scored")
    for path in empty:
        path.unlink(missing_ok=True)  # it was broken, or has scores of what can no longer be read
    return Outcome(images, made, lacking)


def versions() -> dict[str, str]:
    """Of the libraries that scores depend on: scores by others are not mixed with these."""
    told = {"pavemark": __version__, "numpy": np.__version__, "opencv": cv2.__version__}
    return told | {"onnxruntime": importlib.metadata.version("onnxruntime")}


def _origin(dataset: Path, detector: Detector) -> Origin:
    return Origin(detector.version, detector.family, dataset_hash(dataset), selection_hash(dataset), versions())


@attrs.frozen
class _Kept:
    """The shards that a folder holds already."""

    out: Path
    origin: Origin
    watcher: Watcher

    def rows(self, number: int, loud: bool = False) -> list[Row]:
        """The rows of a shard; none where it is not there or broken."""
        path = shards.path_of(self.out, number)
        if not path.exists():
            return []
        try:
            there, rows = shards.rows(path, number)
        except shards.Broken as fault:
            if loud:
                self.watcher.tell(f"{path}: is no whole shard and is made anew: {fault}")
            return []
        if there != self.origin:
            raise InputError(path, f"holds scores {_differing(there, self.origin)}; use another folder")
        return rows

    def drop_beyond(self, mine: range, part: tuple[int, int]) -> None:
        """Remove shards of this part beyond the end of a dataset that has become smaller."""
        for number, path in shards.there(self.out).items():
            if number % part[1] == part[0] and number not in mine:
                self.rows(number)  # those of another origin are not ours to remove
                path.unlink()
                self.watcher.tell(f"{path}: the dataset has become smaller, and it is removed")


def _differing(there: Origin, here: Origin) -> str:
    for field, what in (("model", "of another detector"), ("dataset", "of another dataset")):
        if getattr(there, field) != getattr(here, field):
            return f"{what}, {getattr(there, field)[:12]}, and this is {getattr(here, field)[:12]}"
    if there.listed != here.listed:
        return "of another selection of this dataset"
    return f"made with other versions, {there.versions}, and these are {here.versions}"


@attrs.frozen
class _Judge:
    """Scores an image at a time, from several threads."""

    opened: Callable[[], Detector]
    own: threading.local = attrs.field(factory=threading.local)

    def row(self, example: Example | Unlabelled) -> Row | InputError:
        """The row of an image, or why the image has none; a detector that is of no use is raised."""
        if isinstance(example, Unlabelled):
            return example.fault
        if not hasattr(self.own, "detector"):
            self.own.detector = self.opened()
        try:
            reading.hold_labelled(example)
            picture = reading.picture(example)
        except InputError as error:
            return error
        detector, frame = self.own.detector, example.frame
        grid, seen = detector.look(picture, frame)
        grid = _checked(grid, (None, None, 3), "grid", example, detector)
        seen = _checked(seen, (None,), "embedding", example, detector)
        try:
            loss = point_loss(example.points, detector.covered(frame), grid)
        except ValueError as error:  # the grid is what it should be, so it is the labels
            return InputError(example.image, str(error))
        return Row(example.name, loss, dict(example.groups), tuple(np.float32(seen).tolist()), mark(example))


def _checked(
    found: np.ndarray, sides: tuple[int | None, ...], what: str, example: Example, detector: Detector
) -> np.ndarray:
    """What a detector finds, if it is an array of finite numbers with such sides, None for any."""
    found = np.asarray(found, np.float64)
    alike = found.ndim == len(sides) and all(
        want in (None, side) for want, side in zip(sides, found.shape, strict=True)
    )
    where = f"detector {detector.family} {detector.version[:12]}"
    if not (alike and found.size):
        allowed = ", ".join("any" if side is None else str(side) for side in sides)
        raise InputError(where, f"{what} of {example.name} has the shape {list(found.shape)}: [{allowed}] is allowed")
    if not np.isfinite(found).all():
        raise InputError(where, f"{what} of {example.name} holds NaN or infinite values: the model is of no use")
    return found


def _marked(example: Example | Unlabelled) -> bytes | None:
    return None if isinstance(example, Unlabelled) else mark(example)


def _of(dataset: Path, height: float | None, mine: range) -> Iterator[Example | Unlabelled]:
    """The images of the shards of this part: the labels of others are not opened."""
    return reading.examples_or_faults(dataset, height, only=lambda row, _: row // ROWS in mine)


def _spans(examples: Iterable[Example | Unlabelled], mine: range) -> Iterator[tuple[int, list[Example | Unlabelled]]]:
    """The images of each shard of this part, one shard's at a time."""
    examples = iter(examples)
    for number in mine:
        yield number, list(itertools.islice(examples, ROWS))


@contextmanager
def _threads(workers: int) -> Iterator[Callable]:
    """A map over threads; what waits is dropped when something goes wrong."""
    pool = ThreadPoolExecutor(workers)
    try:
        yield pool.map
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _hold_alike(rows: Sequence[Row], dataset: Path) -> None:
    """Hold that no image of a shard stands twice, which `pavemark select` holds across shards, and all look alike."""
    names: set[str] = set()
    for row in rows:
        if row.name in names:
            raise InputError(dataset, f"{row.name}: is listed twice: once is allowed")
        names.add(row.name)
        if len(row.embedding) != len(rows[0].embedding):
            what = f"the embedding of {row.name} has {len(row.embedding)} numbers"
            raise InputError(dataset, f"{what}: {len(rows[0].embedding)}, as that of {rows[0].name}, are allowed")
