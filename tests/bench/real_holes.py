"""The inpainting judge on real images: rebuilds the tables of docs/inpainting.md.

    python tests/bench/real_holes.py --out REPORT [--half 100] [--methods patchmatch,fsr] [--data DIR]

The data folder is development data and never in the repository; the report's picture shows it, so it stays out, too.
Masks are made here, 0 bare ground, 1 marking, 2 neither, and kept in REPORT/inputs to be looked at. Of the full views
markings are those of the masks by hand, ground is what tests/ground has outlined. Half-views have no masks: the strokes
that are moved are drawn through their labelled marking points; ground is found, by the network where it is there, and
what is found to be a marking besides is kept out.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import attrs
import click
import cv2
import numpy as np

from pavemark import files
from pavemark.accuracy import inpaint, traces
from pavemark.accuracy.cases import Sample, some
from pavemark.accuracy.fills import Crew
from pavemark.accuracy.ground import Outlined, truth
from pavemark.accuracy.inpaint import Score
from pavemark.accuracy.picture import grid
from pavemark.accuracy.speed import Speed, speeds
from pavemark.accuracy.table import as_csv
from pavemark.background.finding import SEGMENTERS
from pavemark.background.index import index
from pavemark.background.inpainting import choices, inpainter
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.job.progress import shown
from pavemark.records import from_json

ROOT = Path(__file__).parents[2]
DATA = Path(os.environ.get("PAVEMARK_DATA", ROOT / "../shared/data"))
TABLE = MaskTable(ground=(0,))

HALF_SCALE = 1 / 0.044
"""Pixels per metre of a half-view that is 96 pixels wide."""

LINE, STUB, LONGEST = 0.12, 2.5, 7.0
"""Metres: width of a line, how far a separating line is drawn away from the car, longest entrance line."""

BY_HAND = {
    "spfcn_demo": (
        ((528, 78), (512, 122), (487, 178), (488, 188), (457, 267), (433, 300), (431, 328), (421, 352)),
        ((478, 232), (560, 262)),
        ((599, 443), (417, 365), (402, 405), (372, 465), (373, 480), (363, 500), (344, 552)),
        ((366, 513), (488, 560)),
    )
}
"""Lines of the full view without a mask, worn parts and all: points in pixels."""

THEIRS = "authors' LaMa"

FULL = ("lane_", "ps2_", "psv_", "spfcn_")
"""How the names of full views begin."""


@attrs.frozen(eq=False)
class View:
    """An image with what is known of it."""

    name: str
    image: np.ndarray
    marking: np.ndarray
    ground: np.ndarray
    frame: Frame

    def save(self, folder: Path) -> None:
        """Write image and mask into the folder of the view's scale."""
        target = folder / f"{self.frame.scale:.1f}"
        files.write(target / "images" / f"{self.name}.png", files.png(self.image))
        mask = np.where(self.marking, 1, np.where(self.ground, 0, 2)).astype(np.uint8)
        files.write(target / "masks" / f"{self.name}.png", files.png(mask))


def full_views(data: Path) -> Iterator[View]:
    """The full views, their ground as outlined by hand; what is unsure there is none."""
    for outline in sorted((ROOT / "tests/ground").glob("*.json")):
        outlined = from_json(Outlined, outline)
        if not outlined.image.startswith("full/"):
            continue
        path = data / outlined.image
        image = _read(path)
        known = truth(outlined)
        masks = [_mask(mask) for mask in path.parent.glob(f"{path.stem}_mask.*")]
        marking = masks[0] if masks else _drawn(BY_HAND[path.stem], outlined.frame)
        yield View(path.stem, image, marking & known.ground, known.ground & known.judged, outlined.frame)


def half_views(data: Path, count: int) -> Iterator[View]:
    """Half-views of all places, as many of each, spread over the frames of its video."""
    places: dict[str, list[dict]] = {}
    for line in (data / "halfview/labels.jsonl").read_text().splitlines():
        row = json.loads(line)
        places.setdefault(f"{row['scene']} {row['place']}", []).append(row)
    for k, (_, rows) in enumerate(sorted(places.items())):
        share = count // len(places) + (k < count % len(places))
        for row in some(rows, share):
            yield _half_view(data, row)


