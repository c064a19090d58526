"""The table behind --max-error: the worst errors on edges over drawn views, as shares of the contrast of the paint."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import attrs
import cv2
import numpy as np
import scipy

from pavemark import __version__
from pavemark.accuracy import marked
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.edges import Setting, layer, started
from pavemark.accuracy.machine import machine
from pavemark.accuracy.report import Report
from pavemark.accuracy.table import as_csv, markdown
from pavemark.accuracy.views import ageing, on_edges, views
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import short
from pavemark.calibration import STRENGTH, Calibration, OneRay, Rays, contrast, parts
from pavemark.compose import blend
from pavemark.ground import Frame
from pavemark.layers import Layers, Renderer
from pavemark.plan import PAINT_EFFECTS, Sampling
from pavemark.plate import Plate
from pavemark.randomize.domains import Domains, preset
from pavemark.records import structure, to_json
from pavemark.scene import Scene

FRAMES = (Frame(96, 96, 10.0), Frame(96, 96, 22.0), Frame(140, 140, 60.0), Frame(160, 160, 120.0))
"""Of the views: scales from the coarsest that anyone has shown to twice the finest, and a line of paint or two."""

NUMBERS = (4, 8, 16, 32, 64, 128, 256, 512, 1024)
REFERENCE, QUICK_REFERENCE, LESS = 4096, 1024, 4
"""Rays of the reference of many rays, and how many times as many as any that is judged. What it is off itself is put
down to those, to be on the safe side."""

ONE_REFERENCE = 512
"""Rays of the reference of one ray: what it is off by would be lost in the sixth of effects, and counts for fresh
paint."""

VIEWS, QUICK_VIEWS = 12, 2
"""For each effect and scale, with one ray."""

MANY_VIEWS, QUICK_MANY_VIEWS = 3, 1
"""For each scale, fresh and with several effects, with many rays."""

MARGIN = 1.25
"""Factor on the worst that was measured: a view that was not may be worse."""

TEXTURE = 3.0
"""Levels of grain of the ground, which keeps a share of it under the paint."""

SEED, ANOTHER = 20261124, 1
"""Of the first effects' views, and of the reference's rays; those that are judged have 0."""

PRESET = "default"
"""Of the layouts, shapes and colours that views are drawn from."""

NAME = "rays.json"

FRESH, SEVERAL = "fresh", "several"

KINDS = {FRESH: ((), 1.0), **{name: ((name,), 1.0) for name in PAINT_EFFECTS}, SEVERAL: (PAINT_EFFECTS, 0.6)}
"""The effects that views are drawn with, and the share of markings that has each of them."""


@attrs.frozen(eq=False)
class Measured:
    """What rays made of a view.

    Attributes
    ----------
    effects : str
        One of KINDS.
    scene : Scene
    rays : int
    contrast : float
        Levels.
    error : float
        Root mean square over the edge pixels and the channels, levels.
    """

    effects: str
    scene: Scene
    rays: int
    contrast: float
    error: float

    @property
    def scale(self) -> float:
        """Pixels per metre."""
        return self.scene.plate.frame.scale

    @property
    def share(self) -> float:
        """The error as a share of the contrast."""
        return self.error / self.contrast


@attrs.frozen
class Row:
    """A row of calibration.csv: as `Measured`, and the error in levels that the table promises there."""

    effects: str
    scale: float
    rays: int
    contrast: float
    error: float
    promised: float


def work(make: Callable[[], Renderer], scene: Scene | None, rays: int, seed: int) -> np.ndarray | str:
    """The decals of a scene, or without one the renderer's version: for a process of its own."""
    return started(make).version if scene is None else layer(make, scene, "decals", Setting(rays, Sampling(seed=seed)))


def report(make: Callable[[], Renderer], quick: bool, watcher: Watcher) -> Report:
    """Measure a table: rays.json, calibration.csv and calibration.md.

    Parameters
    ----------
    make : callable
        Starts a renderer, in a process that imports it.
    quick : bool
        With fewer views and rays: it promises less.
    watcher : Watcher

    Raises
    ------
    InputError
        When there is no renderer.
    """
    few, many, most = (QUICK_VIEWS, QUICK_MANY_VIEWS, QUICK_REFERENCE) if quick else (VIEWS, MANY_VIEWS, REFERENCE)
    domains = structure(Domains, preset(PRESET), PRESET)
    numbers = [rays for rays in NUMBERS if LESS * rays <= most]
    measured: list[Measured] = []
    with Apart(work, "calibrate") as apart, watcher.of(len(FRAMES) * (len(KINDS) * few + 2 * many)):
        renderer = apart(make, None, 0, 0).value
        for seed, (frame, effects) in enumerate(itertools.product(FRAMES, KINDS), SEED):
            tasks = [((1,), ONE_REFERENCE)] * few + [(numbers, most)] * (many if effects in (FRESH, SEVERAL) else 0)
            for task, scene in zip(tasks, views(ageing(domains, *KINDS[effects]), frame, seed), strict=False):
                measured += _judged(scene, effects, *task, partial(_drawn, apart, make))
                watcher.step(False)
    table = tabled(measured, renderer)
    rows = [_row(one, table) for one in measured]
    text = _told(table, rows)
    return Report({NAME: to_json(table), "calibration.csv": as_csv(rows, Row), "calibration.md": text}, text)


