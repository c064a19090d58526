"""What a scene costs to render, told before it is rendered."""

from __future__ import annotations

from pavemark.plan import plan
from pavemark.scene import Scene


def lines(scene: Scene | None, seconds: float) -> list[str]:
    """The passes that a scene calls for, the steps after them, and what the last render took.

    Parameters
    ----------
    scene : Scene or None
    seconds : float
        Of the last render; 0 before the first.
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
    return [*told, f"The last render took {seconds:.2f} s"] if seconds else told


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
