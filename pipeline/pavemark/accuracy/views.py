"""Views that rays are calibrated on: pieces of drawn scenes, as large as is needed to see edges and ageing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count

import attrs
import numpy as np

from pavemark.accuracy import marked
from pavemark.accuracy.edges import SHARE
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.plan import LIGHT, PAINT_EFFECTS
from pavemark.randomize import texture
from pavemark.randomize.domains import Domains
from pavemark.randomize.scene import randomize
from pavemark.scene import Marking, Path, Scene

FEWEST = 100
"""Pixels on edges without which a view tells nothing."""

NEAR = 4.5
"""Metres from the centre within which a drawn scene certainly has its paint."""

AWAY = 0.5
"""Metres by which a view's centre lies beside a marking's point."""

WIDE = texture.Ranges(
    grain=texture.GrainRanges(contrast=(0.03, 0.6)),
    wear=texture.WearRanges(amount=(0.0, 0.6), edge_amount=(0.0, 0.8)),
    chips=texture.ChipsRanges(share=(0.01, 0.3)),
    cracks=texture.CracksRanges(width=(0.001, 0.03)),
    dirt=texture.DirtRanges(strength=(0.05, 1.0)),
    pattern=texture.PatternRanges(strength=(0.1, 1.0)),
)
"""What the effects may be, wider than in any preset, so that a job may go beyond the presets too."""


def ageing(domains: Domains, effects: tuple[str, ...], rate: float = 1.0) -> Domains:
    """Domains in which a share of markings has each of these effects, of any strength, and no other."""
    rates = {name: attrs.evolve(getattr(WIDE, name), rate=rate if name in effects else 0.0) for name in PAINT_EFFECTS}
    former = attrs.evolve(domains.texture.former, rate=0.5 if "wear" in effects else 0.0)
    return attrs.evolve(
        domains,
        texture=attrs.evolve(WIDE, former=former, **rates),
        layout=attrs.evolve(domains.layout, empty_rate=0.0, symbol_rate=0.3),
    )


def views(domains: Domains, frame: Frame, seed: int) -> Iterator[Scene]:
    """Pieces of scenes that are drawn one after the other, each with some edges in it.

    Parameters
    ----------
    domains : Domains
    frame : Frame
        Of the view; its centre lies near some point of a marking.
    seed : int
    """
    whole, ref = marked.asphalt(Frame()), marked.asphalt(frame).ref
    for number in count():
        drawn = randomize(whole, number, seed, domains)
        points = np.array([point for marking in drawn.markings for stroke in marking.strokes for point in stroke.path])
        rng = np.random.default_rng((seed, number))
        centre = _some(points, rng) + rng.uniform(-AWAY, AWAY, 2)
        seen = attrs.evolve(_moved(drawn, centre), plate=ref)
        if on_edges(seen).sum() >= FEWEST:
            yield seen


def on_edges(scene: Scene) -> np.ndarray:
    """The pixels (H, W) that an edge of any marking crosses."""
    shares = [coverage(outline(marking, scene.curvature), scene.plate.frame) for marking in scene.markings]
    return np.any([(share > SHARE) & (share < 1 - SHARE) for share in shares], axis=0)


def _some(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    near = points[np.abs(points).max(1) < NEAR]
    among = near if len(near) else points
    return among[rng.integers(len(among))]


def _moved(scene: Scene, centre: np.ndarray) -> Scene:
    """The paint of a scene with another origin; without its labels, and without what is done to the finished image."""

    def path(points: Path) -> Path:
        return tuple((float(x - centre[0]), float(y - centre[1])) for x, y in points)

    def marking(one: Marking) -> Marking:
        return attrs.evolve(
            one,
            strokes=_each(one.strokes, lambda stroke: attrs.evolve(stroke, path=path(stroke.path))),
            areas=_each(
                one.areas, lambda area: attrs.evolve(area, ring=path(area.ring), holes=_each(area.holes, path))
            ),
        )

    dropped = dict.fromkeys((*LIGHT, "optics", "brightness", "noise"))
    tyres = scene.tyres and attrs.evolve(scene.tyres, tracks=_each(scene.tyres.tracks, path))
    return attrs.evolve(
        scene,
        markings=_each(scene.markings, marking),
        slots=(),
        tyres=tyres,
        **dropped,
    )


def _each(things: tuple, change: Callable) -> tuple:
    return tuple(map(change, things))
