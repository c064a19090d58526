"""Measures assets/palette.json on real images with masks of their markings.

    python assets/fit_palette.py FOLDER

FOLDER holds STEM.jpg with STEM_mask.png (1 is marking) or STEM_mask.jpg (white and yellow are lines, blue is symbols).
Only a few medians an image leave this script, no pixel does.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

from pavemark.colour import to_linear
from pavemark.files import write
from pavemark.randomize.palette import Palette, Shade
from pavemark.records import to_json

BLACK = 12
"""8-bit level below which a pixel belongs to the box that hides the car."""
SMALLEST = 200
"""Pixels: a smaller marking says too little."""
PROVENANCE = (
    "Medians over the markings of twelve public around-view images (one paved yard, one dim garage, ten road images), "
    "one entry for an image and family, made by assets/fit_palette.py: display RGB, and the ratio of linear-light "
    "reflectance to the ground within 10 px. Parking grounds weigh four times as much as roads. No pixel is contained."
)


def lines(mask_file: Path) -> np.ndarray:
    """Where the mask says white or yellow line, bool (H, W)."""
    mask = cv2.imread(str(mask_file), cv2.IMREAD_UNCHANGED)
    if mask.ndim == 2:
        return mask == 1
    _, green, red = np.moveaxis(mask.astype(int), -1, 0)
    return (red > 128) & (green > 128)


def measure(image: np.ndarray, mask: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """(display RGB, ratio) of each marking."""

    def widened(where: np.ndarray, size: int) -> np.ndarray:
        return cv2.dilate(where.astype(np.uint8), np.ones((size, size), np.uint8)) > 0

    car = widened(image.max(-1) < BLACK, 9)
    inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    count, part = cv2.connectedComponents(mask.astype(np.uint8))
    found = []
    for k in range(1, count):
        own = (part == k) & inner & ~car
        beside = widened(part == k, 21) & ~widened(mask, 9) & ~car
        if min(own.sum(), beside.sum()) >= SMALLEST:
            ratio = np.median(to_linear(image[own]), 0) / np.median(to_linear(image[beside]), 0)
            found.append((np.median(image[own], 0), ratio))
    return found


def shades(folder: Path) -> list[tuple[str, Shade]]:
    found = []
    for mask_file in sorted(folder.glob("*_mask.*")):
        image_file = mask_file.with_name(mask_file.stem.removesuffix("_mask") + ".jpg")
        image = cv2.imread(str(image_file))[..., ::-1]
        families: dict[str, list] = {"white": [], "yellow": []}
        for rgb, ratio in measure(image, lines(mask_file)):
            families["yellow" if rgb[2] < 0.75 * rgb[1] else "white"].append((rgb, ratio))
        for name, markings in families.items():
            if markings:
                rgb, ratio = np.median(np.array(markings), axis=0)
                weight = 4.0 if mask_file.suffix == ".png" else 1.0
                found.append((name, Shade(tuple(np.round(rgb).tolist()), tuple(np.round(ratio, 2).tolist()), weight)))
    return found


if __name__ == "__main__":
    found = shades(Path(sys.argv[1]))
    palette = Palette(PROVENANCE, *(tuple(s for name, s in found if name == family) for family in ("white", "yellow")))
    write(Path(__file__).with_name("palette.json"), to_json(palette))
