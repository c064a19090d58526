"""One image from end to end."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark import files
from pavemark.background.contours import areas
from pavemark.compose.image import compose
from pavemark.job.clock import Timings
from pavemark.job.config import Job
from pavemark.job.exactness import Exactness
from pavemark.job.folder import Folder
from pavemark.job.inputs import blur, read_plate
from pavemark.labels import coco, dmpr, masks, ps2, yolo
from pavemark.labels.truth import Truth, truth
from pavemark.layers import Renderer
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.randomize.optics import Blur
from pavemark.randomize.scene import randomize
from pavemark.records import to_json
from pavemark.scene import Area, Scene

ENCODERS = {"dmpr": dmpr.encode, "ps2": ps2.encode, "yolo": yolo.encode}


@attrs.frozen(eq=False)
class Ground:
    """A plate and what the domains ask about it.

    Attributes
    ----------
    plate : Plate
    original : tuple of Area
        Outlines of the markings that the input image had; empty where no scene can ask for them.
    blur : tuple of tuple of float, or None
        The picture's own blur, as `Optics.blur`; None where no scene can ask for it.
    """

    plate: Plate
    original: tuple[Area, ...]
    blur: Blur | None


@lru_cache(maxsize=4)
def read_ground(image: Path, mask: Path | None, job: Job) -> Ground:
    """The plate of an input image.

    Raises
    ------
    UnusableImage
        When the image or its mask cannot be used.
    """
    plate = read_plate(image, mask, job)
    original = areas(plate.markings, plate.frame.matrix) if job.layout.original_rate else ()
    return Ground(plate, original, blur(plate) if job.optics.rate else None)


def make_image(
    index: int,
    image: Path,
    mask: Path | None,
    job: Job,
    folder: Folder,
    renderer: Renderer,
    exact: Exactness | None = None,
) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Make a synthetic image with everything that belongs to it, and write it.

    Parameters
    ----------
    index : int
        Its number in the job.
    image, mask : Path, Path or None
        The input it starts from.
    job : Job
    folder : Folder
        Where its files go.
    renderer : Renderer
    exact : Exactness or None
        What the job promises of edges.

    Returns
    -------
    row : dict
        Its row of the manifest: hashes, seed and timings.
    fragment : dict or None
        What it adds to coco.json, where that is asked for.

    Raises
    ------
    UnusableImage
        When the input cannot be used.
    InputError
        When a file cannot be written.
    """
    timings = Timings()
    with timings.stage("plate"):
        ground = read_ground(image, mask, job)
        plate = ground.plate
    with timings.stage("scene"):
        scene = randomize(plate, index, job.seed, job, ground.original, ground.blur)
        if exact is not None:
            scene = exact.met(scene, plate)
        todo = plan(scene)
    with timings.stage("render"):
        layers = renderer.render(scene, plate, todo) if todo.passes else None
    with timings.stage("compose"):
        pixels = compose(scene, todo, plate, layers)
    with timings.stage("labels"):
        encoded, fragment = encode(scene, pixels, plate, folder)
    with timings.stage("files"):
        hashes = write(encoded, folder, index)
    row = {
        "index": index,
        "input": image.name,
        "plate": plate.sha256,
        "seed": job.seed,
        "files": hashes,
        "timings": timings.seconds,
    }
    return row, fragment


def encode(
    scene: Scene, pixels: np.ndarray, plate: Plate, folder: Folder
) -> tuple[dict[str, bytes], dict[str, Any] | None]:
    """The files of an image (H, W, 3) uint8, display sRGB, by what they hold, and what it adds to coco.json."""
    true = truth(scene, plate.ground)
    encoded = _encoded(pixels, true, folder.formats) | {"scene": to_json(scene).encode()}
    name = folder.paths(scene.index)["image"].name
    return encoded, coco.fragment(true, name) if "coco" in folder.formats else None


def write(encoded: dict[str, bytes], folder: Folder, index: int) -> dict[str, str]:
    """Write the files of an image; their hashes by their path in the folder.

    Raises
    ------
    InputError
        When one cannot be written.
    """
    paths = folder.paths(index)
    for what, data in encoded.items():
        files.write(paths[what], data)
    return {
        paths[what].relative_to(folder.out).as_posix(): hashlib.sha256(data).hexdigest()
        for what, data in encoded.items()
    }


def _encoded(pixels: np.ndarray, true: Truth, formats: tuple[str, ...]) -> dict[str, bytes]:
    encoded = {"image": files.png(pixels), "mask": files.png(masks.lines(true)), "slots": files.png(masks.slots(true))}
    for name, encode in ENCODERS.items():
        if name in formats:
            data = encode(true)
            encoded[name] = data.encode() if isinstance(data, str) else data
    return encoded
