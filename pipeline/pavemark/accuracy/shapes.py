"""Outlines as judged by the geometry stage: bent, simplified, and placed far from the origin.

For each there are ways to do it, by family and setting, and a function from what a way returns to its errors in pixels:
"error", Hausdorff's distance to the reference, and "marking_point", the worst of the marking points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import cv2
import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon

from pavemark.accuracy import marked
from pavemark.background.contours import outlines, simplified
from pavemark.geometry.coverage import coverage
from pavemark.geometry.elastic import displace
from pavemark.geometry.outline import STEP, bend, outline
from pavemark.ground import Frame
from pavemark.scene import Marking

FRAME = Frame()

TURN = math.radians(17.0)
"""A row askew, so that no side of it runs along the pixels."""

STEPS = (0.8, 0.4, 0.2, 0.1, STEP, 0.025, 0.0125)
FINEST = STEP / 32
"""Metres between the points of bent lines, and of their reference: the error falls with the square."""

TOLERANCES = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0)
"""Pixels by which Douglas and Peucker may move an outline."""

OURS = "GEOS at 1 % of the length"

DENSE = 0.02
"""Share of a side after which Hausdorff's distance is looked for again."""

Ways = Mapping[tuple[str, str], Callable[[], Any]]
Errors = dict[str, float]


def _lines() -> list[LineString]:
    """The centre lines of a row."""
    return [LineString([*stroke.path, stroke.path[0]] if stroke.closed else stroke.path) for stroke in marked.row()]


def bending() -> Ways:
    """A line bent by the elastic field is a chain of chords."""
    return {("chords", f"{step:g} m"): partial(bend, _lines(), marked.BENT, step) for step in STEPS}


def bent_errors(made: np.ndarray) -> Errors:
    """Vertices lie on the true curve: only the curve's points can be off the chords."""
    true = bend(_lines(), marked.BENT, FINEST)
    far = max(
        shapely.distance(shapely.points(shapely.get_coordinates(curve)), chords).max()
        for curve, chords in zip(true, made, strict=True)
    )
    # The first line is the row's outline, on which all marking points lie.
    off = shapely.distance(shapely.points(displace(marked.BENT, marked.marking_points())), made[0]).max()
    return {"error": far * FRAME.scale, "marking_point": off * FRAME.scale}


@cache
def drawn() -> Polygon:
    """The outline of a row as it is drawn, in image coordinates."""
    (shape,) = outline(Marking("slot", marked.FRESH, marked.row(turn=TURN)), None).geoms
    return shapely.transform(shape, FRAME.to_image)


@cache
def masked() -> Polygon:
    """The same as a mask has it, along the borders of pixels."""
    shape = MultiPolygon([shapely.geometry.polygon.orient(shapely.transform(drawn(), FRAME.to_world))])
    (found,) = outlines(coverage(shape, FRAME) >= 0.5)
    return found.normalize()  # the ring begins at a corner


def simplifying() -> Ways:
    """The outline of a mask with fewer points, by Douglas and Peucker's ε."""
    return {
        (OURS, ""): lambda: simplified(masked()),
        **{("GEOS", f"ε={e:g}"): partial(masked().simplify, e) for e in TOLERANCES},
        **{("OpenCV", f"ε={e:g}"): partial(_approximated, masked(), e) for e in TOLERANCES},
    }


def _approximated(shape: Polygon, tolerance: float) -> Polygon:
    rings = [
        cv2.approxPolyDP(shapely.get_coordinates(ring)[:-1].astype(np.float32), tolerance, closed=True)[:, 0]
        for ring in (shape.exterior, *shape.interiors)
    ]
    shell, *holes = (ring.astype(np.float64) for ring in rings)
    return Polygon(shell, [hole for hole in holes if len(hole) > 2])


def simplified_errors(made: Polygon) -> Errors:
    """Against the outline that the mask was drawn from; marking points are its corners."""
    true = drawn()
    corners, kept = (shapely.get_coordinates(shape) for shape in (true, made))
    nearest = np.linalg.norm(corners[:, None] - kept[None], axis=-1).min(1)
    far = shapely.hausdorff_distance(true.boundary, made.boundary, densify=DENSE)
    return {"error": far, "marking_point": float(nearest.max())}


@cache
def _ring() -> np.ndarray:
    """Points (N, 2) of a row's outline every centimetre, metres."""
    shape = outline(Marking("slot", marked.FRESH, marked.row(turn=TURN)), None)
    return shapely.get_coordinates(shapely.segmentize(shape.geoms[0].exterior, 0.01))


def placing(distance: float) -> Ways:
    """World to pixels where the frame's centre lies far from the origin."""
    centre = np.array((distance, distance))
    world = _ring() + centre

    def mapped(kind: type) -> np.ndarray:
        at, scale = world.astype(kind), kind(FRAME.scale)
        shift = (scale * centre - (FRAME.width / 2, FRAME.height / 2)).astype(kind)
        return scale * at - shift

    def local() -> np.ndarray:
        at = (world - centre).astype(np.float32)
        return np.float32(FRAME.scale) * at + np.float32(FRAME.width / 2)

    return {
        ("float64", ""): partial(mapped, np.float64),
        ("float32", ""): partial(mapped, np.float32),
        ("float32 from the frame's centre", ""): local,
    }


def placed_errors(made: np.ndarray) -> Errors:
    """Against pixels that never saw the distance; a marking point is the worst of all points."""
    true = FRAME.scale * _ring() + (FRAME.width / 2, FRAME.height / 2)
    made = made.astype(np.float64)
    far = shapely.hausdorff_distance(LineString(true), LineString(made))
    return {"error": far, "marking_point": float(np.linalg.norm(made - true, axis=-1).max())}
