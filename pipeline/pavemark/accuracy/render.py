"""The render stage: what rays, filters and engines cost, and how far the edges that they draw are from the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from statistics import median

import attrs
import numpy as np

from pavemark.accuracy.apart import Answer, Apart
from pavemark.accuracy.edges import (
    FRESH,
    LIT,
    PAINTS,
    WORN,
    Setting,
    edges,
    errors,
    exact,
    fresh,
    half_shadow,
    picture,
    scene,
    shaded,
    work,
)
from pavemark.accuracy.figure import Axis
from pavemark.accuracy.race import Contender, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import Point, duration, families, points, power
from pavemark.accuracy.write_up import Wording, written
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.layers import Renderer
from pavemark.plan import RAYS, Sampling

FRAME, QUICK_FRAME = Frame(300, 300), Frame(120, 120)

REFERENCE, QUICK_REFERENCE = 4096, 1024
"""Rays a pixel of the reference where paint is worn, 16 times those of any contender."""

ANOTHER = 1
"""The seed of the reference's rays; the contenders have 0."""

ROUNDS, QUICK_ROUNDS = 5, 2

HARD, COVERAGE, EEVEE = "hard-edged", "coverage", "EEVEE"
RAYS_ALONE = "rays"

PATIENCE = 60.0
"""Seconds that EEVEE is given for a picture, shaders compiled: a graphics card takes one, a processor that plays one
minutes."""

EEVEE_ONCE = Setting(1, Sampling(engine="eevee", hard=True))


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
            (f"{kind} ({width:g} px)", str(n)): Setting(n, Sampling(filter=kind, width=width))
            for kind, width in (("gaussian", 1.0), ("gaussian", 1.5), ("blackman-harris", 1.5))
            for n in few
        },
        **{
            (f"adaptive (≤ {most})", f"at {noise:g}"): Setting(most, Sampling(threshold=noise))
            for noise in ((0.1, 0.01) if quick else (0.3, 0.1, 0.03, 0.01))
        },
        **{("denoised", str(n)): Setting(n, Sampling(denoise=True)) for n in ((16,) if quick else few)},
        **({} if quick else {(EEVEE, str(n)): Setting(n, Sampling(engine="eevee", hard=True)) for n in (1, 16)}),
    }


def lit_settings(quick: bool) -> dict[tuple[str, str], Setting]:
    """What is held against each other where light is simulated."""
    return {
        **{(RAYS_ALONE, str(n)): Setting(n, Sampling()) for n in ((1, 4, 8, 16) if quick else (1, 4, 8, 16, 64, 256))},
        **{
            (f"adaptive (≤ {most})", f"at {noise:g}"): Setting(most, Sampling(threshold=noise))
            for most in ((64,) if quick else (256,))
            for noise in (0.1, 0.03, 0.01)
        },
        **{("denoised", str(n)): Setting(n, Sampling(denoise=True)) for n in (4, 16)},
    }


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
    asked, lit = settings(quick), lit_settings(quick)
    of = dict.fromkeys(PAINTS, asked) | {LIT: lit}
    # An engine that finds no GPU may end its process, or take for ever.
    with Apart(work, "render") as blender, Apart(work, "render", patience=PATIENCE) as eevee:
        start = blender(make, "", frame, asked[COVERAGE, "1"])
        first = blender(make, FRESH, frame, asked[COVERAGE, "1"])
        left_out = _without_gpu(lambda: eevee(make, FRESH, frame, EEVEE_ONCE), quick)
        most = Setting(QUICK_REFERENCE if quick else REFERENCE, Sampling(seed=ANOTHER))
        worn, seen = (blender(make, problem, frame, most).value for problem in (WORN, LIT))

        def ask(one: Contender) -> Answer:
            process = eevee if one.family == EEVEE else blender
            return process(make, one.problem, frame, of[one.problem][one.family, one.setting])

        contenders = [
            Contender(problem, family, setting, family == COVERAGE)
            for problem in PAINTS
            for family, setting in asked
            if not (left_out and family == EEVEE)
        ]
        shipped = (RAYS_ALONE, str(RAYS["shadows"]))
        contenders += [Contender(LIT, *one, one == shipped) for one in lit]
        runs, failed = race(contenders, ask, QUICK_ROUNDS if quick else ROUNDS, watcher)
    share = exact(scene(FRESH, frame))
    truths = {FRESH: fresh(share), WORN: picture(worn), LIT: shaded(seen)}
    edge = edges(share)
    where = dict.fromkeys(PAINTS, edge) | {LIT: half_shadow(seen)}

    def judge(run: Run) -> dict[str, float]:
        problem = run.contender.problem
        samples = of[problem][run.contender.family, run.contender.setting].samples
        shown = (shaded if problem == LIT else picture)(run.value)
        return {"samples": samples, **errors(shown, truths[problem], where[problem])}

    made = points(runs, RenderPoint, judge)
    version, loaded = start.value
    startup = (
        f"Start-up, apart: {loaded:.2g} s from the start of a process to a renderer that is loaded, "
        f"{duration(first.seconds)} for its first picture, {duration(median(p.seconds for p in made if p.ships))} for "
        "each one more."
    )
    return written(
        "render",
        "Render: finding the edges of paint",
        made,
        Wording(
            unit="levels",
            axis=Axis("RMSE on edge pixels, 8-bit levels"),
            intro=_intro(frame, int(edge.sum()), most.samples, version),
            columns={
                "SSIM": lambda point: f"{point.ssim:.4f}",
                "FLIP": lambda point: "–" if np.isnan(point.flip) else f"{point.flip:.4f}",
            },
            remarks=(startup, *_slopes(made), *(left_out or [DRIVEN]), _lit(made)),
            failed=failed,
        ),
    )


