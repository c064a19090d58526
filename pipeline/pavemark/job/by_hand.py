"""An image made by hand, put into a dataset as if a run had made it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pavemark.job import journal
from pavemark.job.dataset import join
from pavemark.job.folder import Folder
from pavemark.job.image import encode, write
from pavemark.job.journal import Journal, Shard
from pavemark.plate import Plate
from pavemark.scene import Scene


def save(
    scene: Scene, pixels: np.ndarray, plate: Plate, source: str, folder: Folder, seed: int, versions: dict[str, str]
) -> Path:
    """Write an image with everything that belongs to it; one of its number that is there is replaced.

    Parameters
    ----------
    scene : Scene
    pixels : ndarray (H, W, 3) uint8
        Display sRGB.
    plate : Plate
        The scene's.
    source : str
        File name of the image that the plate was made from.
    folder : Folder
        Of a job, or a new one.
    seed : int
        What the scene was drawn with before hands changed it.
    versions : dict
        Of all that the pixels depend on.

    Returns
    -------
    Path
        Of the image.

    Raises
    ------
    InputError
        When a file cannot be written, or a run is writing into the folder.
    """
    encoded, fragment = encode(scene, pixels, plate, folder)
    with Journal(folder.out, _shard(folder.out, scene.index)) as kept:
        row = {
            "index": scene.index,
            "input": source,
            "plate": plate.sha256,
            "seed": seed,
            "files": write(encoded, folder, scene.index),
            "timings": {},
            "by_hand": True,
            "versions": versions,
        }
        kept.append(scene.index, row, fragment)
    join(folder)
    return folder.paths(scene.index)["image"]


def _shard(out: Path, index: int) -> Shard:
    """The shard whose journal tells of an image: what is said there later counts."""
    entry = journal.entries(out).get(index)
    parts = re.fullmatch(r"(\d+)-of-(\d+)", entry.path.stem) if entry else None
    return Shard(int(parts[1]), int(parts[2])) if parts else Shard()
