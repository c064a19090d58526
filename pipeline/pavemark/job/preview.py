"""One contact sheet of a dataset: image, plate, labels drawn over, masks."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from pavemark import files
from pavemark.background.index import Entry, index
from pavemark.background.plates import make_plate
from pavemark.background.reading import read_image
from pavemark.errors import InputError
from pavemark.job.config import Job
from pavemark.job.folder import Folder, recorded
from pavemark.labels.truth import Truth, truth
from pavemark.plate import Plate
from pavemark.records import from_json
from pavemark.scene import Scene

MOST = 12
"""Images on a sheet."""

LARGEST = 3000
"""Pixels of the sheet's longer side."""

COLUMNS = ("image", "plate", "labels", "masks")

_GAP, _HEAD = 6, 22
_PAPER, _INK = (24, 24, 24), (235, 235, 235)
_T, _L, _ENTRANCE, _SIDE = (255, 64, 64), (64, 160, 255), (80, 255, 120), (255, 210, 60)


def preview(out: Path) -> Path:
    """Draw OUT/preview.png: up to 12 images, spread evenly over those that are there.

    Returns
    -------
    Path
        Of the sheet.

    Raises
    ------
    InputError
        When the folder holds no finished image, or one that cannot be read.
    """
    job = recorded(out)
    folder = Folder.of(out, job)
    there = list(folder.finished())
    if not there:
        raise InputError(out, "holds no finished image yet: pavemark render makes them")
    chosen = [there[k] for k in np.linspace(0, len(there) - 1, min(MOST, len(there))).round().astype(int)]
    path = out / "preview.png"
    files.write(path, files.png(_sheet([_Sample(number, job, folder) for number in chosen])))
    return path


class _Sample:
    """A finished image and what is shown of it."""

    def __init__(self, number: int, job: Job, folder: Folder) -> None:
        paths = folder.paths(number)
        self.number = number
        self.scene = from_json(Scene, paths["scene"])
        self.image = read_image(paths["image"])
        self.lines = _mask(paths["mask"])
        self.slots = _mask(paths["slots"])
        self.plate = _plate(self.scene, job)

    @property
    def truth(self) -> Truth:
        ground = np.ones(self.image.shape[:2], bool) if self.plate is None else self.plate.ground
        return truth(self.scene, ground)

    def tiles(self, scale: float) -> list[np.ndarray]:
        """The four pictures, enlarged or reduced."""
        plate = np.full_like(self.image, 48) if self.plate is None else self.plate.image
        return [
            _scaled(self.image, scale),
            _scaled(plate, scale),
            _labelled(_scaled(self.image, scale), self.truth, scale),
            _masked(self.lines, self.slots, scale),
        ]


def _sheet(samples: list[_Sample]) -> np.ndarray:
    height = max(sample.image.shape[0] for sample in samples)
    width = max(sample.image.shape[1] for sample in samples)
    across, scale = max(
        ((across, _fitting(len(samples), across, width, height)) for across in range(1, len(samples) + 1)),
        key=lambda choice: choice[1],
    )
    box = (math.ceil(width * scale), math.ceil(height * scale))
    strip = len(COLUMNS) * (box[0] + _GAP) + 2 * _GAP
    down = math.ceil(len(samples) / across)
    sheet = np.full((down * (box[1] + _HEAD + _GAP), across * strip, 3), _PAPER, np.uint8)
    for k, sample in enumerate(samples):
        top, left = k // across * (box[1] + _HEAD + _GAP), k % across * strip + _GAP
        for column, (name, tile) in enumerate(zip(COLUMNS, sample.tiles(scale), strict=True)):
            x = left + column * (box[0] + _GAP)
            told = f"{sample.number} {sample.scene.plate.name}" if column == 0 else name
            _text(sheet[top : top + _HEAD, x : x + box[0]], told, (2, 15), _INK)
            sheet[top + _HEAD : top + _HEAD + tile.shape[0], x : x + tile.shape[1]] = tile
    return sheet


