"""Real images of a study, as its tests have them: grey, of three places."""

from pathlib import Path

import cv2
import numpy as np

from pavemark.study.design import Study, read

PLACES = ("north", "north", "north", "north", "south", "east", "east")

STUDY = """
real = "real"
height = 6.4
frame = [48, 64]
judge = "real"

[places]
train = ["north"]
validation = ["south"]
test = ["east"]

[training]
steps = 4
fine_tune_steps = 2
batch = 2

[pools.base]
count = 6

[[rows]]
name = "real"
real = 1.0

[[rows]]
name = "easiest"
pools = ["base"]
strategy = "cfds"
keep = 3
"""


def written(folder: Path, text: str = STUDY) -> Path:
    """The study file, with its real images beside it: T-shaped strokes, a marking point where they meet."""
    lines = []
    rng = np.random.default_rng(0)
    for number, place in enumerate(PLACES):
        pixels = rng.normal(80, 6, (64, 48, 3))
        pixels[30:33, 10:44] += 90
        pixels[10:60, 10:13] += 90
        path = folder / "real" / "images" / f"{place}_{number}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), pixels.clip(0, 255).astype(np.uint8))
        lines.append(
            f'{{"image": "images/{path.name}", "w": 48, "h": 64, "place": "{place}", "points": [[11.5, 31.5]]}}\n'
        )
    (folder / "real" / "labels.jsonl").write_text("".join(lines))
    path = folder / "study.toml"
    path.write_text(text)
    return path


def study(folder: Path, text: str = STUDY) -> Study:
    """The same, read."""
    return read(written(folder, text))