def _half_view(data: Path, row: dict) -> View:
    path = data / "halfview" / row["image"]
    image = _read(path)
    frame = Frame(row["w"], row["h"], HALF_SCALE * row["w"] / 96)
    found = _finder().find(image, frame)
    bare = found.ground & ~found.marking & ~SEGMENTERS["strokes"].find(image, frame).marking
    # The entrance line is painted along the car's way; its slots lie beyond it.
    outwards = (-1 if row["side"] == "L" else 1) * STUB * frame.scale
    points = sorted((y, x) for x, y in row["points"])
    lines = [((x, y), (x + outwards, y)) for y, x in points]
    lines += [((x, y), (p, q)) for (y, x), (q, p) in pairwise(points) if np.hypot(x - p, y - q) < LONGEST * frame.scale]
    marking = _drawn(lines, frame)
    return View(path.stem, image, marking & found.ground, bare, frame)


def _drawn(lines: Sequence[Sequence[tuple[float, float]]], frame: Frame) -> np.ndarray:
    """Lines of so many points, in pixels, as a mask."""
    mask = np.zeros((frame.height, frame.width), np.uint8)
    for line in lines:
        cv2.polylines(mask, [np.array(line).round().astype(np.int32)], False, 1, max(1, round(LINE * frame.scale)))
    return mask > 0


def _mask(path: Path) -> np.ndarray:
    level = cv2.imread(str(path)).max(-1)
    # Masks kept as JPEG have blurred edges.
    return level > 127 if path.suffix == ".jpg" else level > 0


def _finder():
    """The network, or the classical detector as long as there is none."""
    try:
        _ = SEGMENTERS["network"].version
    except InputError:
        return SEGMENTERS["strokes"]
    return SEGMENTERS["network"]


def _read(path: Path) -> np.ndarray:
    return np.ascontiguousarray(cv2.imread(str(path))[..., ::-1])


def samples(folder: Path) -> list[Sample]:
    """A sample for each scale."""
    return [
        Sample(index(one / "images", one / "masks")[0], float(one.name), TABLE, "strokes")
        for one in sorted(folder.iterdir(), key=lambda one: float(one.name))
    ]


def _groups(scores: Sequence[Score]) -> dict[str, list[Score]]:
    full = [row for row in scores if row.image.startswith(FULL)]
    return {"Full views": full, "Half-views": [row for row in scores if row not in full]}


def _there(methods: str | None) -> tuple[str, ...]:
    if methods is not None:
        return tuple(methods.split(","))
    found = []
    for name in choices():
        try:
            inpainter(name)
        except InputError:
            continue
        found.append(name)
    return tuple(found)


@click.command()
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder of the report.")
@click.option("--half", default=100, show_default=True, help="Half-views.")
@click.option("--full/--no-full", default=True, help="The full views, too.")
@click.option("--methods", help="Inpainters, by name, with commas between them.  [all there are]")
@click.option("--timed", default=5, show_default=True, help="Images that plates are timed with, for each size.")
@click.option("--data", type=click.Path(path_type=Path, exists=True), default=DATA, help="Folder of real images.")
def main(out: Path, half: int, full: bool, methods: str | None, timed: int, data: Path) -> None:
    """Judge the inpainters on real images, and look for what they leave of real lines."""
    cv2.setNumThreads(1)
    names, watcher, folder = _there(methods), shown(False), out / "inputs"
    for view in [*(full_views(data) if full else ()), *half_views(data, half)]:
        view.save(folder)
    scores: list[Score] = []
    fills, times = [], []
    with Crew(names, watcher.tell) as crew:
        for sample in samples(folder):
            pictured = {entry.name for entry in some(sample.entries, 12)}
            found, made = inpaint.judge(sample, crew, pictured, watcher)
            scores += found
            fills += made
            files.write(out / "inpaint.csv", as_csv(scores, Score))
        if timed:
            times = speeds(samples(folder)[-1], crew, timed, watcher)
    parts = [inpaint.summary(scores, times)]
    for name, rows in _groups(scores).items():
        if rows:
            parts += [f"## {name}", *inpaint.standing(rows)]
    files.write(out / "inpaint.md", "\n\n".join(parts) + "\n")
    files.write(out / "speed.csv", as_csv(times, Speed))
    files.write(out / "inpaint.png", files.png(grid(fills, crew.methods)))
    if full:
        _residue(out, folder, names, data, watcher)


def _residue(out: Path, folder: Path, names: Sequence[str], data: Path, watcher) -> None:
    """What is left of the lines of the one image that the paper's authors have cleaned, too."""
    theirs = out / "theirs"
    files.write(theirs / "psv_4220.png", files.png(_read(data / "full/psv_4220_inpainted_lama.jpg")))
    for sample in samples(folder):
        entries = tuple(entry for entry in sample.entries if entry.name == "psv_4220")
        if entries:
            one = attrs.evolve(sample, entries=entries)
            made = traces.report(one, names, {THEIRS: theirs}, False, watcher)
            for name, data_ in made.files.items():
                files.write(out / name, data_)


if __name__ == "__main__":
    sys.exit(main())
