"""What a scene costs to render, told before it is rendered."""

from __future__ import annotations

import math

from pavemark import costs
from pavemark.calibration import contrast, shipped
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.scene import Scene


def edges_off(scene: Scene, plate: Plate) -> float:
    """Levels of 255 that the table of rays promises edges of paint to be off by at most; -1 where it promises none."""
    factor = 1.0 if scene.brightness is None else scene.brightness.factor
    off = shipped().share(scene, scene.rays) * contrast(scene, plate) * factor if scene.markings else 0.0
    return off if math.isfinite(off) else -1.0


def lines(scene: Scene | None, seconds: float, off: float) -> list[str]:
    """The passes that a scene calls for, the steps after them, and what the last render took.

    Parameters
    ----------
    scene : Scene or None
    seconds : float
        Of the last render; 0 before the first.
    off : float
        Levels by which its edges are off at most, see `edges_off`.
    """
    if scene is None:
        return ["No scene yet: nothing to render"]
    todo = plan(scene)
    nodes = sum(map(len, todo.nodes))
    passes = ", ".join(f"{made.name}, {_counted(made.samples, 'ray')} a pixel" for made in todo.passes)
    told = [
        f"Passes: {passes or 'none, Blender does not render'}",
        f"In paint: {_counted(nodes, 'effect')} on {_counted(len(scene.markings), 'marking')}",
        f"Then: {' → '.join(todo.steps) or 'nothing, the plate as it is'}",
    ]
    told.append(f"Expected: {_duration(costs.shipped().expected(scene))} on one core, by the table")
    if seconds:
        told.append(f"The last render took {seconds:.2f} s")
        told += [f"Its edges are off by {off:.2g} levels at most, by the table"] * (off >= 0)
    return told


def _duration(seconds: float) -> str:
    return f"{1000 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
