"""The render stage: what rays, filters and engines cost, and how far the edges that they draw are from the truth."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from statistics import median

import attrs
import numpy as np
import shapely

from pavemark.accuracy import marked, measures
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.report import Report
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import Contender, Point, Run, families, points, power, race
from pavemark.accuracy.write_up import Wording, written
from pavemark.colour import LINEAR, quantise, to_display, to_linear
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.layers import Renderer
from pavemark.plan import Sampling, plan
from pavemark.scene import Scene

FRESH, WORN = "fresh paint", "worn paint"
PAINTS = {FRESH: marked.FRESH, WORN: marked.WORN}

FRAME, QUICK_FRAME = Frame(300, 300), Frame(120, 120)

REFERENCE, QUICK_REFERENCE = 4096, 1024
"""Rays a pixel of the reference where paint is worn, 16 times those of any contender."""

ANOTHER = 1
"""The seed of the reference's rays; the contenders have 0."""

ROUNDS, QUICK_ROUNDS = 5, 2

SHARE = 1e-3
"""Share of a pixel that must be covered, and must not be, for it to lie on an edge."""

HARD, COVERAGE, EEVEE = "hard-edged", "coverage", "EEVEE"


@attrs.frozen
class Setting:
    """What a contender renders with: rays a pixel, and how they are used."""

    samples: int
    sampling: Sampling


@attrs.frozen(kw_only=True)
class RenderPoint(Point):
    """A row of render.csv; `error` is the root mean square over the edge pixels, in 8-bit display levels.

    Attributes
    ----------
    samples : int
        Rays a pixel, at most.
    flip, ssim : float
        See `pavemark.accuracy.measures`, over the edge pixels; flip is nan where OpenImageIO is older than 3.2.
    """

    samples: int
    flip: float
    ssim: float


def settings(quick: bool) -> dict[tuple[str, str], Setting]:
    """What is held against each other, by family and setting."""
    most = 64 if quick else 256
    few = (16, 64)
    rays = [samples for samples in (1, 4, 16, 64, 256) if samples <= most]
    return {
        (COVERAGE, "1"): Setting(1, Sampling()),
        **{(HARD, str(n)): Setting(n, Sampling(hard=True)) for n in rays},
        **{
            (f"{kind} {width:g} px", str(n)): Setting(n, Sampling(filter=kind, width=width))
            for kind, width in (("gaussian", 1.0), ("gaussian", 1.5), ("blackman-harris", 1.5))
            for n in few
        },
        **{
            (f"adaptive up to {most}", f"{noise:g}"): Setting(most, Sampling(threshold=noise))
            for noise in ((0.1, 0.01) if quick else (0.3, 0.1, 0.03, 0.01))
        },
        **{("denoised", str(n)): Setting(n, Sampling(denoise=True)) for n in ((16,) if quick else few)},
        **({} if quick else {(EEVEE, str(n)): Setting(n, Sampling(engine="eevee", hard=True)) for n in (1, *few)}),
    }


def scene(problem: str, frame: Frame) -> Scene:
    """Twelve bent lines in one of PAINTS."""
    return marked.scattered(frame, PAINTS[problem])


def work(make: Callable[[], Renderer], problem: str, frame: Frame, setting: Setting) -> np.ndarray | str:
    """Render: for a process of its own. Without a problem it starts the renderer only, and returns its version."""
    renderer = _renderer(make)
    if not problem:
        return renderer.version
    shown = scene(problem, frame)
    planned = attrs.evolve(plan(shown), samples=setting.samples, sampling=setting.sampling)
    return renderer.render(shown, marked.asphalt(frame), planned).decals


@lru_cache(maxsize=1)
def _renderer(make: Callable[[], Renderer]) -> Renderer:
    # Renderers talk; what they say goes nowhere, and what they make comes back as a value.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    return make()


def picture(decals: np.ndarray) -> np.ndarray:
    """Display levels (H, W, 3), not rounded, of decals over even ground."""
    decals = decals.astype(np.float64)
    return to_display(np.clip(decals[..., :3] + (1 - decals[..., 3:]) * LINEAR[marked.TONE], 0.0, 1.0))


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


