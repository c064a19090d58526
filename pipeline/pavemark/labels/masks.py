"""Masks of the picture: the lines, and the slots by number. A pixel belongs to what covers at least half of it."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import MultiPolygon

from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import polygons
from pavemark.labels.truth import Truth


def painted(truth: Truth, shape: MultiPolygon) -> np.ndarray:
    """Pixels (H, W) bool of ground that an outline (world, metres) covers by at least half."""
    return (coverage(shape, truth.frame) >= 0.5) & truth.ground


def lines(truth: Truth) -> np.ndarray:
    """The line mask (H, W) uint8: 1 where the union of all labelled markings lies, 0 elsewhere."""
    shapes = [shape for _, shape in truth.markings]
    union = shapes[0] if len(shapes) == 1 else polygons(shapely.union_all(shapes))
    return painted(truth, union).astype(np.uint8)


def slots(truth: Truth) -> np.ndarray:
    """The slot-index mask (H, W): k where the floor of the scene's k-th slot (from 1) is ground, 0 elsewhere.

    uint8, or uint16 for a scene of more than 255 slots. Where slots overlap the later one counts.
    """
    result = np.zeros(truth.ground.shape, np.uint8 if len(truth.slots) <= 255 else np.uint16)
    for number, slot in enumerate(truth.slots, 1):
        result[painted(truth, polygons(slot.area))] = number
    return result
