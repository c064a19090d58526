"""The real images of a study, split by place, and the folder of those that plates are made from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from pavemark import files
from pavemark.background.reading import read_image
from pavemark.detect.example import Example
from pavemark.detect.reading import examples, picture
from pavemark.errors import InputError
from pavemark.study.design import Study

PARTS = ("train", "validation", "test")


def split(study: Study) -> dict[str, list[Example]]:
    """The real images of each part, in the order of their list.

    Raises
    ------
    InputError
        When a place has no image.
    """
    found: dict[str, list[Example]] = {part: [] for part in PARTS}
    part_of = {place: part for part in PARTS for place in getattr(study.places, part)}
    seen = set()
    for example in examples(Path(study.real), study.height):
        place = example.groups.get("place")
        seen.add(place)
        if place in part_of:
            found[part_of[place]].append(example)
    lacking = [place for place in part_of if place not in seen]
    if lacking:
        told = ", ".join(sorted(filter(None, seen))) or "none, for its images tell no place"
        raise InputError(study.real, f"place {lacking[0]!r} has no image: allowed {told}")
    return found


def share(real: Sequence[Example], part: float, seed: int) -> list[Example]:
    """A share of the real images, drawn from a seed: a smaller share is part of a larger one."""
    order = np.random.Generator(np.random.PCG64(seed)).permutation(len(real))
    return [real[number] for number in sorted(order[: round(part * len(real))].tolist())]


def name(example: Example) -> str:
    """What the view of a real image is called: the name of the plate that is made of it, too."""
    return Path(example.name).name


def write_views(real: Sequence[Example], frame: tuple[int, int], folder: Path) -> None:
    """Write the real images in one size, for plates to be made of.

    Parameters
    ----------
    real : sequence of Example
    frame : tuple of int
        Width and height, pixels.
    folder : Path
        Where those that are not there yet go, PNG. What was made of the others may be painted on already.

    Raises
    ------
    InputError
        When two have one name, one cannot be read, or what is there was another picture.
    """
    names: set[str] = set()
    for example in real:
        called = name(example)
        if called in names:
            raise InputError(example.image, "has the name of another image: one image a name is allowed")
        names.add(called)
        path = folder / f"{called}.png"
        pixels = picture(example)
        # Up to rounding; further off, what lies on the ground would be squeezed.
        if abs(pixels.shape[1] / pixels.shape[0] * frame[1] - frame[0]) > 1:
            size = f"{pixels.shape[1]}×{pixels.shape[0]} px"
            raise InputError("frame", f"{list(frame)}: {example.image} is {size}: a frame of its shape is allowed")
        if pixels.shape[1::-1] != frame:
            pixels = cv2.resize(pixels, frame, interpolation=cv2.INTER_AREA)
        if not path.exists():
            files.write(path, files.png(pixels))
        elif not np.array_equal(read_image(path), pixels):
            raise InputError(path, f"shows another picture than {example.image} in this size does: use another folder")
