"""Examples, detections and detectors made by hand, and a dataset on disk to judge them by."""

import json
from pathlib import Path

import cv2
import numpy as np

from pavemark.detect.detection import Detection
from pavemark.detect.example import Example
from pavemark.ground import Frame

FRAME = Frame(120, 90, 60.0)


def example(name, points, slots=(), frame=FRAME, image=Path("none.png"), points_alone=False, **groups):
    """An example with these points (u, v) and slots (i, j)."""
    places = np.array(points, float).reshape(-1, 2)
    if points_alone:
        return Example(name, image, frame, places, None, None, None, groups)
    across = np.tile([1.0, 0.0], (len(places), 1))
    pairs = np.array(slots, int).reshape(-1, 2)
    return Example(name, image, frame, places, across, np.zeros(len(places), bool), pairs, groups)


def detection(points, confidence, slots=(), slot_confidence=()):
    """A detection of these points (u, v) and slots (i, j)."""
    places = np.array(points, float).reshape(-1, 2)
    return Detection(
        places,
        np.array(confidence, float),
        np.tile([1.0, 0.0], (len(places), 1)),
        np.zeros(len(places)),
        np.array(slots, int).reshape(-1, 2),
        np.array(slot_confidence, float),
    )


class Said:
    """A detector that says what it was told to, by the grey of the picture."""

    family = "said"

    def __init__(self, by_tone, version="0123456789abcdef"):
        self.by_tone, self.version, self.seen = by_tone, version, []

    def detect(self, image, frame):
        self.seen.append((int(image[0, 0, 0]), image.shape, frame))
        return self.by_tone[int(image[0, 0, 0])]


def dataset(folder, images, points_alone=False):
    """A dataset as `pavemark render` leaves it, or a list of points, from (tone, points, slots) an image.

    DMPR counts pixels from the centre of the first, which is 1. Plates are "even.png" and "odd.png", by the position.
    """
    for name in ("images", "labels/dmpr", "scenes"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    lines = []
    for k, (tone, points, slots) in enumerate(images):
        picture = np.full((FRAME.height, FRAME.width, 3), tone, np.uint8)
        cv2.imwrite(str(folder / f"images/{k:06d}.png"), picture)
        plate = ("even", "odd")[k % 2]
        if points_alone:
            line = {"image": f"images/{k:06d}.png", "w": 120, "h": 90, "points": points, "place": plate}
            lines.append(line | {"scale": 60})
            continue
        marks = [[u + 0.5, v + 0.5, u + 50.5, v + 0.5, 0] for u, v in points]
        labels = {"marks": marks, "slots": [[i + 1, j + 1, 1, 90] for i, j in slots]}
        (folder / f"labels/dmpr/{k:06d}.json").write_text(json.dumps(labels))
        scene = {"plate": {"name": plate, "frame": {"width": 120, "height": 90, "scale": 60.0}}}
        (folder / f"scenes/{k:06d}.json").write_text(json.dumps(scene))
        lines.append({"index": k, "input": f"{plate}.png", "files": {f"images/{k:06d}.png": "0" * 64}})
    name = "labels.jsonl" if points_alone else "manifest.jsonl"
    (folder / name).write_text("".join(json.dumps(line) + "\n" for line in lines))
    if not points_alone:
        (folder / "job.json").write_text(json.dumps({"count": len(images), "formats": ["dmpr"]}))
    return folder
