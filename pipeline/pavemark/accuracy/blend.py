"""The blend stage: what it costs to solve Poisson's equation for paint on ground, and what it costs not to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import attrs
import numpy as np

from pavemark.accuracy import marked, rivals
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.figure import Axis
from pavemark.accuracy.race import Contender, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import Point, points, short
from pavemark.accuracy.write_up import Wording, written
from pavemark.colour import quantise, to_linear
from pavemark.compose import blend, poisson
from pavemark.compose.blend import LOG, Asked, lit
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Blend, Marking

ROW, BLOCK = "a row of three slots, lines of 10 cm, bent", "a filled area of 4 m × 3 m"

GRAIN = 6.0
"""Levels of the plate's texture."""

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
QUICK = (1e-1, 1e-3, 1e-6, 1e-10)

ROUNDS, QUICK_ROUNDS = 7, 2

LEAST = 0.01
"""Seconds that each is timed for: an alpha blend takes a millisecond."""

ROUNDING = 1e-9
"""Levels within which a pixel counts as untouched: there and back through the logarithm."""

CHANGED = 0.5
"""Levels by which a pixel outside the domain must differ to count: less is rounded away."""


@attrs.frozen(kw_only=True)
class BlendPoint(Point):
    """A row of blend.csv; `error` is the worst of a channel in the domain, in 8-bit display levels.

    Attributes
    ----------
    residual : float
        Of the five-point equations in log linear light, as a share of their right side, Euclidean norm.
    outside : int
        Pixels outside the domain that changed by more than half a level.
    outside_worst : float
        The largest change there, in levels.
    """

    residual: float
    outside: int
    outside_worst: float


@attrs.frozen(eq=False)
class Problem:
    """A plate, what is to be painted on it, and the equation that asks for it."""

    plate: Plate
    layers: Layers
    asked: Asked

    @property
    def equation(self) -> tuple[np.ndarray, ...]:
        """As solvers take it."""
        asked = self.asked
        return asked.domain, asked.a, asked.b, asked.guidance, asked.boundary


@lru_cache(maxsize=2)
def problem(name: str, frame: Frame = Frame()) -> Problem:  # noqa: B008 - a frame does not change
    """ROW or BLOCK on a plate of our own."""
    if name == ROW:
        shape = outline(Marking("slot", marked.FRESH, marked.row()), marked.BENT)
    else:
        shape = outline(Marking("symbol", marked.FRESH, areas=(marked.block(4.0, 3.0),)), None)
    alpha = coverage(shape, frame)[..., None]
    layers = Layers(np.concatenate([alpha * marked.FRESH.ratio, alpha], -1).astype(np.float32))
    plate = marked.asphalt(frame, GRAIN)
    return Problem(plate, layers, blend.asked(plate, layers, Blend()))


def _solved(solver: Callable[..., np.ndarray], of: Problem) -> np.ndarray:
    return solver(*of.equation)


def _alpha(of: Problem) -> np.ndarray:
    """Paint over ground as it is, without an equation."""
    decals = of.layers.decals.astype(np.float64)
    painted = decals[..., 3] > blend.FAINTEST
    ratio = decals[painted, :3] + (1 - decals[painted, 3:])
    result = of.plate.image.astype(np.float64)
    result[painted] = lit(LOG[of.plate.image[painted]] + np.log(ratio))
    return result


def _seamless(of: Problem) -> np.ndarray:
    return rivals.seamless(of.asked.domain, quantise(_alpha(of)), of.plate.image)


def ways(tolerances: tuple[float, ...]) -> Mapping[tuple[str, str], Callable[[Problem], np.ndarray]]:
    """What is held against each other, by family and setting.

    What they return is log linear light of the domain (N, 3) or of the whole picture (H, W, 3), but for "alpha" and
    "seamlessClone" display levels of the whole picture.
    """
    preconditioned = partial(rivals.iterative, preconditioner=rivals.multigrid)
    return {
        ("direct", ""): partial(_solved, poisson.solve),
        ("sparse LU", ""): partial(_solved, rivals.whole),
        **{
            (family, f"{tolerance:.0e}".replace("e-0", "e-")): partial(_solved, partial(solver, tolerance=tolerance))
            for family, solver in (
                ("conjugate gradients", rivals.iterative),
                ("conjugate gradients with multigrid", preconditioned),
            )
            for tolerance in tolerances
        },
        ("sine transform", ""): partial(_solved, rivals.fast),
        (CLONE, ""): _seamless,
        (ALPHA, ""): _alpha,
    }


