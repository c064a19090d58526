"""How well markings are found in real images with masks: F1 at 3 px, the network beside the classical detector.

    python tests/bench/real_markings.py [--half 200] [--data DIR] [--picture FILE.png]

The data folder is development data and never in the repository; the picture shows it, so it stays out, too.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from statistics import mean

import click
import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt

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


REACH = 4.0
"""Pixels of a half-view, 0.18 m, within which a labelled marking point has to have a found marking."""


def half_views(data: Path, count: int) -> Iterator[tuple[str, np.ndarray, np.ndarray, Frame]]:
    """Place, image, labelled marking points (N, 2) and frame of half-views, spread evenly over places and frames."""
    places: dict[str, list[dict]] = {}
    for line in (data / "halfview/labels.jsonl").read_text().splitlines():
        row = json.loads(line)
        if row["points"]:
            places.setdefault(row["place"], []).append(row)
    for place, rows in sorted(places.items()):
        for k in np.linspace(0, len(rows) - 1, -(-count // len(places))).round().astype(int):
            image = cv2.imread(str(data / "halfview" / rows[k]["image"]))[..., ::-1]
            frame = Frame(image.shape[1], image.shape[0], 22.7 * image.shape[1] / 96)
            yield place, image, np.array(rows[k]["points"]), frame


def points_found(found: np.ndarray, points: np.ndarray, frame: Frame) -> np.ndarray:
    """Whether marking points (N, 2) lie near a found marking, bool (N,)."""
    away = distance_transform_edt(~found) if found.any() else np.full(found.shape, np.inf)
    u, v = np.clip(points.astype(int), 0, np.array(found.shape)[::-1] - 1).T
    return away[v, u] <= REACH * frame.scale / 22.7


def tell_half_views(data: Path, count: int) -> None:
    """Print, by place, the share of marking points found and the share of the ground called marking."""
    found: dict[str, dict[str, list]] = {}
    for place, image, points, frame in half_views(data, count):
        for name, segmenter in SEGMENTERS.items():
            marking = segmenter.find(image, frame).marking
            found.setdefault(place, {}).setdefault(name, []).append(
                (points_found(marking, points, frame), marking.mean())
            )
    print("\n| place |" + "".join(f" {name}: points found | marked |" for name in SEGMENTERS))
    print("| --- |" + " --- |" * 2 * len(SEGMENTERS))
    for place, by_name in found.items():
        told = (
            f" {np.concatenate([near for near, _ in rows]).mean():.3f} | {mean(share for _, share in rows):.3f} |"
            for rows in by_name.values()
        )
        print(f"| {place} |" + "".join(told))


@click.command()
@click.option("--half", default=0, help="Half-views to look at, too.")
@click.option("--data", type=click.Path(path_type=Path, exists=True), default=DATA, help="Folder with `full`.")
@click.option("--picture", type=click.Path(path_type=Path), help="Where the results are drawn.")
def main(half: int, data: Path, picture: Path | None) -> None:
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
    if half:
        tell_half_views(data, half)
    if picture is not None:
        width = max(row.shape[1] for row in rows)
        sheet = np.vstack([np.pad(row, ((0, 6), (0, width - row.shape[1]), (0, 0))) for row in rows])
        cv2.imwrite(str(picture), sheet[..., ::-1])


if __name__ == "__main__":
    main()
