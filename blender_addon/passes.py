"""The pictures that the renderer makes: what stands on the stage for each, and what of the picture becomes its layer.

A pass is put on the stage alone: what one effect needs is neither seen nor paid for by another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np
import shapely

from pavemark.geometry.mirror import mirrored, seen_by
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.light import Shadows
from pavemark.plan import Pass, Plan
from pavemark.scene import Scene

from . import casters, floors, relief, sheets, sources
from .settings import Window
from .stage import Stage

Put = Callable[[Stage, Scene, Plan, Pass], Window | None]
"""Puts on the stage what a pass shows, and tells the pixels in which anything can show; None where there are none."""


@attrs.frozen
class Drawing:
    """How a pass becomes a layer.

    Attributes
    ----------
    put : callable
        See `Put`.
    channels : str
        What of R, G, B and A the layer holds.
    blank : float
        The layer where nothing is shown.
    """

    put: Put
    channels: str
    blank: float


def _decals(stage: Stage, scene: Scene, plan: Plan, made: Pass) -> Window | None:
    return stage.markings(scene, plan, made.hard)


def _relief(stage: Stage, scene: Scene, plan: Plan, made: Pass) -> Window | None:
    frame, paint = scene.plate.frame, scene.relief
    # Coats that lie on one another are one body: each alone would shade the other where their tops are level.
    whole = shapely.union_all([outline(marking, scene.curvature) for marking in scene.markings])
    mesh = relief.raised("Relief", whole, frame, paint)
    if mesh is None:
        return None
    white = stage.keep(floors.white("Pavemark white", None))
    mesh.materials.append(white)
    corners = [corner[:2] for corner in stage.add("Relief", mesh).bound_box]
    window = _around(None, corners, frame, paint.height / np.tan(paint.sun.elevation))
    if window is not None:
        stage.floor(frame, white)
        stage.lit_by("Pavemark sun", sources.sun("Pavemark sun", paint.sun))
    return window


def _shadows(stage: Stage, scene: Scene, plan: Plan, made: Pass) -> Window | None:
    frame, cast = scene.plate.frame, scene.shadows
    window = None
    for number, caster in enumerate(cast.casters):
        name = f"Caster {number} {caster.kind}"
        mesh = casters.mesh(name, caster)
        stage.add(name, mesh).visible_camera = False
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        shade, reach = _shade(points.reshape(-1, 3).astype(np.float64), cast)
        window = _around(window, shade, frame, reach)
    if window is not None:
        stage.floor(frame, stage.keep(floors.white("Pavemark white", cast.lamp)))
        shining = sources.sun("Pavemark sun", cast.sun) if cast.sun else sources.lamp("Pavemark lamp", cast.lamp)
        stage.lit_by("Pavemark light", shining)
    return window


def _wet(stage: Stage, scene: Scene, plan: Plan, made: Pass) -> Window | None:
    frame, ground = scene.plate.frame, scene.wet
    if not ground.share:
        return None
    points = frame.pixel_centres().reshape(-1, 2)
    nearest = np.asarray(ground.eyes)[seen_by(points, ground.eyes).argmax(-1)]
    rays = np.ones((frame.height, frame.width, 4), np.float32)
    rays.reshape(-1, 4)[:, :3] = mirrored(points, nearest)
    sheet = sheets.load("Pavemark mirrored", rays, frame)
    stage.keep(sheet.image)
    stage.floor(frame, stage.keep(floors.wet("Pavemark wet", ground, sheet)))
    return Window(0, 0, frame.width, frame.height)


PASSES = {
    "decals": Drawing(_decals, "RGBA", 0.0),
    "relief": Drawing(_relief, "R", 1.0),
    "shadows": Drawing(_shadows, "R", 1.0),
    "wet": Drawing(_wet, "RGBA", 0.0),
}


def _shade(points: np.ndarray, cast: Shadows) -> tuple[np.ndarray, float]:
    """Where shadows of points (N, 3) lie on the ground (N, 2), and how far half-shadows reach about them, metres."""
    height = points[:, 2:]
    if cast.sun is not None:
        azimuth, elevation = cast.sun.azimuth, cast.sun.elevation
        away = height / np.tan(elevation)
        half = cast.sun.angle / 2
        lowest = max(elevation - half, 1e-3)
        reach = float(height.max() / np.tan(lowest) - height.max() / np.tan(elevation)) + half * float(height.max())
        return points[:, :2] - away * (np.cos(azimuth), np.sin(azimuth)), reach
    place, radius = np.asarray(cast.lamp.place), cast.lamp.radius
    # What stands as high as the lamp shades all that lies behind it.
    below = np.maximum(place[2] - radius - height, 1e-6)
    stretched = (place[2] - radius) / below
    return place[:2] + (points[:, :2] - place[:2]) * stretched, radius * float((stretched - 1).max())


def _around(window: Window | None, points: Sequence[Sequence[float]], frame: Frame, reach: float) -> Window | None:
    """A window, widened by the pixels within `reach` metres of the box about points on the ground."""
    at = np.asarray(points)
    ends = frame.to_image(np.stack([at.min(0) - reach, at.max(0) + reach]))
    low, high = np.floor(ends.min(0)) - 1, np.ceil(ends.max(0)) + 1
    left, top = (int(max(value, 0)) for value in low)
    right, bottom = (int(min(value, side)) for value, side in zip(high, (frame.width, frame.height), strict=True))
    if left >= right or top >= bottom:
        return window
    if window is None:
        return Window(left, top, right, bottom)
    return Window(min(left, window.left), min(top, window.top), max(right, window.right), max(bottom, window.bottom))
