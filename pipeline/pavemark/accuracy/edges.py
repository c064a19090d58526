"""Edges of paint as they are rendered, as they truly are, and how far the one is from the other."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import lru_cache

import attrs
import numpy as np
import shapely

from pavemark.accuracy import marked, measures
from pavemark.accuracy.clock import spent
from pavemark.colour import LINEAR, quantise, to_display, to_linear
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.layers import Renderer
from pavemark.plan import Pass, Sampling, plan
from pavemark.scene import Scene

FRESH, WORN = "fresh paint", "worn paint"
PAINTS = {FRESH: marked.FRESH, WORN: marked.WORN}

LIT = "shadows"
"""The problem that is lit."""

HALF = 0.02
"""Share of the sun that must be seen, and must not be, for a pixel to lie in half-shadow."""

LEFT = 0.35
"""Share of the light that is left in full shadow."""

SHARE = 1e-3
"""Share of a pixel that must be covered, and must not be, for it to lie on an edge."""


@attrs.frozen
class Setting:
    """What a contender renders with: rays a pixel, and how they are used."""

    samples: int
    sampling: Sampling


def scene(problem: str, frame: Frame) -> Scene:
    """Twelve bent lines in one of PAINTS; or bare ground that things outside the frame shade."""
    if problem == LIT:
        return Scene(0, marked.asphalt(frame).ref, shadows=marked.shaded(frame, LEFT))
    return marked.scattered(frame, PAINTS[problem])


def work(make: Callable[[], Renderer], problem: str, frame: Frame, setting: Setting) -> np.ndarray | tuple[str, float]:
    """Render: for a process of its own.

    Returns
    -------
    ndarray (H, W, C) float32, or (str, float)
        The decals, or the shadows. Without a problem the renderer is started only: its version, and the processor time
        in seconds that the process has used since it began.
    """
    if not problem:
        return started(make).version, spent()
    return layer(make, scene(problem, frame), "shadows" if problem == LIT else "decals", setting)


def layer(make: Callable[[], Renderer], shown: Scene, name: str, setting: Setting) -> np.ndarray:
    """Render one pass of a scene: for a process of its own.

    Returns
    -------
    ndarray (H, W, C) float32
    """
    planned = attrs.evolve(plan(shown), passes=(Pass(name, setting.samples, setting.sampling),))
    return getattr(started(make).render(shown, marked.asphalt(shown.plate.frame), planned), name)


@lru_cache(maxsize=1)
def started(make: Callable[[], Renderer]) -> Renderer:
    """The renderer of this process, which is started once."""
    # Renderers talk; what they say goes nowhere, and what they make comes back as a value.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    return make()


def picture(decals: np.ndarray) -> np.ndarray:
    """Display levels (H, W, 3), not rounded, of decals over even ground."""
    decals = decals.astype(np.float64)
    return to_display(np.clip(decals[..., :3] + (1 - decals[..., 3:]) * LINEAR[marked.TONE], 0.0, 1.0))


def shaded(seen: np.ndarray) -> np.ndarray:
    """Display levels (H, W, 3), not rounded, of even ground that sees a share (H, W, 1) of the sun."""
    light = LEFT + (1 - LEFT) * seen.astype(np.float64)
    return to_display(np.repeat(light * LINEAR[marked.TONE], 3, axis=-1))


def half_shadow(seen: np.ndarray) -> np.ndarray:
    """The pixels (H, W) that see a part (H, W, 1) of the sun only."""
    return (seen[..., 0] > HALF) & (seen[..., 0] < 1 - HALF)


def exact(shown: Scene) -> np.ndarray:
    """The share of each pixel (H, W) that paint covers, cut out pixel by pixel by GEOS.

    It shares no code with the coverage that a render of one ray is made with.
    """
    frame = shown.plate.frame
    shape = shapely.union_all([outline(marking, shown.curvature) for marking in shown.markings])
    lines = shapely.boundary(shape)
    v, u = np.mgrid[: frame.height, : frame.width]
    low, high = frame.to_world(np.stack([u, v + 1], -1)), frame.to_world(np.stack([u + 1, v], -1))
    cells = shapely.box(low[..., 0], low[..., 1], high[..., 0], high[..., 1])
    shapely.prepare([shape, lines])
    share = shapely.contains(shape, cells).astype(np.float64)
    cut = shapely.intersects(lines, cells)
    share[cut] = shapely.area(shapely.intersection(cells[cut], shape)) * frame.scale**2
    return share


def edges(share: np.ndarray) -> np.ndarray:
    """The pixels (H, W) that an edge crosses."""
    return (share > SHARE) & (share < 1 - SHARE)


def fresh(share: np.ndarray) -> np.ndarray:
    """Display levels of fresh paint that covers a share (H, W) of each pixel."""
    colour = to_linear(np.array(marked.FRESH.rgb))
    return picture(np.concatenate([share[..., None] * colour, share[..., None]], -1))


def errors(shown: np.ndarray, truth: np.ndarray, edge: np.ndarray) -> dict[str, float]:
    """How far display levels (H, W, 3) are from the true ones on the edge pixels: "error", "ssim" and "flip"."""
    rounded, wanted = quantise(shown), quantise(truth)
    return {
        "error": float(np.sqrt(((shown - truth)[edge] ** 2).mean())),
        "ssim": measures.ssim(rounded, wanted, edge),
        "flip": measures.flip(rounded, wanted, edge),
    }
