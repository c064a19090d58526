"""What is judged of a detection: points, and pairs of points, by where they lie."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.detect.detection import Detection
from pavemark.detect.example import Example


@attrs.frozen(eq=False)
class Marks:
    """Things of one kind that were found in an image, in any order.

    Attributes
    ----------
    places : ndarray (N, 2) or (N, 4) float64
        Image coordinates, pixels: u, v of a point; or u, v of p1 and then of p2, for slots have a direction.
    confidence : ndarray (N,) float64
        0 to 1.
    """

    places: np.ndarray
    confidence: np.ndarray

    def order(self) -> np.ndarray:
        """Positions (N,), the most confident first; of equals by place, so that the order given does not matter."""
        return np.lexsort((*self.places.T[::-1], -self.confidence))


@attrs.frozen(eq=False)
class Found:
    """What was found in an image.

    Attributes
    ----------
    points : Marks
        Of two coordinates.
    slots : Marks
        Of four.
    """

    points: Marks
    slots: Marks


def found(detection: Detection) -> Found:
    """What is judged of a detection.

    Raises
    ------
    ValueError
        When an array has another shape than `Detection` says, holds a number that is not finite, a confidence is
        none, or a slot names a point that is not there or one point twice: the array, the value, what is allowed.
    """
    count, pairs = _count(detection.points, "points"), _count(detection.slots, "slots")
    shapes = {
        "points": (count, 2),
        "confidence": (count,),
        "directions": (count, 2),
        "l_shaped": (count,),
        "slots": (pairs, 2),
        "slot_confidence": (pairs,),
    }
    for name, shape in shapes.items():
        values = np.asarray(getattr(detection, name))
        if values.shape != shape:
            raise ValueError(f"{name} has the shape {list(values.shape)}: {list(shape)} is allowed")
        if not np.isfinite(values).all():
            raise ValueError(f"{name} holds {values[~np.isfinite(values)][0]}: finite numbers are allowed")
    for name in ("confidence", "slot_confidence"):
        values = np.asarray(getattr(detection, name))
        outside = (values < 0) | (values > 1)
        if outside.any():
            raise ValueError(f"{name} holds {values[outside][0]:g}: 0 to 1 is allowed")
    slots = np.asarray(detection.slots)
    if pairs and not np.issubdtype(slots.dtype, np.integer):
        raise ValueError(f"slots is of {slots.dtype}: whole numbers are allowed")
    for first, second in slots.tolist():
        if not (0 <= first < count and 0 <= second < count) or first == second:
            raise ValueError(f"slots holds ({first}, {second}): two of {count} points are allowed")
    points = np.asarray(detection.points, np.float64)
    return Found(
        Marks(points, np.asarray(detection.confidence, np.float64)),
        Marks(pairs_of(points, slots), np.asarray(detection.slot_confidence, np.float64)),
    )


def true_slots(example: Example) -> np.ndarray:
    """Where p1 and p2 of the slots of an example lie, as `Marks.places`; only those whose points are both visible."""
    return pairs_of(example.points, example.slots)


def pairs_of(points: np.ndarray, slots: np.ndarray) -> np.ndarray:
    """Coordinates (M, 4) of pairs (M, 2) of points (N, 2)."""
    chosen = np.asarray(slots, np.int64).reshape(-1, 2)
    return np.asarray(points, np.float64).reshape(-1, 2)[chosen].reshape(-1, 4)


def _count(values: np.ndarray, name: str) -> int:
    shape = np.shape(values)
    if len(shape) != 2:
        raise ValueError(f"{name} has the shape {list(shape)}: [?, 2] is allowed")
    return shape[0]
