"""What each effect of a scene costs: switched on alone, and switched on last."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import attrs
import numpy as np
from matplotlib.figure import Figure

from pavemark import __version__
from pavemark.accuracy import marked
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.edges import started
from pavemark.accuracy.machine import machine
from pavemark.accuracy.race import Contender, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.table import as_csv, markdown
from pavemark.accuracy.watcher import Watcher
from pavemark.accuracy.work_precision import duration
from pavemark.chart import COLOURS, svg
from pavemark.compose.image import compose
from pavemark.costs import Costs
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.layers import Renderer
from pavemark.light import Glare, Relief, Sun, Tube, Wet
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.records import to_json
from pavemark.scene import (
    Blend,
    Brightness,
    Chips,
    Cracks,
    Dirt,
    Grain,
    Marking,
    Noise,
    Optics,
    Paint,
    Pattern,
    Scene,
    Tyres,
    Wear,
)

FRAME, QUICK_FRAME = Frame(600, 600, 60.0), Frame(150, 150, 15.0)

ROUNDS, QUICK_ROUNDS = 5, 3

RAYS = 9
"""Rays a pixel of the image that tells what a ray costs."""

MORE_RAYS = f"{RAYS} rays"

EYES = ((0.0, 2.4, 0.66), (-1.1, 0.55, 1.02), (1.1, 0.55, 1.02), (0.0, -2.4, 0.88))
SUN = Sun(azimuth=2.6, elevation=0.6)

ON_PAINT = {
    "grain": Grain(0.02, 0.2, 1.0),
    "wear": Wear(0.2, 0.03, 0.4, 0.3, 0.15, 2.0),
    "chips": Chips(0.04, 0.1, 3.0),
    "cracks": Cracks(0.4, 0.005, 4.0),
    "dirt": Dirt(0.6, 0.3, 5.0),
    "pattern": Pattern("stripes", 0.1, 0.8, 0.5, 6.0),
}
ON_ALL = {
    "tyres": Tyres((((-5.0, -1.0), (5.0, -0.6)), ((-5.0, 0.5), (5.0, 0.9))), 0.2),
    "curvature": marked.BENT,
    "optics": Optics(((0.7, 1.2), (1.0, 1.5))),
    "relief": Relief(0.004, 0.006, SUN, 0.35),
    "shadows": marked.shaded(FRAME, 0.35),
    "wet": Wet(0.5, 0.4, 1.5, 0.4, (0.9, 0.95, 1.0), (0.15, 0.15, 0.14), 0.3, EYES, 7.0),
    "glare": Glare(
        tuple(
            Tube((x, y, 3.0), 1.2, 0.15, 0.0, (40.0, 40.0, 38.0)) for x in (-8.0, 0.0, 8.0) for y in (-6.0, 0.0, 6.0)
        ),
        0.25,
        0.05,
        EYES,
    ),
    "brightness": Brightness(0.8),
    "noise": Noise("gaussian", 4.0, 9),
}
EFFECTS = (*ON_PAINT, *ON_ALL)
"""Every effect that a scene may list, in the order of the tables."""


@attrs.frozen
class Cost:
    """A row of effects.csv: seconds of processor time an image, medians and quartiles over the rounds.

    Attributes
    ----------
    effect : str
    alone, alone_lower, alone_upper : float
        More than a scene without any effect takes.
    last, last_lower, last_upper : float
        More than a scene with all others takes.
    """

    effect: str
    alone: float
    alone_lower: float
    alone_upper: float
    last: float
    last_lower: float
    last_upper: float


def scene(frame: Frame, effects: Sequence[str]) -> Scene:
    """A row of three slots with those effects and no other."""
    paint = Paint(
        (210.0, 210.0, 205.0), (2.4, 2.4, 2.3), **{name: ON_PAINT[name] for name in effects if name in ON_PAINT}
    )
    return Scene(
        0,
        _ground(frame).ref,
        (Marking("slot", paint, marked.row()),),
        blend=Blend(),
        **{name: ON_ALL[name] for name in effects if name in ON_ALL},
    )


def work(make: Callable[[], Renderer], frame: Frame, effects: tuple[str, ...], rays: int) -> str:
    """Make an image, as a job does but for its labels and files: for a process of its own. The renderer's version."""
    shown, plate = attrs.evolve(scene(frame, effects), rays=rays), _ground(frame)
    todo, renderer = plan(shown), started(make)
    compose(shown, todo, plate, renderer.render(shown, plate, todo))
    return renderer.version


@lru_cache(maxsize=1)
def _ground(frame: Frame) -> Plate:
    return marked.asphalt(frame, texture=4.0)


