"""A real image and its mask become a clean plate."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from pathlib import Path

import attrs
import cv2
import numpy as np

from pavemark.background import cache
from pavemark.background.ego import ego_car
from pavemark.background.finding import SEGMENTERS, classes, mended
from pavemark.background.inpainting import inpainter
from pavemark.background.ratios import reflectance_ratios
from pavemark.background.reading import MaskTable, read_image
from pavemark.background.roadside import find_roadside
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.plate import Plate, Roadside
from pavemark.records import unstructure
from pavemark.scene import PlateRef

VERSION = 4
"""Counted up with every change that makes other plates of the same input: plates in the cache are then made anew."""

SOFT_EDGE = 7 / 60
"""Metres by which the hole is wider than the mask. 4 pixels at 60 a metre clear the paint of an exact mask; hand-drawn
masks, the dark rims of sharpened video and the colour fringes of its compression reach 3 pixels further."""


@attrs.frozen
class _Source:
    """All that a plate is made from."""

    image: Path
    mask: Path | None
    scale: float
    table: MaskTable
    method: str
    segmenter: str = "network"
    ground: Path | None = None

    def key(self) -> str:
        """Hash of all that the plate's pixels depend on, the files by their content."""
        complete = self.mask is not None and (self.table.ground is not None or self.ground is not None)
        finder = None if complete else SEGMENTERS[self.segmenter].version
        settings = [VERSION, self.scale, unstructure(self.table), self.method, inpainter(self.method).version, finder]
        digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
        for path in (self.image, self.mask, self.ground):
            if path is not None:
                digest.update(hashlib.sha256(_bytes(path)).digest())
        return digest.hexdigest()


def make_plate(
    image: Path,
    mask: Path | None,
    scale: float,
    table: MaskTable,
    method: str,
    segmenter: str = "network",
    ground: Path | None = None,
) -> Plate:
    """Take the markings off an image.

    Plates are kept in a cache, by the content of the files: the same input is worked on once.

    Parameters
    ----------
    image : Path
        8-bit RGB, see `read_image`.
    mask : Path or None
        See `read_mask`. Without one the markings are looked for.
    scale : float
        Pixels per metre.
    table : MaskTable
        What the mask's values mean.
    method : str
        Name of an inpainter.
    segmenter : str
        What looks for the markings: one of `SEGMENTERS`.
    ground : Path or None
        A mask of 0 and 1 (ground). With it `mask` is one too, and neither the table nor the segmenter is asked.

    Returns
    -------
    Plate
        Its arrays are read-only: they are shared by all who ask for the same plate.

    Raises
    ------
    InputError
        When a file or the method is refused, there is no ground, or the markings leave none to fill them from.
    """
    inpainter(method)
    source = _Source(Path(image), None if mask is None else Path(mask), scale, table, method, segmenter, ground)
    return _plate(source, source.key())


def is_kept(image: Path, mask: Path | None, scale: float, table: MaskTable, method: str, segmenter: str) -> bool:
    """Whether `make_plate` has made this plate before, and will give it at once.

    Raises
    ------
    InputError
        When a file or the method is refused.
    """
    inpainter(method)
    return cache.holds(_Source(image, mask, scale, table, method, segmenter).key())


# The last few stay in memory: the panel redraws one plate over and over, a job turns to the next.
@lru_cache(maxsize=4)
def _plate(source: _Source, key: str) -> Plate:
    pixels = read_image(source.image)
    height, width = pixels.shape[:2]
    frame = _frame(source, width, height)
    kept = cache.load(key)
    if kept is None:
        kept = _made(source, pixels, frame)
        cache.store(key, **kept)
    markings, ground = (_unpacked(kept[name], (height, width)) for name in ("markings", "ground"))
    if not ground.any():
        # It would be the image with all its markings, in a dataset that labels none of them.
        told = source.ground or (source.mask if source.table.ground is not None else None)
        raise InputError(
            told or source.image, f"no ground is {'in' if told else 'found in'} it: some is needed for paint"
        )
    clean = pixels.copy()
    clean[_hole(markings, ground, frame)] = kept["filled"]
    for array in (pixels, clean, markings, ground):
        array.setflags(write=False)
    ratios = tuple((float(r), float(g), float(b)) for r, g, b in kept["ratios"])
    return Plate(source.image.stem, frame, clean, ground, markings, pixels, ratios, _roadside(kept["roadside"]))


def _frame(source: _Source, width: int, height: int) -> Frame:
    """The image's frame, once its name and scale are known to be allowed."""
    frame = Frame(width, height, source.scale)
    try:
        PlateRef(source.image.stem, "0" * 64, frame)
    except ValueError as error:
        raise InputError(source.image, str(error)) from None
    return frame


def _made(source: _Source, pixels: np.ndarray, frame: Frame) -> dict[str, np.ndarray]:
    """What is worked out of an image: which pixels are marking and ground, what fills the hole, the ratios."""
    if source.ground is not None:
        found = mended(source.mask, source.ground, pixels.shape[:2])
    else:
        found = classes(pixels, source.mask, source.table, SEGMENTERS[source.segmenter], frame)
    hole = _hole(found.marking, found.ground, frame)
    try:
        clean = inpainter(source.method).fill(pixels, hole, ~found.ground)
    except ValueError as error:
        where = source.image if source.mask is None else source.mask
        told = f"markings cover the whole ground ({error}): some bare ground is needed to fill them"
        raise InputError(where, told) from None
    roadside = find_roadside(found.marking, found.ground, ego_car(pixels, frame), frame)
    return {
        "markings": np.packbits(found.marking),
        "ground": np.packbits(found.ground),
        "filled": clean[hole],
        "ratios": np.array(reflectance_ratios(pixels, found.marking, hole, found.ground, frame)).reshape(-1, 3),
        # nan stands for a line that was not found.
        "roadside": np.array([] if roadside is None else attrs.astuple(roadside), np.float64),
    }


def _hole(markings: np.ndarray, ground: np.ndarray, frame: Frame) -> np.ndarray:
    """The markings with their soft edge, as far as they lie on the ground."""
    radius = max(2, round(SOFT_EDGE * frame.scale))
    return (cv2.dilate(markings.astype(np.uint8), np.ones((2 * radius + 1, 2 * radius + 1), np.uint8)) > 0) & ground


def _roadside(kept: np.ndarray) -> Roadside | None:
    return Roadside(*(None if np.isnan(value) else value for value in kept.tolist())) if len(kept) else None


def _unpacked(bits: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    return np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape).astype(bool)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