def _fitting(count: int, across: int, width: int, height: int) -> float:
    """The scale at which so many strips in a row fill the sheet; whole above 1, so that pixels stay square."""
    down = math.ceil(count / across)
    wide = (LARGEST / across - (len(COLUMNS) + 2) * _GAP) / (len(COLUMNS) * width)
    high = (LARGEST / down - _HEAD - _GAP) / height
    scale = min(wide, high, 4.0)
    return float(math.floor(scale)) if scale >= 1 else scale


def _scaled(image: np.ndarray, scale: float) -> np.ndarray:
    size = (math.ceil(image.shape[1] * scale), math.ceil(image.shape[0] * scale))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)


def _labelled(tile: np.ndarray, true: Truth, scale: float) -> np.ndarray:
    """Slots numbered, entrance lines, sides, and marking points with their direction: red T, blue L."""
    tile = np.ascontiguousarray(tile)
    reach = max(14.0, 0.06 * max(tile.shape))
    for number, slot in enumerate(true.slots, 1):
        corners = np.array(slot.corners) * scale
        for a, b in ((1, 2), (3, 0)):
            _stroke(tile, corners[a], corners[b], _SIDE, 1)
        _stroke(tile, corners[0], corners[1], _ENTRANCE if slot.paired else _SIDE, 2)
        inside = corners.mean(0) if slot.region.is_empty else np.array(slot.region.centroid.coords[0]) * scale
        _text(tile, str(number), (int(inside[0]) - 4, int(inside[1]) + 4), _INK)
    for mark in true.marks:
        if mark.visible:
            point = np.array(mark.point) * scale
            colour = _T if mark.shape == "T" else _L
            cv2.arrowedLine(
                tile,
                _fixed(point),
                _fixed(point + reach * np.array(mark.direction)),
                colour,
                2,
                cv2.LINE_AA,
                _SHIFT,
                0.3,
            )
            cv2.circle(tile, _fixed(point), 4 << _SHIFT, colour, -1, cv2.LINE_AA, _SHIFT)
    return tile


def _masked(lines: np.ndarray, slots: np.ndarray, scale: float) -> np.ndarray:
    """Slots each in a colour, lines in white."""
    hue = (slots.astype(np.int64) * 67 % 180).astype(np.uint8)
    filled = np.where(slots > 0, 150, 0).astype(np.uint8)
    colours = cv2.cvtColor(np.dstack([hue, filled, filled]), cv2.COLOR_HSV2RGB)
    colours[lines > 0] = 255
    return _scaled(colours, scale)


_SHIFT = 4


def _fixed(point: np.ndarray) -> tuple[int, int]:
    # cv2 counts from the centre of the first pixel.
    x, y = np.clip((point - 0.5) * (1 << _SHIFT), -(2**24), 2**24).round().astype(int)
    return int(x), int(y)


def _stroke(tile: np.ndarray, start: np.ndarray, end: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
    cv2.line(tile, _fixed(start), _fixed(end), colour, width, cv2.LINE_AA, _SHIFT)


def _text(tile: np.ndarray, text: str, at: tuple[int, int], colour: tuple[int, int, int]) -> None:
    for ink, width in ((_PAPER, 3), (colour, 1)):
        cv2.putText(tile, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, ink, width, cv2.LINE_AA)


def _mask(path: Path) -> np.ndarray:
    mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if mask is None:
        raise InputError(path, "is not an image")
    return mask


def _plate(scene: Scene, job: Job) -> Plate | None:
    """The scene's plate, from the cache or made anew; None where its image is gone or has changed."""
    names = _by_name(job)
    if scene.plate.name not in names:
        return None
    entry = names[scene.plate.name]
    try:
        plate = make_plate(entry.image, entry.mask, job.pixels_per_metre, job.mask, job.inpainter)
    except InputError:
        return None
    return plate if plate.sha256 == scene.plate.sha256 else None


@lru_cache(maxsize=1)
def _by_name(job: Job) -> dict[str, Entry]:
    try:
        entries, _ = index(Path(job.images), None if job.masks is None else Path(job.masks))
    except InputError:
        return {}
    return {entry.name: entry for entry in entries}
