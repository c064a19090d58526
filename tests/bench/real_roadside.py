"""How well the roadside is estimated on real half-views, against a line through their labelled marking points.

Run from the checkout:  python tests/bench/real_roadside.py [strokes|network] [every]
Every fifth half-view unless told. They are looked for in $PAVEMARK_DATA, else in ../shared/data beside the checkout.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pavemark.accuracy.table import markdown
from pavemark.background import roadside
from pavemark.background.ego import ego_car
from pavemark.background.finding import SEGMENTERS
from pavemark.background.reading import read_image
from pavemark.ground import Frame

DATA = Path(os.environ.get("PAVEMARK_DATA") or Path(__file__).parents[2] / "../shared/data") / "halfview"
STRAIGHT = 0.066
"""Metres, root mean square, by which marking points may leave their line: else they are of several rows."""


def labelled(every: int) -> Iterator[tuple[np.ndarray, Frame, str, np.ndarray, np.ndarray]]:
    """Image, frame, side, and the entrance line through its marking points: middle and direction, world metres."""
    for line in (DATA / "labels.jsonl").read_text().splitlines()[::every]:
        label = json.loads(line)
        frame = Frame(label["w"], label["h"], label["w"] / 96 / 0.044)
        points = frame.to_world(np.array(label["points"]).reshape(-1, 2))
        if len(points) < 3:
            continue
        middle = points.mean(0)
        _, size, axes = np.linalg.svd(points - middle, full_matrices=False)
        spread = size / math.sqrt(len(points))
        if spread[1] < STRAIGHT and spread[0] > 1.1:
            yield read_image(DATA / label["image"]), frame, label["side"], middle, axes[0]


def quarter(degrees: float) -> float:
    return (degrees + 45.0) % 90.0 - 45.0


def main() -> None:
    """Print the table."""
    finder = SEGMENTERS[sys.argv[1] if len(sys.argv) > 1 else "strokes"]
    every = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    certain, roadside.CERTAIN = roadside.CERTAIN, 0.0
    found = []
    for image, frame, side, middle, along in labelled(every):
        classes = finder.find(image, frame)
        true = quarter(math.degrees(math.atan2(along[1], along[0])) - 90.0)
        way = roadside.find_roadside(classes.marking, classes.ground, ego_car(image, frame), frame)
        if way is None:
            found.append((0.0, math.nan, math.nan, true))
            continue
        normal = np.array([-math.sin(way.direction), math.cos(way.direction)])
        line = way.left if side == "L" else way.right
        off = math.nan if line is None else abs(line - float(middle @ normal))
        found.append((way.confidence, abs(quarter(math.degrees(way.direction) - 90.0 - true)), off, true))
    confidence, turn, off, true = np.array(found).T
    rows = [["the car's way", "100 %", *_turns(np.abs(true)), ""]]
    for least in (0.0, 0.2, certain, 0.5, 0.7):
        kept = (confidence >= least) & ~np.isnan(turn)
        lines = off[kept][~np.isnan(off[kept])]
        near = f"{(lines < 0.3).mean():.0%} of {len(lines)}"
        rows.append([f"confidence ≥ {least:g}", f"{kept.mean():.0%}", *_turns(turn[kept]), near])
    print(f"{len(found)} half-views with three marking points or more on a line")
    print(markdown(["direction from", "of the images", "median", "95 %", "within 3°", "line within 0.3 m"], rows))


def _turns(degrees: np.ndarray) -> list[str]:
    median, most = np.percentile(degrees, [50, 95])
    return [f"{median:.2f}°", f"{most:.1f}°", f"{(degrees < 3).mean():.1%}"]


if __name__ == "__main__":
    main()
