"""Labelled images from datasets: those that Pavemark has made, selections of them, and lists of real ones."""

from __future__ import annotations

import json
import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, NoReturn

import attrs
import numpy as np

from pavemark.background.reading import read_image
from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.records import read_json

SELECTION = "selection.json"
"""The record of a selection; its `dataset` is the folder, from here, in which the kept images lie."""

MANIFEST = "manifest.jsonl"
LISTED = "labels.jsonl"

AT_A_TIME = 16
"""Images whose labels are read at a time: a drive far off answers late, but many questions at once."""

OPTIONAL = ("curvature", "relief", "shadows", "wet", "glare", "brightness", "noise")
"""Effects that tell the domain of an image; the others are in every image, or in the plate."""


@attrs.frozen(eq=False)
class Unlabelled:
    """An image that Pavemark made and whose labels cannot be read.

    Attributes
    ----------
    name : str
        As of an `Example`.
    fault : InputError
        Why.
    """

    name: str
    fault: InputError


def examples(
    dataset: Path,
    height: float | None = None,
    only: Callable[[int, str], bool] = lambda row, name: True,
) -> Iterator[Example]:
    """The labelled images of a dataset, one after the other, in its own order.

    Parameters
    ----------
    dataset : Path
        A folder with `job.json` and `manifest.jsonl`, as `pavemark render` leaves it, with DMPR labels; a folder that
        `pavemark select` wrote; or a folder with `labels.jsonl`, a line an image: `image` (path from the folder), `w`,
        `h`, `points` ([[u, v], …], pixels, continuous), and any of `scale` (pixels per metre), `place`, `scene` and
        `side`.
    height : float or None
        Metres that the height of a picture spans, for lines of a `labels.jsonl` without `scale`.
    only : callable
        Told the row of an image in the list, from 0, and its name: whether it is wanted. The labels of others are not
        opened.

    Yields
    ------
    Example
        `name` is the path of its image in the dataset without suffix. No picture is opened, and no more than
        AT_A_TIME lines are held.

    Raises
    ------
    InputError
        When it is no dataset, has no image, lacks labels, or a line of it is not what it should be.
    """
    for example in examples_or_faults(dataset, height, only):
        if isinstance(example, Unlabelled):
            raise example.fault
        yield example


def examples_or_faults(
    dataset: Path,
    height: float | None = None,
    only: Callable[[int, str], bool] = lambda row, name: True,
) -> Iterator[Example | Unlabelled]:
    """The same, for who can do without some of them: in place of an image whose labels cannot be read, why."""
    dataset = Path(dataset)
    if not dataset.is_dir():
        raise InputError(dataset, "is no folder: a dataset is allowed")
    if (dataset / SELECTION).exists():
        found = _made(source(dataset), dataset / MANIFEST, only)
    elif (dataset / "job.json").exists():
        found = _made(dataset, dataset / MANIFEST, only)
    elif (dataset / LISTED).exists():
        found = (each for row, each in enumerate(_listed(dataset, height)) if only(row, each.name))
    else:
        raise InputError(
            dataset,
            f"has no job.json, {SELECTION} or {LISTED}: a folder that pavemark render or select wrote is allowed",
        )
    empty = True
    for example in found:
        empty = False
        yield example
    if empty:
        raise InputError(dataset, "holds no image: at least one is needed")


def count(dataset: Path) -> int:
    """How many images a dataset has, from its list alone.

    Raises
    ------
    InputError
        When it has no list.
    """
    dataset = Path(dataset)
    ours = (dataset / SELECTION).exists() or (dataset / "job.json").exists()
    return sum(1 for _ in lines(dataset / (MANIFEST if ours else LISTED)))


