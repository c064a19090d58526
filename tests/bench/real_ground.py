"""How well free ground is found, on our own images and on real ones outlined by hand: for docs/free-ground.md.

Run from the checkout:  python tests/bench/real_ground.py [--each]
Real images are looked for in $PAVEMARK_DATA, else in ../shared/data beside the checkout; without them only our own
are judged.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import attrs
import cv2
import numpy as np

from pavemark.accuracy.ground import Outlined, Overlap, Truth, compare, truth
from pavemark.accuracy.table import markdown
from pavemark.background.ego import ego_car
from pavemark.background.finding import SEGMENTERS
from pavemark.background.reading import read_image
from pavemark.background.segmenter import likely_ground, network
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.records import from_json

ROOT = Path(__file__).parents[2]
DATA = Path(os.environ.get("PAVEMARK_DATA") or ROOT / "../shared/data")
DEMO = ROOT / "assets/demo"

Finder = Callable[[np.ndarray, Frame], np.ndarray]


@attrs.frozen(eq=False)
class Case:
    """An image and where its ground is."""

    group: str
    name: str
    image: np.ndarray
    frame: Frame
    truth: Truth


def own() -> Iterator[Case]:
    """The demo images: their masks are exact."""
    for folder, scale, group in (
        (DEMO, 60.0, "our own, full views"),
        (DEMO / "half", 1 / 0.044, "our own, half-views"),
    ):
        for path in sorted((folder / "images").glob("*.jpg")):
            image = read_image(path)
            frame = Frame(image.shape[1], image.shape[0], scale)
            mask = cv2.imread(str(folder / "masks" / f"{path.stem}.png"), cv2.IMREAD_UNCHANGED)
            known = Truth(mask != 2, ego_car(image, frame) & (mask == 2), np.ones(mask.shape, bool))
            yield Case(group, path.stem, image, frame, known)


def real() -> Iterator[Case]:
    """The real images that were outlined by hand."""
    for path in sorted((ROOT / "tests/ground").glob("*.json")):
        outlined = from_json(Outlined, path)
        half = outlined.image.startswith("halfview/")
        group = "real, half-views" if half else "real, full views"
        yield Case(group, path.stem, read_image(DATA / outlined.image), outlined.frame, truth(outlined))


def finders() -> dict[str, Finder]:
    """What is compared; the network where it is there."""
    found: dict[str, Finder] = {"all but the ego car": lambda image, frame: ~ego_car(image, frame)}
    try:
        network()
    except InputError as error:
        print(f"without the network: {error}", file=sys.stderr)
        return found
    found["network, plain"] = lambda image, frame: likely_ground(image, frame) >= 0.5
    found["network, cleaned up"] = lambda image, frame: SEGMENTERS["network"].find(image, frame).ground
    return found


def cells(overlaps: list[Overlap]) -> list[str]:
    """Means over the images, and the worst."""
    values = np.array([attrs.astuple(overlap) for overlap in overlaps])

    def mean(column: int) -> str:
        known = values[~np.isnan(values[:, column]), column]
        return f"{known.mean():.3f}" if len(known) else "–"

    return [*(f"{mean(column)} ({values[:, column].min():.3f})" for column in (0, 1)), mean(2), mean(3), mean(4)]


def main() -> None:
    """Print the table, and with --each a line an image."""
    cases = list(own())
    if (DATA / "halfview").is_dir():
        cases += real()
    else:
        print(f"without real images: {DATA} holds none", file=sys.stderr)
    groups = list(dict.fromkeys(case.group for case in cases))
    rows = []
    for name, find in finders().items():
        overlaps = [compare(find(case.image, case.frame), case.truth) for case in cases]
        for group in groups:
            those = [overlap for case, overlap in zip(cases, overlaps, strict=True) if case.group == group]
            rows.append([group, str(len(those)), name, *cells(those)])
        if "--each" in sys.argv:
            for case, overlap in zip(cases, overlaps, strict=True):
                print(f"{name:20} {case.name:34}", *(f"{value:6.3f}" for value in attrs.astuple(overlap)))
    rows.sort(key=lambda row: groups.index(row[0]))
    head = ["images", "n", "found by", "IoU, all pixels (worst)", "IoU beside the ego car (worst)"]
    print(markdown([*head, "IoU of things", "things painted on", "ground lost"], rows))


if __name__ == "__main__":
    main()
