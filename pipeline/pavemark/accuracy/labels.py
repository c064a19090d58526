"""The labels stage: what label files cost to write, and how many pixels they are off when they are read back."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache, partial
from itertools import count, islice
from typing import Any

import attrs
import cv2
import numpy as np
import shapely
from scipy.spatial.distance import cdist

from pavemark import files
from pavemark.accuracy import label_files, marked
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.figure import Axis
from pavemark.accuracy.race import Contender, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import Point, duration, points
from pavemark.accuracy.write_up import Wording, written
from pavemark.background.contours import outlines
from pavemark.geometry.elastic import displace
from pavemark.geometry.outline import STEP, bend, outline, polygons
from pavemark.ground import Frame
from pavemark.labels import coco, dmpr, masks, ps2, yolo
from pavemark.labels.truth import LABELLED, Truth, truth
from pavemark.plate import Plate
from pavemark.randomize.domains import Domains, preset
from pavemark.randomize.scene import randomize
from pavemark.records import structure
from pavemark.scene import Scene

PRESET, SEED, IMAGES = "default", 11, 8
"""What the labelled scenes are drawn from, and how many of them."""

ROUNDS, QUICK_ROUNDS = 15, 3

LEAST = 0.01
"""Seconds that each is timed for."""

FINEST = STEP / 32
"""Metres between the points of the exact floors' sides."""

SMOOTH = (0.0, 0.01, 0.02, coco.SMOOTH, 0.1, 0.2, 0.5, 1.0)
"""Pixels by which sides of COCO's polygons may be straightened."""

SUBPIXEL = 8
"""Bits of a pixel's fraction that OpenCV is given."""

POINTS, FLOORS, LINES = "marking points", "slot floors, COCO, by the pixels a side may move", "line masks"

DENSE = 0.1
"""Pixels after which a distance is looked for again."""

BORDER = 1.5
"""Pixels: where the frame cuts paint, its mask has a border that the paint has not."""

Encoded = Callable[[Truth], bytes]


@attrs.frozen(kw_only=True)
class LabelPoint(Point):
    """A row of labels.csv; `error` is the worst of all images in pixels, times are of one image.

    Attributes
    ----------
    size : int
        Bytes an image, the mean.
    """

    size: int


def _coco(true: Truth, smooth: float = coco.SMOOTH) -> bytes:
    return json.dumps(coco.fragment(true, "image.png", smooth)).encode()


def _centres(true: Truth) -> bytes:
    x, y = np.moveaxis(true.frame.pixel_centres(), -1, 0)
    shapes = [shape for _, shape in true.markings]
    return files.png(shapely.contains_xy(shapely.union_all(shapes), x, y).astype(np.uint8))


def _filled(true: Truth, bits: int) -> bytes:
    """OpenCV's polygons; its whole numbers are the pixels' centres."""
    drawn = np.zeros(true.ground.shape, np.uint8)
    for part in shapely.get_parts(shapely.union_all([shape for _, shape in true.markings])):
        rings = (true.frame.to_image(shapely.get_coordinates(ring)) - 0.5 for ring in shapely.get_rings(part))
        cv2.fillPoly(drawn, [np.rint(ring * 2**bits).astype(np.int32) for ring in rings], 1, shift=bits)
    return files.png(drawn)


WAYS: Mapping[str, Mapping[tuple[str, str], Encoded]] = {
    POINTS: {
        ("ps2.0", ""): ps2.encode,
        ("DMPR", ""): lambda true: dmpr.encode(true).encode(),
        ("YOLO", ""): lambda true: yolo.encode(true).encode(),
        ("COCO", ""): _coco,
    },
    FLOORS: {("COCO", f"{smooth:g} px"): partial(_coco, smooth=smooth) for smooth in SMOOTH},
    LINES: {
        ("half of the pixel covered", ""): lambda true: files.png(masks.lines(true)),
        ("pixel's centre covered", ""): _centres,
        ("OpenCV, whole pixels", ""): partial(_filled, bits=0),
        ("OpenCV, 1/256 px", ""): partial(_filled, bits=SUBPIXEL),
    },
}

SHIPS = {
    *((POINTS, *way) for way in WAYS[POINTS]),
    (FLOORS, "COCO", f"{coco.SMOOTH:g} px"),
    (LINES, "half of the pixel covered", ""),
}


def contenders() -> list[Contender]:
    """All ways to write each thing."""
    return [Contender(what, *way, (what, *way) in SHIPS) for what, ways in WAYS.items() for way in ways]


@cache
def _plate() -> Plate:
    return marked.asphalt(Frame())


@cache
def scenes() -> tuple[Scene, ...]:
    """Drawn scenes with slots, some of them bent, on ground that hides nothing."""
    domains = structure(Domains, preset(PRESET), PRESET)
    drawn = (randomize(_plate(), number, SEED, domains) for number in count())
    return tuple(islice((scene for scene in drawn if scene.slots), IMAGES))


@cache
def _truths() -> tuple[Truth, ...]:
    return tuple(truth(scene, _plate().ground) for scene in scenes())


