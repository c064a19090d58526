"""The ego car: the black patch where the cameras see nothing but the car they hang on."""

from __future__ import annotations

import cv2
import numpy as np

from pavemark.ground import Frame

BLACKEST = 12
"""8-bit level that no channel of the patch exceeds; it is 0 before JPEG, and no lit ground is as dark and even."""

MEDIAN = 5
"""Largest median level of the patch: a shadow or the dark of a garage is noisy above it."""

UPRIGHT = 0.75
"""Least share of its bounding box, but for one ragged column, that the patch fills. Mirrors and bumpers stay within it;
black cars parked across the border of a half-view and cast shadows do not."""

OPENING = 0.3
"""Metres along the car below which a run of black is not counted."""

LENGTH = (1.5, 8.0)
"""Metres from bumper to bumper, with room for a picture whose scale is not quite known."""

EDGE = 2
"""Pixels beyond the patch that compression and interpolation have darkened."""


def ego_car(image: np.ndarray, frame: Frame) -> np.ndarray:
    """Where the ego car stands.

    It is a connected, upright, almost uniformly black patch that covers the image's centre, or lies along the left or
    the right border half-way up (a half-view).

    Parameters
    ----------
    image : ndarray (H, W, 3) uint8
        Display sRGB.
    frame : Frame

    Returns
    -------
    ndarray (H, W) bool
        All False where no such patch is found.
    """
    level = image.max(2)
    # Opened along the car, so that dark joints in the pavement and wheels beside it do not hang on to the patch.
    column = np.ones((max(3, round(OPENING * frame.scale)), 1), np.uint8)
    black = cv2.morphologyEx((level <= BLACKEST).astype(np.uint8), cv2.MORPH_OPEN, column)
    _, label, statistics, _ = cv2.connectedComponentsWithStats(black, connectivity=4)
    height, width = level.shape
    middle = height // 2
    best, found = UPRIGHT, 0
    for number in sorted({label[middle, width // 2], label[middle, 0], label[middle, width - 1]} - {0}):
        _, _, box_width, box_height, area = statistics[number]
        upright = area / (max(box_width - 1, 1) * box_height)
        length = box_height / frame.scale
        if upright >= best and LENGTH[0] <= length <= LENGTH[1] and np.median(level[label == number]) <= MEDIAN:
            best, found = upright, number
    if not found:
        return np.zeros((height, width), bool)
    return _closed((label == found).astype(np.uint8))


def _closed(patch: np.ndarray) -> np.ndarray:
    """The patch without holes and with its edge."""
    outlines, _ = cv2.findContours(patch, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = cv2.drawContours(np.zeros_like(patch), outlines, -1, 1, cv2.FILLED)
    return cv2.dilate(whole, np.ones((2 * EDGE + 1, 2 * EDGE + 1), np.uint8)) > 0
