"""How well markings are found in real images with masks: F1 at 3 px, the network beside the classical detector.

    python tests/bench/real_markings.py [--data DIR] [--picture FILE.png]

The data folder is development data and never in the repository; the picture shows it, so it stays out, too.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from statistics import mean

import click
import cv2
import numpy as np

from pavemark.accuracy.markings import Found, compare
from pavemark.background.finding import SEGMENTERS
from pavemark.ground import Frame

DATA = Path(os.environ.get("PAVEMARK_DATA", Path(__file__).parents[2] / "../shared/data"))

SCALES = {"ps2_161": 60.0, "psv_4220": 100.0}
"""Pixels per metre; nobody knows that of the lane images, so they get what `pavemark` takes unless told."""


def images(data: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray, Frame]]:
    """Name, image (H, W, 3) uint8 RGB, mask (H, W) bool and frame of every image with a mask."""
    for path in sorted((data / "full").glob("*_mask.*")):
        name = path.stem.removesuffix("_mask")
        image = cv2.imread(str(path.with_name(f"{name}.jpg")))[..., ::-1]
        # Masks kept as JPEG have blurred edges.
        level = cv2.imread(str(path)).max(-1)
        mask = level > 127 if path.suffix == ".jpg" else level > 0
        yield name, image, mask, Frame(image.shape[1], image.shape[0], SCALES.get(name, 60.0))


def drawn(image: np.ndarray, found: np.ndarray, true: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """The image, what was found (green right, red wrong, blue missed), and what is no ground (violet), 600 px high."""
    told, free = image.copy(), image.copy()
    for where, colour in ((found & true, (0, 255, 0)), (found & ~true, (255, 0, 0)), (~found & true, (0, 80, 255))):
        told[where] = colour
    free[~ground] = free[~ground] // 3 + np.array([140, 0, 140], np.uint8)
    row = np.hstack([image, told, free])
    return cv2.resize(row, (round(row.shape[1] * 600 / row.shape[0]), 600), interpolation=cv2.INTER_AREA)


@click.command()
@click.option("--data", type=click.Path(path_type=Path, exists=True), default=DATA, help="Folder with `full`.")
@click.option("--picture", type=click.Path(path_type=Path), help="Where the results are drawn.")
def main(data: Path, picture: Path | None) -> None:
    """Print a line an image and the means."""
    cv2.setNumThreads(1)
    scores: dict[str, list[Found]] = {name: [] for name in SEGMENTERS}
    rows = []
    print("| image |" + "".join(f" {name}: F1 | precision | recall |" for name in SEGMENTERS))
    print("| --- |" + " --- |" * 3 * len(SEGMENTERS))
    for name, image, true, frame in images(data):
        line = f"| {name} |"
        for segmenter, found in ((key, SEGMENTERS[key].find(image, frame)) for key in SEGMENTERS):
            score = compare(found.marking, true)
            scores[segmenter].append(score)
            line += f" {score.f1:.3f} | {score.precision:.3f} | {score.recall:.3f} |"
            if segmenter == "network":
                rows.append(drawn(image, found.marking, true, found.ground))
        print(line, flush=True)
    for what, of in (("mean", mean), ("least", min)):
        told = (f" {of(s.f1 for s in found):.3f} | | |" for found in scores.values())
        print(f"| **{what}** |" + "".join(told))
    if picture is not None:
        width = max(row.shape[1] for row in rows)
        sheet = np.vstack([np.pad(row, ((0, 6), (0, width - row.shape[1]), (0, 0))) for row in rows])
        cv2.imwrite(str(picture), sheet[..., ::-1])


if __name__ == "__main__":
    main()
