"""The cases of the inpainting judge: an image, a self-made hole in it, and what belongs to both."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import attrs
import numpy as np

from pavemark.accuracy.holes import Hole, self_made_hole
from pavemark.background.index import Entry
from pavemark.background.plates import make_plate
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError
from pavemark.plate import Plate

FEW = 0.005
"""Share of the picture: with less marking than this an image is judged with the marking of another."""

QUICK = 4
"""Images that are judged when there is little time."""

CHEAPEST = "navier-stokes"

Thing = TypeVar("Thing")


@attrs.frozen
class Sample:
    """Real images, and how their markings and their ground are known.

    Attributes
    ----------
    entries : tuple of Entry
    scale : float
        Pixels per metre.
    table : MaskTable
        What the values of masks mean.
    segmenter : str
        What finds the markings and the ground of images without masks.
    """

    entries: tuple[Entry, ...]
    scale: float
    table: MaskTable
    segmenter: str

    def plate(self, entry: Entry) -> Plate:
        """The image with its markings and its ground (and a clean plate, from the cheapest inpainter)."""
        return make_plate(entry.image, entry.mask, self.scale, self.table, CHEAPEST, self.segmenter)


@attrs.frozen(eq=False)
class Case:
    """An image to be judged with.

    Attributes
    ----------
    plate : Plate
    hole : Hole
    mask_of : str
        Name of the image whose marking lent the hole its shape.
    """

    plate: Plate
    hole: Hole
    mask_of: str

    @property
    def beside(self) -> np.ndarray:
        """Bare ground beside the hole: (H, W) bool."""
        return ~self.hole.keep_out & ~self.hole.mask


def some(things: Sequence[Thing], most: int) -> tuple[Thing, ...]:
    """At most so many of them, evenly spread.

    Examples
    --------
    >>> some("abcdefg", 3)
    ('a', 'd', 'g')
    """
    chosen = np.linspace(0, len(things) - 1, min(most, len(things))).round().astype(int)
    return tuple(things[k] for k in chosen)


def cases(sample: Sample, refuse: Callable[[str], None]) -> Iterator[Case | None]:
    """Make the cases, one for each image, in order.

    An image with next to no marking is judged with that of the next image, in turn, that has some.

    Parameters
    ----------
    sample : Sample
    refuse : callable
        Told, in a line, of each image that makes no case: None stands in its place.
    """
    bare: set[int] = set()
    for number in range(len(sample.entries)):
        try:
            yield _case(sample, number, bare)
        except InputError as error:
            refuse(str(error))
            yield None


def _case(sample: Sample, number: int, bare: set[int]) -> Case:
    entry = sample.entries[number]
    plate = sample.plate(entry)
    name, marking = _marking(sample, number, plate, bare)
    hole = self_made_hole(marking, plate.markings, plate.ground, plate.frame)
    if hole is None:
        raise InputError(entry.image, f"bare ground has no room for a hole of the shape of the marking of {name}")
    return Case(plate, hole, name)


def _marking(sample: Sample, number: int, plate: Plate, bare: set[int]) -> tuple[str, np.ndarray]:
    """The image's own marking, or that of the next that has some: its image's name and the mask.

    Those that have none to lend are added to `bare`, and not asked again.
    """
    if plate.markings.mean() >= FEW:
        return plate.name, plate.markings
    bare.add(number)
    for other in (*range(number + 1, len(sample.entries)), *range(number)):
        if other in bare:
            continue
        try:
            lender = sample.plate(sample.entries[other])
        except InputError:
            bare.add(other)  # it is told of in its own turn
            continue
        if lender.markings.mean() >= FEW:
            return lender.name, lender.markings
        bare.add(other)
    raise InputError(sample.entries[number].image, "neither it nor any other image has a marking to make a hole of")
