"""A worker that makes plates: the process that `pavemark plates` hires. It needs no Blender."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from pavemark import files
from pavemark.background.stock import Row, begun, paths
from pavemark.errors import InputError
from pavemark.job.config import Inputs
from pavemark.job.inputs import UnusableImage, blur, read_plate
from pavemark.job.worker import attend, versions
from pavemark.records import structure, to_json, unstructure


class Plates:
    """Clean backgrounds, from real images."""

    def __init__(self, setup: dict[str, Any]) -> None:
        self._inputs = structure(Inputs, setup["inputs"], "job")
        self._out = Path(setup["out"])
        self.versions = versions()

    def make(self, task: dict[str, Any]) -> dict[str, Any]:
        """See `pavemark.job.worker.Craft.make`."""
        image, mask = Path(task["image"]), None if task["mask"] is None else Path(task["mask"])
        written = paths(self._out, image.stem)
        given = {"image": image} if mask is None else {"image": image, "mask": mask}
        try:
            # Before they are read: what is done to them meanwhile is noticed the next time.
            stamps = {role: stamp(path) for role, path in given.items()}
            hashes = {role: sha256(path) for role, path in given.items()}
        except InputError as error:
            raise UnusableImage(error.where, error.what) from None
        if task["mended"]:
            plate = read_plate(image, written["masks"], self._inputs, written["ground"])
        else:
            plate = read_plate(image, mask, self._inputs)
        # Markings and ground first: where the plate is there, they are too.
        pictures = {"masks": plate.markings, "ground": plate.ground, "plates": plate.image}
        data = {written[kind]: files.png(pixels.astype(np.uint8)) for kind, pixels in pictures.items()}
        row = Row(
            name=plate.name,
            input=image.name,
            sha256=hashes["image"],
            mask=hashes.get("mask"),
            size=(plate.frame.width, plate.frame.height),
            ratios=plate.ratios,
            blur=blur(plate),
            roadside=plate.roadside,
            files={
                path.relative_to(self._out).as_posix(): hashlib.sha256(png).hexdigest() for path, png in data.items()
            },
            mended=task["mended"],
        )
        if task["again"]:
            # Where this ends halfway, files that are neither the old ones nor these are hands' work.
            files.write(begun(self._out, plate.name), to_json(row))
        for path, png in data.items():
            files.write(path, png)
        return {
            "row": unstructure(row),
            "stamps": stamps | {kind: stamp(written[kind]) for kind in ("masks", "ground")},
        }


def stamp(path: Path) -> list[int]:
    """What tells without reading a file whether it was changed: its size and the time of its last change.

    Raises
    ------
    InputError
        When there is no such file.
    """
    try:
        told = path.stat()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    return [told.st_size, told.st_mtime_ns]


def sha256(path: Path) -> str:
    """The hash of a file.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None


if __name__ == "__main__":
    attend(Plates)
