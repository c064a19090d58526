"""Labels as YOLO pose text: a line for each slot, its box and its four corners as keypoints."""

from __future__ import annotations

from pavemark.labels.truth import OUTSIDE, ParkingSlot, Truth

CLASSES = ("perpendicular", "parallel", "slanted")


def encode(truth: Truth) -> str:
    """The text of an image: `class cx cy w h` and `x y v` for each of p1 … p4.

    Numbers are shares of width and height, 0 to 1. The box bounds the slot's floor inside the frame. v is 2 for a
    visible corner, 1 for one hidden under what is not ground or not painted, 0 for one outside the frame, whose
    x and y are 0 as readers refuse coordinates beyond the picture.
    """
    return "".join(_line(slot, truth.frame.width, truth.frame.height) for slot in truth.slots if slot.seen)


def data(train: str, val: str) -> dict:
    """What a reader's data file must say: folders of pictures, classes, keypoints and their exchange by mirroring."""
    return {
        "train": train,
        "val": val,
        "names": dict(enumerate(CLASSES)),
        "kpt_shape": [4, 3],
        # A mirrored slot would lie to the right of p1 → p2: the ends change places.
        "flip_idx": [1, 0, 3, 2],
    }


def _line(slot: ParkingSlot, width: int, height: int) -> str:
    u0, v0, u1, v1 = slot.region.bounds
    numbers = [(u0 + u1) / 2 / width, (v0 + v1) / 2 / height, (u1 - u0) / width, (v1 - v0) / height]
    words = [str(CLASSES.index(slot.kind)), *map(_share, numbers)]
    for (u, v), visibility in zip(slot.corners, slot.visibility, strict=True):
        x, y = (0.0, 0.0) if visibility == OUTSIDE else (u / width, v / height)
        words += [_share(x), _share(y), str(visibility)]
    return " ".join(words) + "\n"


def _share(number: float) -> str:
    return f"{number:.7f}"