CLONE, ALPHA = "seamlessClone", "alpha"
SHIPS = "direct"


def work(contender: Contender, tolerances: tuple[float, ...]) -> np.ndarray:
    """What a contender makes of its problem: for a process of its own."""
    return ways(tolerances)[contender.family, contender.setting](problem(contender.problem))


def judge(run: Run) -> dict[str, Any]:
    """A contender's errors."""
    return errors(run.value, problem(run.contender.problem), run.contender.family in (CLONE, ALPHA))


def errors(value: np.ndarray, of: Problem, levels: bool) -> dict[str, Any]:
    """How far an answer is from the solution: "error", and the fields of `BlendPoint` that `Point` has not.

    Parameters
    ----------
    value : ndarray
        As one of `ways` returns it.
    of : Problem
    levels : bool
        Whether it is display levels.
    """
    domain, boundary = of.asked.domain, of.asked.boundary
    if levels:
        shown, beside = value[domain], value[~domain]
        log = np.log(to_linear(shown) + blend.DARKEST)
    else:
        log = value if value.ndim == 2 else value[domain]
        shown = lit(log.astype(np.longdouble))
        beside = lit((boundary if value.ndim == 2 else value)[~domain])
    change = np.abs(beside - of.plate.image[~domain].astype(np.float64))
    equations = poisson.system(*of.equation)
    left = equations.source - rivals.product(equations, log - boundary[domain])
    return {
        "error": float(np.abs(shown - _solution(of)).max()),
        "residual": float(np.linalg.norm(left) / np.linalg.norm(equations.source)),
        "outside": int((change > CHANGED).any(-1).sum()),
        "outside_worst": float(change.max(initial=0.0)) if change.max(initial=0.0) > ROUNDING else 0.0,
    }


@lru_cache(maxsize=2)
def _solution(of: Problem) -> np.ndarray:
    return lit(rivals.refined(*of.equation))


def report(quick: bool, watcher: Watcher) -> Report:
    """Race the solvers: blend.svg, blend.csv and blend.md.

    Parameters
    ----------
    quick : bool
        With fewer tolerances, and fewer rounds.
    watcher : Watcher
    """
    tolerances = QUICK if quick else TOLERANCES
    contenders = [
        Contender(name, family, setting, family == SHIPS)
        for name in (ROW, BLOCK)
        for family, setting in ways(tolerances)
    ]
    with Apart(work, "blend", LEAST) as apart:
        runs, failed = race(contenders, lambda one: apart(one, tolerances), QUICK_ROUNDS if quick else ROUNDS, watcher)
    made = points(runs, BlendPoint, judge)
    return written(
        "blend",
        "Blend: solving Poisson's equation",
        made,
        Wording(
            unit="levels",
            axis=Axis("worst colour error, 8-bit levels"),
            intro=INTRO,
            columns={
                "residual": lambda point: f"{point.residual:.1e}",
                "pixels changed outside": lambda point: f"{point.outside}",
                "by at most, levels": lambda point: short(point.outside_worst),
            },
            remarks=tuple(_remarks(made)),
            failed=failed,
        ),
    )


INTRO = (
    f"A plate of our own, 600×600, with a grain of {GRAIN:g} levels; what is timed is the way from the guidance to the "
    "solution: equations set up, factored or iterated, all three channels. The reference is a sparse factor refined "
    "with residuals in extended precision, some thousand times more exact than float64. alpha is paint over ground "
    "without an equation, seamlessClone OpenCV's way with the same picture: what they are off by is no rounding but "
    "another answer."
)


def _remarks(made: Sequence[BlendPoint]) -> Iterator[str]:
    """What the rivals that cannot keep to the domain do to what lies beside it."""
    for point in made:
        if point.outside:
            yield (
                f"{point.family}, {point.problem}: {point.outside} pixels outside the domain changed, "
                f"by up to {short(point.outside_worst)} levels."
            )
    yield (
        "The sine transform solves on the bounding rectangle and is exact only where the domain is one; elsewhere the "
        "plate inside the rectangle moves, and so does the paint."
    )
