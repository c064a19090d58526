"""Fits assets/layout.json to the labels of real images.

    python assets/fit_layout.py SLOTS.jsonl

One line of SLOTS.jsonl is an image: {"slots": [{"p1": [u, v], "p2": [u, v], "type": 1 | 2 | 3, "depth_angle": rad}]},
in pixels of 600 × 600 (10 m × 10 m). Only quantiles leave this script, no slot does.
"""

from __future__ import annotations

import json
import sys
from itertools import pairwise
from pathlib import Path

import attrs
import numpy as np

from pavemark.files import write
from pavemark.ground import Frame
from pavemark.randomize.fitted import Family, Fitted
from pavemark.records import to_json

CAR = np.array([0.93, 1.71])
"""Half the width and length, in metres, of the black box that hides the car in these images."""
LONG = 3.5
"""Metres: a longer entrance belongs to a parallel slot."""
DEPTH = {"perpendicular": 281 / 60, "parallel": 120 / 60, "acute": 281 / 60, "obtuse": 281 / 60}
"""The field's convention: 281 px behind a short entrance and 120 px behind a long one."""
PROVENANCE = (
    "Quantiles of the slot labels of 9,827 real around-view images (training part of the public ps2.0 set, 600 px = "
    "10 m), made by assets/fit_layout.py; depths are the convention of that set's evaluation. No label is contained."
)


@attrs.frozen(eq=False)
class Seen:
    """A labelled slot in world coordinates: ends of the entrance line, its direction and the normal into the slot."""

    family: str
    p1: np.ndarray
    p2: np.ndarray
    angle: float

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.p2 - self.p1))

    @property
    def along(self) -> np.ndarray:
        return (self.p2 - self.p1) / self.length

    @property
    def normal(self) -> np.ndarray:
        return np.array([-self.along[1], self.along[0]])


def see(slot: dict) -> Seen:
    p1, p2 = Frame().to_world(np.array([slot["p1"], slot["p2"]]))
    along = np.arctan2(*(p2 - p1)[::-1])
    angle = float(np.degrees((-slot["depth_angle"] - along) % (2 * np.pi)))
    if slot["type"] == 1:
        family = "parallel" if np.linalg.norm(p2 - p1) > LONG else "perpendicular"
    else:
        family = "acute" if angle < 90 else "obtuse"
    return Seen(family, p1, p2, angle)


def into_rows(slots: list[Seen]) -> list[list[Seen]]:
    """Slots whose entrance lines lie on one line, in order along it."""
    rows: list[list[Seen]] = []
    for slot in slots:
        for row in rows:
            first = row[0]
            if first.along @ slot.along > 0.97 and abs((slot.p1 - first.p1) @ first.normal) < 0.6:
                row.append(slot)
                break
        else:
            rows.append([slot])
    return [sorted(row, key=lambda slot: slot.p1 @ row[0].along) for row in rows]


def table(values: list[float], steps: int = 40) -> tuple[float, ...]:
    """Quantiles at equal steps of probability; too few values make no table but their median."""
    if len(values) < 20:
        return (0.0,) if not values else (round(float(np.median(values)), 3),)
    return tuple(round(float(value), 3) for value in np.quantile(values, np.linspace(0, 1, steps + 1)))


def family(name: str, rows: list[list[Seen]], total: int) -> Family:
    slots = [slot for row in rows for slot in row]
    turn: tuple[list, list] = [], []
    clearance: tuple[list, list] = [], []
    for first in (row[0] for row in rows):
        axis = np.degrees(np.arctan2(*first.along[::-1])) - 90  # 0 along the car
        across = int(abs((axis + 90) % 180 - 90) > 45)
        turn[across].append((axis - 90 * across + 45) % 180 % 90 - 45)
        clearance[across].append(first.p1 @ first.normal - np.abs(first.normal) @ CAR)
    counts = np.bincount([len(row) for row in rows])[1:]
    return Family(
        rows=round(len(rows) / total, 4),
        entrance=table([slot.length for slot in slots]),
        angle=table([round(slot.angle, 1) for slot in slots]) if name in ("acute", "obtuse") else (90.0,),
        depth=round(DEPTH[name], 3),
        across=round(len(turn[1]) / len(rows), 3),
        turn=table(turn[0]),
        turn_across=table(turn[1]),
        clearance=table(clearance[0]),
        clearance_across=table(clearance[1]),
        count=tuple(round(float(share), 3) for share in counts / counts.sum()),
    )


def fit(images: list[list[list[Seen]]]) -> Fitted:
    rows = [row for image in images for row in image]
    pairs = [pair for row in rows for pair in pairwise(row)]
    gaps = [float((b.p1 - a.p2) @ a.along) for a, b in pairs]
    beside = [row[0].normal[0] < 0 for row in rows if abs(row[0].normal[0]) > 0.7]
    holding = [image for image in images if image]
    opposite = [len(image) > 1 and image[0][0].along @ image[1][0].along < -0.8 for image in holding]
    kinds = {
        name: family(name, [row for row in rows if row[0].family == name], len(rows))
        for name in ("perpendicular", "parallel", "acute", "obtuse")
    }
    return Fitted(
        provenance=PROVENANCE,
        **kinds,
        variation=table([b.length / a.length for a, b in pairs]),
        gap_rate=round(float(np.mean([gap > 0.05 for gap in gaps])), 3),
        gap=table([gap for gap in gaps if gap > 0.05]),
        left=round(float(np.mean(beside)), 3),
        both_sides=round(float(np.mean(opposite)), 3),
    )


if __name__ == "__main__":
    lines = Path(sys.argv[1]).read_text().splitlines()
    images = [into_rows([see(slot) for slot in json.loads(line)["slots"]]) for line in lines]
    write(Path(__file__).with_name("layout.json"), to_json(fit(images)))
