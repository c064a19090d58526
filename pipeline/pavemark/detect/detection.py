"""What a detector finds in an image."""

from __future__ import annotations

from typing import Protocol

import attrs
import numpy as np

from pavemark.ground import Frame


@attrs.frozen(eq=False)
class Detection:
    """Marking points and slots that were found, the most confident first.

    Attributes
    ----------
    points : ndarray (N, 2) float64
        Image coordinates, continuous, pixels of the image itself.
    confidence : ndarray (N,) float64
        0 to 1.
    directions : ndarray (N, 2) float64
        Unit vectors in image coordinates (y down), as `pavemark.labels.truth.MarkingPoint` defines them.
    l_shaped : ndarray (N,) float64
        How likely the point is an L and not a T, 0 to 1.
    slots : ndarray (M, 2) int64
        Positions in `points` of p1 and p2; the slot lies to the left of p1 → p2 as seen.
    slot_confidence : ndarray (M,) float64
        0 to 1.
    """

    points: np.ndarray
    confidence: np.ndarray
    directions: np.ndarray
    l_shaped: np.ndarray
    slots: np.ndarray
    slot_confidence: np.ndarray


class Detector(Protocol):
    """A trained detector of any family."""

    family: str
    version: str
    """Hash of the model: two detectors of one version find the same."""

    def grid(self, image: np.ndarray, frame: Frame) -> np.ndarray:
        """What is said of each cell: (R, C, 3) float64, confidence and place, as `point_loss` takes it.

        The grid covers `Detector.covered(frame)` pixels of the image, which reach to the right of it and below it
        where the image is no whole number of cells.
        """

    def covered(self, frame: Frame) -> tuple[float, float]:
        """Width and height that the grid covers, in pixels of the image."""

    def detect(self, image: np.ndarray, frame: Frame) -> Detection:
        """Find points and slots in an image (H, W, 3) uint8, display sRGB."""

    def embedding(self, image: np.ndarray, frame: Frame) -> np.ndarray:
        """What the image looks like to the detector: (E,) float64. Near-duplicates lie close to each other."""

    def look(self, image: np.ndarray, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
        """`grid` and `embedding` at the price of one."""
