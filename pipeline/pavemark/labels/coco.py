"""Labels as COCO: slots with four keypoints and a polygon, markings with a mask, all images in one file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

import numpy as np
import shapely

from pavemark.labels.masks import painted
from pavemark.labels.truth import OUTSIDE, ParkingSlot, Truth

CATEGORIES = [
    {
        "id": 1,
        "name": "slot",
        "supercategory": "parking",
        "keypoints": ["p1", "p2", "p3", "p4"],
        "skeleton": [[1, 2], [2, 3], [3, 4], [4, 1]],
    },
    {"id": 2, "name": "marking", "supercategory": "parking"},
]

SMOOTH = 0.05
"""Pixels by which a bent side may be straightened: a bent slot then takes tens of points, not hundreds."""


def fragment(truth: Truth, file_name: str, smooth: float = SMOOTH) -> dict:
    """What one image adds to the file.

    Parameters
    ----------
    truth : Truth
    file_name : str
    smooth : float
        Pixels by which a bent side may be straightened.

    Returns
    -------
    dict
        `image`, and `annotations` still without ids. A slot has `keypoints` with p1 … p4 as pixel indices (the
        centre of the first pixel at 0) and v 0 outside the frame, 1 hidden, 2 visible; its `segmentation` is the
        floor's polygon inside the frame (the first pixel reaching from 0 to 1). A marking's `segmentation` is an
        uncompressed run-length mask of the pixels it paints. `kind`, `outline`, `marks` and `angle` are ours.
    """
    image = {"id": truth.index, "file_name": file_name, "width": truth.frame.width, "height": truth.frame.height}
    annotations = [_slot(slot, smooth) for slot in truth.slots if slot.seen]
    for kind, shape in truth.markings:
        mask = painted(truth, shape)
        if mask.any():
            annotations.append(_marking(kind, mask))
    return {"image": image, "annotations": annotations}


def dataset(fragments: Iterable[dict]) -> Iterator[str]:
    """The whole file from the fragments of its images, in the order in which they come.

    Yields
    ------
    str
        Its text part by part: the annotations of 300,000 images need not fit in memory.
    """
    images: list[str] = []
    number = 0
    yield '{"annotations": ['
    for part in fragments:
        images.append(json.dumps(part["image"]))
        for annotation in part["annotations"]:
            number += 1
            told = {"id": number, "image_id": part["image"]["id"], **annotation}
            yield ",\n" * (number > 1) + json.dumps(told)
    yield f'],\n"images": [{", ".join(images)}],\n"categories": {json.dumps(CATEGORIES)}}}\n'


def _slot(slot: ParkingSlot, smooth: float) -> dict:
    u0, v0, u1, v1 = slot.region.bounds
    keypoints: list[float] = []
    for (u, v), visibility in zip(slot.corners, slot.visibility, strict=True):
        place = [0, 0] if visibility == OUTSIDE else [round(u - 0.5, 3), round(v - 0.5, 3)]
        keypoints += [*place, visibility]
    return {
        "category_id": 1,
        "bbox": [round(number, 3) for number in (u0, v0, u1 - u0, v1 - v0)],
        "area": round(slot.region.area, 3),
        "segmentation": [_ring(polygon, smooth) for polygon in slot.region.geoms],
        "iscrowd": 0,
        "keypoints": keypoints,
        "num_keypoints": sum(visibility != OUTSIDE for visibility in slot.visibility),
        "kind": slot.kind,
        "outline": slot.outline,
        "marks": list(slot.marks),
        "angle": round(slot.angle, 3),
    }


def _ring(polygon: shapely.Polygon, smooth: float) -> list[float]:
    points = shapely.get_coordinates(shapely.simplify(polygon, smooth).exterior)[:-1]
    return points.round(3).ravel().tolist()


def _marking(kind: str, mask: np.ndarray) -> dict:
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    u0, v0 = int(columns[0]), int(rows[0])
    return {
        "category_id": 2,
        "bbox": [u0, v0, int(columns[-1]) + 1 - u0, int(rows[-1]) + 1 - v0],
        "area": int(mask.sum()),
        "segmentation": {"size": list(mask.shape), "counts": _runs(mask)},
        "iscrowd": 0,
        "kind": kind,
    }


def _runs(mask: np.ndarray) -> list[int]:
    """Lengths of the runs of 0, 1, 0, … down the columns, one column after the other; the first run is of 0."""
    flat = np.concatenate([[False], mask.ravel(order="F")])
    ends = np.append(np.flatnonzero(flat[1:] != flat[:-1]), mask.size)
    return np.diff(ends, prepend=0).tolist()
