"""Small datasets, written by hand in the form that `pavemark render` leaves them."""

import json
from pathlib import Path

import cv2
import numpy as np

SIZE = 48, 96
"""Width and height, pixels."""


def made(folder: Path, count: int = 3, scale: float = 22.7, **groups) -> Path:
    """A dataset of grey pictures; image i has a slot whose entrance runs from (10.5, 20 + i) to (10.5, 60 + i)."""
    for name in ("images", "labels/dmpr", "scenes"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / "job.json").write_text(json.dumps({"count": count, "formats": ["dmpr"]}))
    lines = []
    for i in range(count):
        stem = f"{i:06d}"
        picture(folder / "images" / f"{stem}.png", tone=60 + i)
        marks = [[11.0, 20.5 + i, 61.0, 20.5 + i, 1], [11.0, 60.5 + i, 61.0, 60.5 + i, 0]]
        labels = {"marks": marks, "slots": [[1, 2, 1, 90]]}
        (folder / "labels" / "dmpr" / f"{stem}.json").write_text(json.dumps(labels))
        plate = {"name": f"plate{i % 2}", "frame": {"width": SIZE[0], "height": SIZE[1], "scale": scale}}
        scene = {"plate": plate, "slots": [{"kind": "parallel"}], **groups}
        (folder / "scenes" / f"{stem}.json").write_text(json.dumps(scene))
        lines.append({"index": i, "input": f"plate{i % 2}.png", "files": {f"images/{stem}.png": "0" * 64}})
    (folder / "manifest.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return folder


def listed(folder: Path, *lines: dict) -> Path:
    """A list of pictures with points alone."""
    folder.mkdir(parents=True, exist_ok=True)
    for line in lines:
        if isinstance(line.get("image"), str) and isinstance(line.get("w"), int):
            picture(folder / line["image"], (line["w"], line["h"]))
    (folder / "labels.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return folder


def picture(path: Path, size: tuple[int, int] = SIZE, tone: int = 90) -> None:
    """A picture of one grey."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full((size[1], size[0], 3), tone, np.uint8))
