"""What in an image is marking and what is ground: from its mask, and found where the mask does not know."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from pavemark.background.ego import ego_car
from pavemark.background.free_ground import free_ground
from pavemark.background.markings import find_markings
from pavemark.background.reading import Classes, MaskTable, read_flags, read_mask
from pavemark.background.segmenter import likely_ground, network, segment
from pavemark.ground import Frame

FOUND, SURE = 0.4, 0.5
"""Probabilities from which a pixel is a marking, and ground. A marking that is missed stays in the plate for good;
ground that is taken for one is filled, and hardly seen."""

SPECK = 0.01
"""Square metres below which a found marking is none: a tenth of a metre a side."""

PALE, LINE = 0.3, 0.1
"""Probability from which a pixel is a marking where contrast is even, and the least square metres of a piece. Of what
is so pale no pixel is sure, but a metre of a line is no stain."""


class Segmenter(Protocol):
    """Finds the markings and the ground of an image. The same input gives the same output."""

    @property
    def version(self) -> str:
        """What the result depends on besides the input.

        Raises
        ------
        InputError
            When it cannot be used.
        """
        ...

    def find(self, image: np.ndarray, frame: Frame) -> Classes:
        """Find both, in an image (H, W, 3) uint8, display sRGB.

        Markings lie on the ground.
        """
        ...

    def ground(self, image: np.ndarray, markings: np.ndarray, frame: Frame) -> np.ndarray:
        """Find the ground (H, W) bool of an image whose markings (H, W) bool are known."""
        ...


class Strokes:
    """The classical detector: bright strokes, on all but the ego car."""

    version = "strokes 1"

    def find(self, image: np.ndarray, frame: Frame) -> Classes:
        """See `Segmenter.find`."""
        ground = ~ego_car(image, frame)
        return Classes(find_markings(image, ground, frame), ground)

    def ground(self, image: np.ndarray, markings: np.ndarray, frame: Frame) -> np.ndarray:
        """See `Segmenter.ground`."""
        return ~ego_car(image, frame)


class Trained:
    """The network that ships with Pavemark."""

    @property
    def version(self) -> str:
        """See `Segmenter.version`."""
        return f"network 6 {network().sha256} onnxruntime {importlib.metadata.version('onnxruntime')}"

    def find(self, image: np.ndarray, frame: Frame) -> Classes:
        """See `Segmenter.find`."""
        found = segment(image, frame)
        ego = ego_car(image, frame)
        # On cars and walls there is much that looks like a line.
        there = (found.ground >= SURE) & ~ego
        markings = _without_specks((found.marking >= FOUND) & there, SPECK * frame.scale**2)
        pale = _without_specks((found.pale >= PALE) & there, LINE * frame.scale**2)
        markings |= _apart(pale, markings)
        ground = free_ground(found.ground, markings, ego, frame)
        return Classes(markings & ground, ground)

    def ground(self, image: np.ndarray, markings: np.ndarray, frame: Frame) -> np.ndarray:
        """See `Segmenter.ground`."""
        return free_ground(likely_ground(image, frame), markings, ego_car(image, frame), frame)


SEGMENTERS: dict[str, Segmenter] = {"network": Trained(), "strokes": Strokes()}
"""By name."""


def classes(image: np.ndarray, mask: Path | None, table: MaskTable, segmenter: Segmenter, frame: Frame) -> Classes:
    """What is marking and what is ground.

    A mask wins: what it says is marking is one, unless it lies on the ego car. A mask that lists the ground is not
    doubted at all; of one that only knows markings, and without a mask, the segmenter finds the rest.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display sRGB.
    mask : Path or None
    table : MaskTable
        What the mask's values mean.
    segmenter : Segmenter
    frame : Frame

    Raises
    ------
    InputError
        When the mask is refused, or the segmenter cannot be used.
    """
    if mask is None:
        return segmenter.find(image, frame)
    read = read_mask(mask, table, image.shape[:2])
    ground = read.ground if table.ground is not None else segmenter.ground(image, read.marking, frame)
    return Classes(read.marking & ground, ground)


def mended(markings: Path, ground: Path, shape: tuple[int, int]) -> Classes:
    """What is marking and what is ground where a file tells of each, see `read_flags`. Neither is doubted.

    Raises
    ------
    InputError
        When one of them is refused.
    """
    free = read_flags(ground, shape)
    return Classes(read_flags(markings, shape) & free, free)


def _apart(pieces: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The pieces that touch none of the others: what is found is not to be made wider."""
    count, label = cv2.connectedComponents(pieces.astype(np.uint8), connectivity=8)
    apart = np.ones(count, bool)
    apart[0] = False
    apart[np.unique(label[others])] = False
    return apart[label]


def _without_specks(markings: np.ndarray, least: float) -> np.ndarray:
    """The pieces of at least so many pixels."""
    _, label, statistics, _ = cv2.connectedComponentsWithStats(markings.astype(np.uint8), connectivity=8)
    kept = statistics[:, cv2.CC_STAT_AREA] >= least
    kept[0] = False
    return kept[label]
