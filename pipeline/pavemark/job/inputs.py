"""What a job starts from: images that become plates, or a folder of plates that are made already."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark.background import cache
from pavemark.background.finding import SEGMENTERS
from pavemark.background.index import Entry, index
from pavemark.background.inpainting import inpainter
from pavemark.background.plates import is_kept, make_plate
from pavemark.background.stock import RECORD, ROWS, stock
from pavemark.compose import optics
from pavemark.errors import InputError
from pavemark.job.config import Inputs, Job
from pavemark.plate import Plate
from pavemark.randomize.optics import Blur

LONELY = 20
"""Files without a partner that are told by name; a wrong folder of masks leaves thousands."""

SAME_SCALE = 1e-6
"""Share by which two scales may differ: metres per pixel are written with few digits."""


class UnusableImage(InputError):
    """An image of the batch, or its mask, is bad: the others can still be made."""


def settled(job: Job) -> Job:
    """The job with its scale: that of the plates, where it starts from such.

    Raises
    ------
    InputError
        When the folder of plates cannot be read, or is of another scale than the job says.
    """
    if job.plates is None:
        return job
    scale = stock(Path(job.plates)).scale
    told = job.scale is not None or job.metres_per_pixel is not None
    if told and abs(job.pixels_per_metre / scale - 1) > SAME_SCALE:
        raise InputError(
            Path(job.plates) / RECORD,
            f"scale = {scale:g} pixels per metre there, {job.pixels_per_metre:g} in the job: leave it out of the job",
        )
    return attrs.evolve(job, scale=scale, metres_per_pixel=None)


def makers(inputs: Inputs) -> dict[str, Any]:
    """What makes the plates, as a record: the inpainter, and the segmenter where masks leave it something to find.

    Raises
    ------
    InputError
        When one of them cannot be used on this machine.
    """
    method, finder = inpainter(inputs.inpainter), SEGMENTERS[inputs.segmenter]
    complete = inputs.masks is not None and inputs.mask.ground is not None
    return {
        "inpainter": {"name": method.name, "version": method.version},
        "segmenter": None if complete else {"name": inputs.segmenter, "version": finder.version},
    }


def entries(inputs: Inputs) -> tuple[tuple[Entry, ...], list[str]]:
    """What a job can start from, and a line for each file that has no part in it.

    Raises
    ------
    InputError
        As `pavemark.background.index.index` and `pavemark.background.stock.Stock.index` do.
    """
    if isinstance(inputs, Job) and inputs.plates is not None:
        found, unknown = stock(Path(inputs.plates)).index()
        return found, _told([f"{path}: {ROWS} does not tell of it" for path in unknown])
    found, alone = index(Path(inputs.images), None if inputs.masks is None else Path(inputs.masks))
    missing = [(path, "image" if path.parent == Path(inputs.masks) else "mask") for path in alone]
    return found, _told([f"{path}: no {what} has its name" for path, what in missing])


def _told(lines: list[str]) -> list[str]:
    more = len(lines) - LONELY
    return [*lines[:LONELY], f"{more} more without a partner of their name"] if more > 0 else lines


def read_plate(image: Path, mask: Path | None, inputs: Inputs, ground: Path | None = None) -> Plate:
    """The plate of an entry; of `ground` see `make_plate`.

    Raises
    ------
    UnusableImage
        When the image, its mask or the plate cannot be used.
    """
    try:
        if isinstance(inputs, Job) and inputs.plates is not None:
            return stock(Path(inputs.plates)).plate(image.stem)
        scale, method = inputs.pixels_per_metre, inputs.inpainter
        return make_plate(image, mask, scale, inputs.mask, method, inputs.segmenter, ground)
    except InputError as error:
        if Path(error.where).stem == image.stem:
            raise UnusableImage(error.where, error.what) from None
        # What cannot be used may be at fault, as a network that fails: of which image is told all the same.
        raise UnusableImage(image, f"{Path(error.where).name}: {error.what}") from None


def kept(entry: Entry, inputs: Inputs) -> bool:
    """Whether the plate of an entry has been made and `read_plate` gives it at once.

    Raises
    ------
    InputError
        When the image or its mask cannot be read.
    """
    if isinstance(inputs, Job) and inputs.plates is not None:
        return True
    scale, method = inputs.pixels_per_metre, inputs.inpainter
    return is_kept(entry.image, entry.mask, scale, inputs.mask, method, inputs.segmenter)


def blur(plate: Plate) -> Blur:
    """The plate's blur, measured once and kept: it takes as long as an image's blend."""
    if plate.blur is not None:
        return plate.blur
    digest = hashlib.sha256(f"{optics.VERSION} {plate.frame}".encode())
    for array in (plate.source, np.packbits(plate.ground)):
        digest.update(np.ascontiguousarray(array))
    key = digest.hexdigest()
    kept = cache.load(key)
    if kept is None:
        kept = {"blur": np.array(optics.measure(plate))}
        cache.store(key, **kept)
    return tuple(tuple(row) for row in kept["blur"].tolist())