def _drawn(apart: Apart, make: Callable[[], Renderer], scene: Scene, rays: int, seed: int) -> np.ndarray:
    return apart(make, scene, rays, seed).value


def _judged(
    scene: Scene, effects: str, numbers: Sequence[int], reference: int, drawn: Callable[[Scene, int, int], np.ndarray]
) -> Iterator[Measured]:
    plate = marked.asphalt(scene.plate.frame, TEXTURE, scene.index)
    edge, stands_out = on_edges(scene), contrast(scene, plate)
    truth = finished(scene, plate, drawn(scene, reference, ANOTHER))
    for rays in numbers:
        error = off(finished(scene, plate, drawn(scene, rays, 0)), truth, edge)
        yield Measured(effects, scene, rays, stands_out, error)


def finished(scene: Scene, plate: Plate, layer: np.ndarray) -> np.ndarray:
    """The image (H, W, 3) that decals come to, display levels, not rounded."""
    return blend.apply(plate, Layers(layer), scene.blend).astype(np.float64)


def off(image: np.ndarray, truth: np.ndarray, edge: np.ndarray) -> float:
    """Root mean square of the difference of images (H, W, 3) over the edge pixels (H, W) and the channels."""
    return float(np.sqrt(((image - truth)[edge] ** 2).mean()))


def tabled(measured: Sequence[Measured], renderer: str) -> Calibration:
    """The table that measured errors come to."""
    single = [one for one in measured if one.rays == 1]
    numbers = sorted({one.rays for one in measured} - {1})
    versions = {"numpy": np.__version__, "opencv": cv2.__version__, "scipy": scipy.__version__}
    one_ray = tuple(_one_ray([one for one in single if one.scale == frame.scale]) for frame in FRAMES)
    return Calibration(
        versions={"pavemark": __version__, "renderer": renderer, **versions},
        views=len({id(one.scene) for one in measured}),
        margin=MARGIN,
        one_ray=one_ray,
        together=_together([one for one in single if one.effects == SEVERAL], {row.scale: row for row in one_ray}),
        rays=tuple(
            Rays(number, _rounded(max(one.share for one in measured if one.rays == number))) for number in numbers
        ),
    )


def _one_ray(of: Sequence[Measured]) -> OneRay:
    """What effects add to fresh paint, for a strength of 1: errors that know nothing of each other add up squared."""
    fresh = [one.share for one in of if one.effects == FRESH]
    added = {
        name: max(
            math.sqrt(max(0.0, one.share**2 - min(fresh) ** 2)) / strength(name, one.scene)
            for one in of
            if one.effects == name
        )
        for name in PAINT_EFFECTS
    }
    return OneRay(of[0].scale, _rounded(max(fresh)), **{name: _rounded(share) for name, share in added.items()})


def _together(several: Sequence[Measured], one_ray: Mapping[float, OneRay]) -> float:
    """What share of the root sum of squares of their effects the worst view comes to, that the strongest does not."""
    shares = [0.0]
    for one in several:
        added = max(
            (parts(one_ray[one.scale], marking.paint) for marking in one.scene.markings),
            key=lambda row: math.hypot(*row),
        )
        if added and MARGIN * one.share > max(added):
            shares.append(MARGIN * one.share / math.hypot(*added))
    return min(1.0, float(f"{max(shares):.3g}"))


def _rounded(share: float) -> float:
    """With the margin, to three digits."""
    return float(f"{MARGIN * share:.3g}")


def strength(name: str, scene: Scene) -> float:
    """Of an effect, in the marking that has most of it."""
    effects = (getattr(marking.paint, name) for marking in scene.markings)
    return max(STRENGTH[name](effect) for effect in effects if effect is not None)


def _row(one: Measured, table: Calibration) -> Row:
    promised = one.contrast * table.share(one.scene, one.rays)
    return Row(one.effects, one.scale, one.rays, one.contrast, one.error, promised)


def _told(table: Calibration, rows: Sequence[Row]) -> str:
    closest = max(rows, key=lambda row: row.error / row.promised)
    told = [
        "# Rays: what they promise",
        f"Errors on edges of paint (root mean square, shares of the contrast of paint and ground) in {table.views} "
        f"views of drawn scenes, the worst times {MARGIN:g}; {table.versions['renderer']}. An effect counts by its "
        f"strength, and several by {table.together:g} of their root sum of squares, or the strongest.",
        machine(),
        markdown(
            ("one ray a pixel, at", "edge", *PAINT_EFFECTS),
            [
                (f"{row.scale:g} px/m", *(short(getattr(row, name)) for name in ("edge", *PAINT_EFFECTS)))
                for row in table.one_ray
            ],
        ),
        markdown(("rays a pixel", "error"), [(str(row.number), short(row.error)) for row in table.rays]),
        f"The smallest error that can be promised of any scene is {table.least:.2g} levels.",
        f"The closest call: {closest.error:.2g} levels where {closest.promised:.2g} are promised ({closest.effects}, "
        f"{closest.rays} ray{'' if closest.rays == 1 else 's'}, {closest.scale:g} px/m).",
        f'`max_error` goes by this table with `calibration = "{NAME}"` in the job file, or `--calibration {NAME}`.',
    ]
    return "\n\n".join(told) + "\n"
