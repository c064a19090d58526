"""One contact sheet of a dataset: image, plate, labels drawn over, masks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from pavemark import files
from pavemark.background.index import Entry
from pavemark.background.reading import read_image
from pavemark.errors import InputError
from pavemark.job.config import Job
from pavemark.job.contact_sheet import INK, drawn, scaled, spread, text
from pavemark.job.folder import Folder, recorded
from pavemark.job.inputs import entries, read_plate
from pavemark.labels.truth import Truth, truth
from pavemark.plate import Plate
from pavemark.records import from_json
from pavemark.scene import Scene

MOST = 12
"""Images on a sheet."""

COLUMNS = ("image", "plate", "labels", "masks")

_T, _L, _ENTRANCE, _SIDE = (255, 64, 64), (64, 160, 255), (80, 255, 120), (255, 210, 60)


def preview(out: Path, sheet: Path | None = None, kept: Iterable[str] | None = None) -> Path:
    """Draw a contact sheet: up to 12 images, spread evenly over those that are there.

    Parameters
    ----------
    out : Path
        The folder of a job.
    sheet : Path, optional
        The sheet; OUT/preview.png without.
    kept : iterable of str, optional
        Names of the images to draw from, without folder and suffix, in a folder that need not tell what was finished;
        all that are finished without.

    Returns
    -------
    Path
        Of the sheet.

    Raises
    ------
    InputError
        When the folder holds no finished image, none that is kept, or one that cannot be read.
    """
    job = recorded(out)
    folder = Folder.of(out, job)
    if kept is None:
        there = list(folder.finished())
        if not there:
            raise InputError(out, "holds no finished image yet: pavemark render makes them")
    else:
        there = sorted(folder.whole().intersection(int(name) for name in kept if name.isascii() and name.isdigit()))
        if not there:
            raise InputError(out, "holds none of the images that are kept: select from it anew")
    path = sheet or out / "preview.png"
    strips = [_Sample(number, job, folder) for number in spread(there, MOST)]
    files.write(path, files.png(drawn(strips, COLUMNS)))
    return path


class _Sample:
    """A finished image and what is shown of it."""

    def __init__(self, number: int, job: Job, folder: Folder) -> None:
        self._job = job
        self._paths = folder.paths(number)
        self._scene = from_json(Scene, self._paths["scene"])
        frame = self._scene.plate.frame
        self.title = f"{number} {self._scene.plate.name}"
        self.size = (frame.width, frame.height)

    def tiles(self, scale: float) -> Sequence[np.ndarray]:
        """See `pavemark.job.contact_sheet.Strip.tiles`."""
        image = read_image(self._paths["image"])
        lines, slots = (_mask(self._paths[what]) for what in ("mask", "slots"))
        plate = _plate(self._scene, self._job)
        ground = np.ones(image.shape[:2], bool) if plate is None else plate.ground
        return [
            scaled(image, scale),
            scaled(np.full_like(image, 48) if plate is None else plate.image, scale),
            _labelled(scaled(image, scale), truth(self._scene, ground), scale),
            _masked(lines, slots, scale),
        ]


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
        text(tile, str(number), (int(inside[0]) - 4, int(inside[1]) + 4), INK)
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
    return scaled(colours, scale)


_SHIFT = 4


def _fixed(point: np.ndarray) -> tuple[int, int]:
    # cv2 counts from the centre of the first pixel.
    x, y = np.clip((point - 0.5) * (1 << _SHIFT), -(2**24), 2**24).round().astype(int)
    return int(x), int(y)


def _stroke(tile: np.ndarray, start: np.ndarray, end: np.ndarray, colour: tuple[int, int, int], width: int) -> None:
    cv2.line(tile, _fixed(start), _fixed(end), colour, width, cv2.LINE_AA, _SHIFT)


def _mask(path: Path) -> np.ndarray:
    # OpenCV would read the file itself, but on Windows no path that is not of the local code page.
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    mask = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if data.size else None
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
        plate = read_plate(entry.image, entry.mask, job)
    except InputError:
        return None
    return plate if plate.sha256 == scene.plate.sha256 else None


@lru_cache(maxsize=1)
def _by_name(job: Job) -> dict[str, Entry]:
    try:
        found, _ = entries(job)
    except InputError:
        return {}
    return {entry.name: entry for entry in found}