def manifest(dataset: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names of the images of a dataset that Pavemark made, or of a selection, with their lines of the manifest.

    No label and no picture is opened.

    Raises
    ------
    InputError
        When it has no manifest, or a line of it is not what it should be.
    """
    path = Path(dataset) / MANIFEST
    for number, line in lines(path):
        yield _name(_image_of(line, path, number)), line


def source(dataset: Path) -> Path:
    """The folder in which the images of a dataset lie: for a selection, that of the dataset it was made from.

    Raises
    ------
    InputError
        When the record of a selection does not tell.
    """
    record = Path(dataset) / SELECTION
    if not record.exists():
        return Path(dataset)
    told = read_json(record)
    folder = told.get("dataset") if isinstance(told, dict) else None
    if not isinstance(folder, str):
        raise InputError(record, f"dataset = {folder!r}: the folder of the dataset, from here, is allowed")
    return Path(os.path.normpath(Path(dataset) / folder))


def picture(example: Example) -> np.ndarray:
    """The picture of a labelled image.

    Returns
    -------
    ndarray (H, W, 3) uint8
        RGB, display.

    Raises
    ------
    InputError
        When it cannot be read, or has another size than its labels say.
    """
    pixels = read_image(example.image)
    if pixels.shape[:2] != (example.frame.height, example.frame.width):
        raise InputError(
            example.image,
            f"is {pixels.shape[1]}×{pixels.shape[0]} px: {example.frame.width}×{example.frame.height}, "
            "as its labels say, is allowed",
        )
    return pixels


def of_both(one: Iterable[Example], other: Iterable[Example]) -> Iterator[Example]:
    """Those of one whose picture is a picture of the other, too: the same file, under whatever name or by a link."""
    seen = {_file(example.image) for example in other} - {None}
    return (example for example in one if _file(example.image) in seen)


def _file(path: Path) -> tuple[int, int] | None:
    """What a file system tells a file by; None where there is none."""
    try:
        there = path.stat()
    except OSError:
        return None
    return there.st_dev, there.st_ino


def _made(folder: Path, manifest: Path, only: Callable[[int, str], bool]) -> Iterator[Example | Unlabelled]:
    record = folder / "job.json"
    told = read_json(record)
    if not isinstance(told, dict):
        raise InputError(record, "is not the record of a job")
    formats = told.get("formats", [])
    if "dmpr" not in formats:
        raise InputError(record, f'formats = {formats}: "dmpr" among them is needed, for marking points and slots')

    def wanted() -> Iterator[Callable[[], Example | Unlabelled]]:
        try:
            for row, (number, line) in enumerate(lines(manifest)):
                name = _image_of(line, manifest, number)
                if only(row, _name(name)):
                    yield partial(_example, folder, name, line)
        except InputError as fault:
            # It is told in its turn: what comes before it in the list is read.
            yield partial(_refuse, fault)

    with ThreadPoolExecutor(AT_A_TIME) as crew:
        ahead = deque()
        for each in wanted():
            ahead.append(crew.submit(each))
            if len(ahead) > AT_A_TIME:
                yield ahead.popleft().result()
        while ahead:
            yield ahead.popleft().result()


def _refuse(fault: InputError) -> NoReturn:
    raise fault


def _example(folder: Path, name: str, line: dict[str, Any]) -> Example | Unlabelled:
    """An image that Pavemark made, by its name and its line of the manifest."""
    stem = PurePosixPath(name).stem
    try:
        points, directions, l_shaped, slots = _dmpr(folder / "labels" / "dmpr" / f"{stem}.json")
        frame, groups = _scene(folder / "scenes" / f"{stem}.json")
    except InputError as fault:
        return Unlabelled(_name(name), fault)
    return Example(
        name=_name(name),
        image=folder / name,
        frame=frame,
        points=points,
        directions=directions,
        l_shaped=l_shaped,
        slots=slots,
        groups={"plate": str(line.get("input", "")), **groups},
        # The real image may tell its marking points, but no label of this one does.
        known="original" not in groups["kind"].split("+"),
    )


def _name(image: str) -> str:
    return str(PurePosixPath(image).with_suffix(""))


def _image_of(line: dict[str, Any], manifest: Path, number: int) -> str:
    files = line.get("files")
    if not isinstance(files, dict):
        raise InputError(f"{manifest}:{number}", "files: a table of names is allowed")
    names = [name for name in files if name.startswith("images/") and ".." not in PurePosixPath(name).parts]
    if len(names) != 1:
        raise InputError(f"{manifest}:{number}", "files: exactly one image among them is allowed")
    return names[0]


def _scene(path: Path) -> tuple[Frame, dict[str, str]]:
    scene = read_json(path)
    try:
        # A scene leaves out what has its default.
        frame = Frame(**scene["plate"].get("frame", {}))
        kinds = {slot["kind"] for slot in scene.get("slots", ())}
        kinds |= {"original" for marking in scene.get("markings", ()) if marking["kind"] == "original"}
        shown = [name for name in OPTIONAL if scene.get(name) is not None]
        kind = "+".join(sorted(kinds)) or "none"
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        fault = f"{type(error).__name__}: {error}"
        raise InputError(path, f"is no scene as pavemark render writes it: {fault}") from None
    return frame, {"domain": "+".join(shown) or "base", "kind": kind}


def _dmpr(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points, directions, L or not, and slots; DMPR counts pixels from the centre of the first, which is 1."""
    told = read_json(path)
    try:
        marks, slots = _rows(told["marks"], 5), _rows(told["slots"], 4)[:, :2]
    except (KeyError, OverflowError, TypeError, ValueError):
        raise InputError(
            path, "marks and slots: lists of [x, y, x_dir, y_dir, shape] and [i, j, type, angle]"
        ) from None
    arms = marks[:, 2:4] - marks[:, :2]
    lengths = np.linalg.norm(arms, axis=1)
    if not (np.isfinite(marks).all() and lengths.all()):
        raise InputError(path, "marks: finite numbers, with a direction, are allowed")
    if slots.size and not (np.isin(slots, np.arange(1, len(marks) + 1)).all() and (slots[:, 0] != slots[:, 1]).all()):
        raise InputError(path, f"slots: pairs of two different marks, 1 to {len(marks)}, are allowed")
    return marks[:, :2] - 0.5, arms / lengths[:, None], marks[:, 4] == 1, slots.astype(np.int64) - 1


def _listed(dataset: Path, height: float | None) -> Iterator[Example]:
    path = dataset / LISTED
    for number, line in lines(path):
        where = f"{path}:{number}"
        name, width, tall = (_field(line, field, where) for field in ("image", "w", "h"))
        scale = line.get("scale")
        if scale is None:
            if height is None:
                raise InputError(where, "has no scale: pixels per metre there, or the height of the pictures in metres")
            scale = tall / height
        elif not isinstance(scale, (int, float)) or isinstance(scale, bool):
            raise InputError(where, f"scale = {scale!r}: pixels per metre are allowed")
        try:
            frame = Frame(width, tall, scale)
        except (TypeError, ValueError) as error:
            raise InputError(where, f"{error}") from None
        try:
            points = _rows(_field(line, "points", where), 2)
        except (TypeError, ValueError):
            raise InputError(where, "points: a list of [u, v] is allowed") from None
        if not all(map(math.isfinite, points.ravel())):
            raise InputError(where, "points: finite numbers are allowed")
        _hold_within(points, frame, f"{where}: points")
        if not PurePosixPath(name).name:
            raise InputError(where, f"image = {name!r}: the path of a picture, from the folder, is allowed")
        groups = {group: line[group] for group in ("place", "scene", "side") if line.get(group) is not None}
        for group, value in groups.items():
            if not isinstance(value, (str, int, float)):
                raise InputError(where, f"{group} = {value!r}: a name is allowed")
        yield Example(
            name=_name(name),
            image=dataset / name,
            frame=frame,
            points=points,
            directions=None,
            l_shaped=None,
            slots=None,
            groups={group: str(value) for group, value in groups.items()},
        )


def hold_labelled(example: Example) -> None:
    """Hold that the marking points of an image are labelled, and within the picture: others may have written there.

    Raises
    ------
    InputError
        When one lies outside, or none is known.
    """
    if not example.known:
        raise InputError(example.image, "shows its plate's own markings painted anew: no label tells their points")
    _hold_within(example.points, example.frame, f"labels of {example.image}")


def _hold_within(points: np.ndarray, frame: Frame, where: str) -> None:
    outside = ~((points >= 0) & (points <= (frame.width, frame.height))).all(1)
    if outside.any():
        u, v = points[outside][0]
        raise InputError(where, f"({u:g}, {v:g}): within the picture of {frame.width}×{frame.height} is allowed")


def _rows(told: Any, length: int) -> np.ndarray:
    """Rows of numbers, or a single one, (N, length) float64; a ValueError for other lengths: no row is cut anew."""
    rows = np.array(told, np.float64)
    if rows.shape not in ((0,), (length,)) and rows.shape[1:] != (length,):
        raise ValueError(f"{rows.shape}")
    return rows.reshape(-1, length)


def _field(line: dict[str, Any], field: str, where: str) -> Any:
    kinds = {"image": str, "w": int, "h": int, "points": list}
    value = line.get(field)
    if not isinstance(value, kinds[field]) or isinstance(value, bool):
        raise InputError(where, f"{field} = {value!r}: {kinds[field].__name__} is allowed")
    return value


def lines(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Lines of a file of JSON records, with their numbers from 1."""
    try:
        # Editors of some systems put a byte order mark before the text.
        with path.open(encoding="utf-8-sig") as file:
            for number, text in enumerate(file, 1):
                if not text.strip():
                    continue
                try:
                    line = json.loads(text)
                except ValueError:
                    line = None
                if not isinstance(line, dict):
                    raise InputError(f"{path}:{number}", "is no JSON record: a line an image is allowed")
                yield number, line
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path, "is not UTF-8: a line of JSON an image is allowed") from None
