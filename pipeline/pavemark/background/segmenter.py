"""Markings and free ground as a network of our own sees them (docs/segmentation.md)."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import cv2
import numpy as np

from pavemark import assets
from pavemark.background.contrast import evened
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.onnx import Network, opened

MODEL = "models/segmenter.onnx"

SCALE = 48.0
"""Pixels per metre at which the network was trained: images are brought to it."""

LOOKS = ((0.8, False), (0.8, True), (1.25, False), (1.25, True))
"""How often a picture is looked at: how much larger than at SCALE, and whether turned upside down. The mean is taken:
what is seen once only, at one scale that may not be the true one, is mostly not there."""

MULTIPLE = 32
"""Pixels of which the network takes whole numbers a side."""

TILE, MARGIN = 1280, 128
"""Pixels a side of what is looked at in one piece, and how far a piece reaches beyond what is kept of it: the network
sees about so far, so larger pictures cost time but no memory, and pieces do not show."""


@attrs.frozen(eq=False)
class Segmentation:
    """What is where.

    Attributes
    ----------
    marking : ndarray (H, W) float32
        Probability that a pixel is a marking.
    pale : ndarray (H, W) float32
        The same as seen where contrast is even, see `pavemark.background.contrast`: paint hardly paler or darker than
        its floor shows there, and so do seams and the edges of things.
    ground : ndarray (H, W) float32
        Probability that it is bare ground or a marking, and nothing stands there.
    """

    marking: np.ndarray
    pale: np.ndarray
    ground: np.ndarray


def network() -> Network:
    """The network that ships with Pavemark.

    Raises
    ------
    InputError
        When onnxruntime is missing, or the file is missing, damaged or another model.
    """
    path = assets.path(MODEL)
    found = opened(path)
    if found.metadata.get("pavemark") != "segmenter 1":
        raise InputError(path, 'is not a segmenter: its metadata must say "pavemark" = "segmenter 1"')
    return found


def segment(image: np.ndarray, frame: Frame) -> Segmentation:
    """Look for markings and free ground.

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display sRGB, of any size.
    frame : Frame
        Its scale may be off by a third: no user's is quite known.

    Returns
    -------
    Segmentation

    Raises
    ------
    InputError
        See `network`; also when it fails, or gives values that are no numbers.
    """
    marking, ground = _looked(image, frame)
    pale, _ = _looked(evened(image, frame.scale), frame)
    return Segmentation(marking, pale, ground)


def likely_ground(image: np.ndarray, frame: Frame) -> np.ndarray:
    """`segment(image, frame).ground`, in half the time."""
    return _looked(image, frame)[1]


def _looked(image: np.ndarray, frame: Frame) -> np.ndarray:
    """The probabilities (2, H, W), the mean of all looks."""
    found = sum(_look(image, SCALE * larger / frame.scale, turned) for larger, turned in LOOKS) / len(LOOKS)
    return np.clip(found, 0, 1)


def _look(image: np.ndarray, ratio: float, turned: bool) -> np.ndarray:
    """The probabilities (2, H, W) as seen from a picture that many times as large."""
    height, width = image.shape[:2]
    size = max(1, round(width * ratio)), max(1, round(height * ratio))
    seen = _resized(image[::-1, ::-1] if turned else image, size).astype(np.float32) / 255
    found = np.empty((2, *seen.shape[:2]), np.float32)
    for kept, piece in _pieces(*seen.shape[:2]):
        found[:, kept[0], kept[1]] = _looked_at(seen, kept, piece)
    whole = np.stack([_resized(part, (width, height)) for part in found])
    return whole[:, ::-1, ::-1] if turned else whole


def _resized(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    if size == image.shape[1::-1]:
        return image
    smaller = size[0] < image.shape[1]
    return cv2.resize(np.ascontiguousarray(image), size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)


def _pieces(height: int, width: int) -> Iterator[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """What is kept of each piece, and the piece."""
    for top in range(0, height, TILE):
        for left in range(0, width, TILE):
            bottom, right = min(top + TILE, height), min(left + TILE, width)
            around = (
                slice(max(0, top - MARGIN), min(height, bottom + MARGIN)),
                slice(max(0, left - MARGIN), min(width, right + MARGIN)),
            )
            yield (slice(top, bottom), slice(left, right)), around


def _looked_at(seen: np.ndarray, kept: tuple[slice, slice], piece: tuple[slice, slice]) -> np.ndarray:
    """The probabilities (2, h, w) in the part that is kept of a piece."""
    part = seen[piece]
    high, wide = part.shape[:2]
    # A picture that is mirrored goes on without an edge that could be taken for a line.
    part = np.pad(part, ((0, -high % MULTIPLE), (0, -wide % MULTIPLE), (0, 0)), mode="symmetric")
    planes = np.ascontiguousarray(part.transpose(2, 0, 1)[None])
    found = network().run({"image": planes}, (1, 2, *part.shape[:2]))[0]
    top, left = kept[0].start - piece[0].start, kept[1].start - piece[1].start
    return found[:, top : top + kept[0].stop - kept[0].start, left : left + kept[1].stop - kept[1].start]
