"""The image that is painted on: which it is, and its plate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from pavemark.background.index import Entry
from pavemark.background.reading import read_image
from pavemark.background.stock import RECORD
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.job.config import Job
from pavemark.job.inputs import entries, kept, read_plate, settled
from pavemark.plate import Plate
from pavemark.records import structure

WHERE = "Background"


def tables(target: bpy.types.Scene) -> dict[str, Any]:
    """The background's settings as a job file would hold them.

    Raises
    ------
    InputError
        When no image is chosen, or the values of the masks are no numbers.
    """
    told = target.pavemark.background
    if not told.images:
        raise InputError(WHERE, "no image is chosen: choose an AVM image or a folder of them")
    images = _absolute(told.images)
    if (images / RECORD).is_file():
        return {"plates": str(images)}
    found = {
        "images": str(images),
        **_meant(told.metres_per_pixel),
        "inpainter": told.inpainter,
        "segmenter": told.segmenter,
    }
    if told.masks:
        ground = {"ground": _numbers(told.ground)} if told.ground.strip() else {}
        found |= {"masks": str(_absolute(told.masks)), "mask": {"marking": _numbers(told.marking)} | ground}
    return found


def job(target: bpy.types.Scene) -> Job:
    """A job that starts from the background, its domains left as they are.

    Raises
    ------
    InputError
        As `tables`, and when a setting is not allowed.
    """
    return settled(structure(Job, tables(target), WHERE))


def listed(target: bpy.types.Scene) -> dict[str, Entry]:
    """The images to choose from, by name.

    Raises
    ------
    InputError
        When there is none, or a folder cannot be read.
    """
    return {entry.name: entry for entry in entries(job(target))[0]}


def chosen(target: bpy.types.Scene) -> Entry:
    """The image that is painted on.

    Raises
    ------
    InputError
        When it is not there any more.
    """
    name, found = target.pavemark.background.name, listed(target)
    if name not in found:
        raise InputError(target.pavemark.background.images, f"{name} is not there any more: choose another image")
    return found[name]


def plate(target: bpy.types.Scene) -> Plate | None:
    """The plate of the chosen image; None until its markings have been removed.

    Raises
    ------
    InputError
        When the image or its mask is not there any more or cannot be used.
    """
    entry, inputs = chosen(target), job(target)
    return read_plate(entry.image, entry.mask, inputs) if kept(entry, inputs) else None


def picture(target: bpy.types.Scene) -> Plate:
    """The chosen image as it is, for the ground to show until there is a plate.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    entry = chosen(target)
    pixels = read_image(entry.image)
    frame = Frame(pixels.shape[1], pixels.shape[0], job(target).pixels_per_metre)
    nothing = np.zeros(pixels.shape[:2], bool)
    return Plate(entry.name, frame, pixels, nothing, nothing, pixels)


def show(target: bpy.types.Scene, told: Job) -> None:
    """Set the background's settings to those of a job."""
    shown = target.pavemark.background
    shown.images = told.plates or told.images
    shown.masks = told.masks or ""
    shown.marking = ", ".join(map(str, told.mask.marking))
    shown.ground = ", ".join(map(str, told.mask.ground or ()))
    shown.metres_per_pixel = 1 / told.pixels_per_metre
    shown.inpainter, shown.segmenter = told.inpainter, told.segmenter


def _absolute(path: str) -> Path:
    return Path(bpy.path.abspath(path)).absolute()


def _numbers(text: str) -> list[int]:
    try:
        return [int(word) for word in text.replace(",", " ").split()]
    except ValueError:
        raise InputError(WHERE, f"mask values {text!r}: whole numbers with commas between them are allowed") from None


def _meant(metres: float) -> dict[str, float]:
    """The scale that was meant by a number that Blender keeps in float32: of pixels per metre and metres per pixel the
    one that is shorter to write."""
    scales = filter(None, (round(1 / metres, digits) for digits in range(4)))
    scale = next((scale for scale in scales if np.float32(1 / scale) == np.float32(metres)), None)
    return {"metres_per_pixel": float(str(np.float32(metres)))} if scale is None else {"scale": scale}