def _without_gpu(once: Callable[[], object], quick: bool) -> list[str]:
    """Why EEVEE is not run; nothing where it draws a picture."""
    if quick:
        return [f"{EEVEE}: not run: it is left out when there is little time."]
    try:
        once()
    except InputError as error:
        return [f"{EEVEE}: not run: {' '.join(str(error).split())}."]
    return []


DRIVEN = (
    f"{EEVEE} draws through a graphics driver: its processor time is that of all threads where a program plays the "
    "card, and leaves out what a card does."
)


def _lit(made: Sequence[RenderPoint]) -> str:
    """What light costs beside paint alone."""
    unlit, lit = (next(p for p in made if p.problem == problem and p.ships) for problem in (WORN, LIT))
    return (
        f"Lit against unlit: shadows with {lit.samples} rays a pixel take {duration(lit.seconds)}, "
        f"{lit.seconds / unlit.seconds:.1f} times the {duration(unlit.seconds)} of worn paint with one. "
        "A pixel of light costs a ray to the ground and another to the sun."
    )


def _intro(frame: Frame, count: int, most: int, version: str) -> str:
    return (
        f"Twelve bent lines of paint, {frame.width}×{frame.height} pixels at {frame.scale:g} px/m, {count} of them cut "
        f"by an edge; {version}. The reference of fresh paint is the exact area of paint in each pixel, cut out by "
        f"GEOS, which nothing that is judged uses; that of worn paint is a render with {most} rays a pixel and another "
        "seed. Coverage is one ray, and the share of the pixel that paint covers is computed; in all else rays find "
        "the edges, and the setting is their number, or for adaptive sampling the noise at which it stops."
    )


def _slopes(made: Sequence[RenderPoint]) -> Iterator[str]:
    """How errors fall with rays and with time, for each way that has a row of numbers of rays."""
    for problem in (*PAINTS, LIT):
        said = []
        for family in families(made):
            of = [point for point in made if (point.problem, point.family) == (problem, family)]
            if len({point.samples for point in of}) > 1:
                error = [point.error for point in of]
                by_rays = power(error, [point.samples for point in of])
                by_time = power(error, [point.seconds for point in of])
                said.append(f"{family} {by_rays:.2f} and {by_time:.2f}")
        yield f"Exponents of the error by rays and by time, fitted, {problem}: {'; '.join(said)}."