def work(contender: Contender | None) -> list[bytes] | None:
    """The files of all images; without a contender the truth of all: for a process of its own."""
    if contender is None:
        _truths.__wrapped__()
        outline.cache_clear()
        return None
    encode = WAYS[contender.problem][contender.family, contender.setting]
    return [encode(true) for true in _truths()]


def judge(run: Run) -> dict[str, Any]:
    """How far the files of a contender are off, and how large they are."""
    one = run.contender
    off = {POINTS: partial(_points_off, READERS.get(one.family)), FLOORS: _floors_off, LINES: _lines_off}[one.problem]
    error = max(off(scene, data) for scene, data in zip(scenes(), run.value, strict=True))
    return {"error": error, "size": round(sum(map(len, run.value)) / len(run.value))}


READERS = {
    "ps2.0": (2, lambda data, frame: label_files.ps2_points(data)),
    "DMPR": (2, lambda data, frame: label_files.dmpr_points(data)),
    "YOLO": (4, lambda data, frame: label_files.yolo_points(data, frame.width, frame.height)),
    "COCO": (4, lambda data, frame: label_files.coco_points(data)),
}
"""How many corners of a slot a format has, from p1 on, and what reads them."""


def _corners(scene: Scene) -> np.ndarray:
    """Corners (S, 4, 2) of the slots in image coordinates."""
    return scene.plate.frame.to_image(displace(scene.curvature, np.array([slot.corners for slot in scene.slots])))


def _seen(scene: Scene) -> np.ndarray:
    """Which slots (S,) have a marking point in the frame."""
    return scene.plate.frame.contains(_corners(scene)[:, :2]).any(1)


def _points_off(reader: tuple[int, Callable], scene: Scene, data: bytes) -> float:
    number, read = reader
    frame = scene.plate.frame
    wanted = _corners(scene)[_seen(scene), :number].reshape(-1, 2)
    wanted, found = wanted[frame.contains(wanted)], read(data, frame)
    if not (len(wanted) and len(found)):
        return 0.0 if len(wanted) == len(found) else float("inf")
    far = cdist(wanted, found)
    return float(max(far.min(0).max(), far.min(1).max()))


def _floors_off(scene: Scene, data: bytes) -> float:
    frame = scene.plate.frame
    areas = bend(shapely.polygons(np.array([slot.corners for slot in scene.slots])), scene.curvature, FINEST)
    cut = shapely.clip_by_rect(shapely.transform(areas, frame.to_image), 0, 0, frame.width, frame.height)
    exact = [polygons(shape) for shape in cut[_seen(scene)]]
    pairs = zip([shape for shape in exact if not shape.is_empty], label_files.coco_floors(data), strict=True)
    return max((shapely.hausdorff_distance(true.boundary, found.boundary) for true, found in pairs), default=0.0)


def _lines_off(scene: Scene, data: bytes) -> float:
    """Hausdorff's distance of the border of a mask's pixels to the outline of the paint, away from the frame's."""
    frame = scene.plate.frame
    shapes = [outline(marking, scene.curvature) for marking in scene.markings if marking.kind in LABELLED]
    true = shapely.boundary(shapely.transform(shapely.union_all(shapes), frame.to_image))
    found = shapely.union_all([shape.boundary for shape in outlines(label_files.mask(data))])
    return max(_furthest(true, found, frame), _furthest(found, true, frame))


def _furthest(these: shapely.Geometry, those: shapely.Geometry, frame: Frame) -> float:
    inside = shapely.clip_by_rect(these, BORDER, BORDER, frame.width - BORDER, frame.height - BORDER)
    there = shapely.points(shapely.get_coordinates(shapely.segmentize(inside, DENSE)))
    return float(shapely.distance(there, those).max(initial=0.0))


def report(quick: bool, watcher: Watcher) -> Report:
    """Race them: labels.svg, labels.csv and labels.md.

    Parameters
    ----------
    quick : bool
        With fewer rounds.
    watcher : Watcher
    """
    with Apart(work, "labels", LEAST) as apart:
        apart(None)
        truths = apart(None).seconds / IMAGES
        runs, failed = race(contenders(), apart, QUICK_ROUNDS if quick else ROUNDS, watcher)
    each = [attrs.evolve(run, seconds=tuple(seconds / IMAGES for seconds in run.seconds)) for run in runs]
    made = points(each, LabelPoint, judge)
    return written(
        "labels",
        "Labels: what is written, read back",
        made,
        Wording(
            unit="px",
            axis=Axis("worst distance, pixels"),
            intro=INTRO,
            columns={"bytes an image": lambda point: f"{point.size:,}"},
            remarks=(
                "Formats are no rivals: COCO alone holds floors and the masks of markings too.",
                f"What all of them start from, the truth of a scene, takes {duration(truths)} an image.",
            ),
            failed=failed,
        ),
    )


INTRO = (
    f"{IMAGES} scenes of the preset {PRESET}, 600×600 pixels at 60 px/m, on ground that hides nothing; times are of "
    "one image. Files are read back by code that shares nothing with what wrote them. References: the corners as the "
    "elastic field moves them; floors whose sides have 32 times as many points as ship; the outline of the paint. Off "
    "is a marking point (DMPR, ps2.0), any corner in the frame (YOLO, COCO), a side of a floor, or the border of a "
    "mask's pixels, at worst."
)