def report(make: Callable[[], Renderer], quick: bool, watcher: Watcher) -> Report:
    """Measure every effect: effects.svg, effects.csv, effects.md, and costs.json, the table that ships.

    Parameters
    ----------
    make : callable
        Starts a renderer, in a process that imports it.
    quick : bool
        With a smaller picture and fewer rounds.
    watcher : Watcher

    Raises
    ------
    InputError
        When there is no renderer.
    """
    frame = QUICK_FRAME if quick else FRAME
    sets = {(): "plain", EFFECTS: "all"}
    sets |= {(name,): f"{name} alone" for name in EFFECTS}
    sets |= {tuple(other for other in EFFECTS if other != name): f"all but {name}" for name in EFFECTS}
    effects = {label: names for names, label in sets.items()}
    with Apart(work, "effects") as blender:
        version = blender(make, frame, (), 1).value
        contenders = [Contender("effects", label) for label in (*effects, MORE_RAYS)]
        runs, failed = race(
            contenders,
            lambda one: blender(make, frame, effects.get(one.family, ()), RAYS if one.family == MORE_RAYS else 1),
            QUICK_ROUNDS if quick else ROUNDS,
            watcher,
        )
    if failed:
        raise InputError(failed[0].contender.family, failed[0].reason)
    costs = _costs({run.contender.family: run for run in runs})
    seconds = {run.contender.family: float(np.median(run.seconds)) for run in runs}
    text = _told(frame, costs, seconds["plain"], seconds["all"], len(runs[0].seconds))
    drawn = svg("effects", lambda: _drawn(costs))
    table = Costs(
        versions={"pavemark": __version__, "renderer": version},
        pixels=frame.width * frame.height,
        plain=seconds["plain"],
        ray=(seconds[MORE_RAYS] - seconds["plain"]) / (RAYS - 1),
        effects={cost.effect: cost.alone for cost in costs},
    )
    files = {"effects.svg": drawn, "effects.csv": as_csv(costs, Cost), "costs.json": to_json(table), "effects.md": text}
    return Report(files, text)


def _costs(runs: dict[str, Run]) -> list[Cost]:
    rows = []
    for name in EFFECTS:
        # Round by round: what disturbs a round disturbs both.
        alone = np.subtract(runs[f"{name} alone"].seconds, runs["plain"].seconds)
        last = np.subtract(runs["all"].seconds, runs[f"all but {name}"].seconds)
        (a, b, c), (d, e, f) = (map(float, np.percentile(each, (25, 50, 75))) for each in (alone, last))
        rows.append(Cost(name, b, a, c, e, d, f))
    return rows


def _told(frame: Frame, costs: Sequence[Cost], plain: float, full: float, rounds: int) -> str:
    dearest = sorted(costs, key=lambda cost: -cost.alone)[:3]
    rows = [
        (
            cost.effect,
            _spread(cost.alone, cost.alone_lower, cost.alone_upper),
            _spread(cost.last, cost.last_lower, cost.last_upper),
        )
        for cost in costs
    ]
    told = [
        "# Effects: a scene pays for what it lists",
        f"A row of three slots, {frame.width}×{frame.height} pixels at {frame.scale:g} px/m, from the scene to the "
        "finished picture. An effect is switched on alone (against a scene without any) and last (against one with "
        "all others); what it costs is the difference, round by round.",
        f"{machine()} Processor time, median (quartiles) of {rounds} rounds; all ran in turn, round after round.",
        "![What effects cost](effects.svg)",
        f"Without any effect an image takes {duration(plain)}, with all of them {duration(full)}. The dearest, alone: "
        f"{', '.join(f'{cost.effect} {duration(cost.alone)}' for cost in dearest)}.",
        "Where the quartiles reach below nought, the effect is not to be told from noise. Tyres by themselves do "
        "nothing: they say where wear and dirt are. Relief follows the bent outline, so that curvature costs more "
        "where it is on.",
        markdown(("effect", "alone", "last"), rows),
    ]
    return "\n\n".join(told) + "\n"


def _spread(middle: float, lower: float, upper: float) -> str:
    told = f"{_ms(middle)} ({_ms(lower)} to {_ms(upper)}) ms"
    return told if lower > 0 else f"noise: {told}"


def _ms(seconds: float) -> str:
    return f"{1000 * seconds:.1f}".replace("-", "−")


def _drawn(costs: Sequence[Cost]) -> Figure:
    drawing = Figure(figsize=(7.5, 0.32 * len(costs) + 1.2), layout="constrained")
    axes = drawing.subplots()
    rows = np.arange(len(costs))
    for shift, which, colour in ((-0.18, "alone", COLOURS[0]), (0.18, "last", COLOURS[1])):
        middle, lower, upper = (
            np.array([1000 * getattr(cost, name) for cost in costs])
            for name in (which, f"{which}_lower", f"{which}_upper")
        )
        reach = np.maximum([middle - lower, upper - middle], 0)
        axes.barh(rows + shift, middle, 0.34, xerr=reach, color=colour, label=which, error_kw={"elinewidth": 0.8})
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_yticks(rows, [cost.effect for cost in costs])
    axes.invert_yaxis()
    axes.set_xlabel("processor time an image, ms")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.legend(loc="lower right")
    return drawing