def report(make: Callable[[], Renderer], quick: bool, watcher: Watcher) -> Report:
    """Race the ways to render: render.svg, render.csv and render.md.

    Parameters
    ----------
    make : callable
        Starts a renderer, in a process that imports it.
    quick : bool
        With a smaller picture, fewer rays and rounds, and without EEVEE.
    watcher : Watcher

    Raises
    ------
    InputError
        When there is no renderer.
    """
    frame = QUICK_FRAME if quick else FRAME
    asked = settings(quick)
    contenders = [
        Contender(problem, family, setting, family == COVERAGE) for problem in PAINTS for family, setting in asked
    ]
    with Apart(work, "Blender") as blender, Apart(work, EEVEE) as eevee:
        start = blender(make, "", frame, asked[COVERAGE, "1"])
        first = blender(make, FRESH, frame, asked[COVERAGE, "1"])

        def ask(one: Contender):
            # An engine that finds no GPU may end its process.
            process = eevee if one.family == EEVEE else blender
            return process(make, one.problem, frame, asked[one.family, one.setting])

        most = Setting(QUICK_REFERENCE if quick else REFERENCE, Sampling(seed=ANOTHER))
        worn = blender(make, WORN, frame, most).value
        runs, failed = race(contenders, ask, QUICK_ROUNDS if quick else ROUNDS, watcher)
    share = exact(scene(FRESH, frame))
    colour = to_linear(np.array(marked.FRESH.rgb))
    fresh = np.concatenate([share[..., None] * colour, share[..., None]], -1)
    truths = {FRESH: picture(fresh), WORN: picture(worn)}
    edge = edges(share)

    def judge(run: Run) -> dict[str, float]:
        truth = truths[run.contender.problem]
        samples = asked[run.contender.family, run.contender.setting].samples
        return {"samples": samples, **errors(picture(run.value), truth, edge)}

    made = points(runs, RenderPoint, judge)
    startup = (
        f"Start-up, apart: {start.seconds:.2f} s to load Blender, {first.seconds:.2f} s for the first picture, "
        f"{median(point.seconds for point in made if point.ships):.3f} s for each one more."
    )
    left_out = [] if not quick else [f"{EEVEE}: not run: it is left out when there is little time."]
    return written(
        "render",
        "Render: finding the edges of paint",
        made,
        Wording(
            unit="levels",
            axis="RMSE on edge pixels, 8-bit levels",
            intro=_intro(frame, int(edge.sum()), most.samples, str(start.value)),
            columns={
                "SSIM": lambda point: f"{point.ssim:.4f}",
                "FLIP": lambda point: "–" if np.isnan(point.flip) else f"{point.flip:.4f}",
            },
            remarks=(startup, *_slopes(made), *dict.fromkeys((*failed, *left_out)), UNLIT),
        ),
    )


UNLIT = "Lit against unlit is not measured: no scene simulates light yet."


def _intro(frame: Frame, count: int, most: int, version: str) -> str:
    return (
        f"Twelve bent lines of paint, {frame.width}×{frame.height} pixels at {frame.scale:g} px/m, {count} of them cut "
        f"by an edge; {version}. The reference of fresh paint is the exact area of paint in each pixel, cut out by "
        f"GEOS, which nothing that is judged uses; that of worn paint is a render with {most} rays a pixel and another "
        "seed. Coverage is one ray, and the share of the pixel that paint covers is computed; in all else rays find "
        "the edges, and the setting is their number, or for adaptive sampling the noise at which it stops."
    )


def errors(shown: np.ndarray, truth: np.ndarray, edge: np.ndarray) -> dict[str, float]:
    """How far display levels (H, W, 3) are from the true ones on the edge pixels: "error", "ssim" and "flip"."""
    rounded, wanted = quantise(shown), quantise(truth)
    return {
        "error": float(np.sqrt(((shown - truth)[edge] ** 2).mean())),
        "ssim": measures.ssim(rounded, wanted, edge),
        "flip": measures.flip(rounded, wanted, edge),
    }


def _slopes(made: Sequence[RenderPoint]) -> Iterator[str]:
    """How errors fall with rays and with time, for each way that has a row of numbers of rays."""
    for problem in PAINTS:
        said = []
        for family in families(made):
            of = [point for point in made if (point.problem, point.family) == (problem, family)]
            if len({point.samples for point in of}) > 1:
                error = [point.error for point in of]
                by_rays = power(error, [point.samples for point in of])
                by_time = power(error, [point.seconds for point in of])
                said.append(f"{family} rays{by_rays:+.2f}, time{by_time:+.2f}")
        yield f"Fitted exponents of the error, {problem}: {'; '.join(said)}."
