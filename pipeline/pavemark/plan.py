"""What a scene calls for: the only place that decides which passes are rendered and which steps are run."""

from __future__ import annotations

import attrs

from pavemark.scene import Paint, Scene

PAINT_EFFECTS = ("grain", "wear", "chips", "cracks", "dirt", "pattern")


@attrs.frozen
class Plan:
    """What has to be done for one scene.

    Attributes
    ----------
    renders : bool
        Whether Blender's renderer is started at all.
    colour : str
        "ratio" or "absolute": which of a paint's two colours the decals carry.
    samples : int
        Rays a pixel. One, with analytic coverage, as no scene simulates light transport yet.
    nodes : tuple of tuple of str
        For each marking the effects for which shader nodes are built.
    steps : tuple of str
        Steps after rendering, in order: "optics", "blend", "brightness", "noise".
    """

    renders: bool
    colour: str
    samples: int
    nodes: tuple[tuple[str, ...], ...]
    steps: tuple[str, ...]


def plan(scene: Scene) -> Plan:
    """Decide what a scene calls for.

    Examples
    --------
    >>> from pavemark.scene import Brightness, PlateRef, Scene
    >>> plan(Scene(0, PlateRef("a", "0" * 64), brightness=Brightness(0.8))).steps
    ('brightness',)
    """
    painted = bool(scene.markings)
    steps = []
    if painted:
        steps += ["optics"] * (scene.optics is not None) + ["blend"]
    steps += [step for step in ("brightness", "noise") if getattr(scene, step) is not None]
    ratio = painted and scene.blend.method == "reflectance"
    return Plan(
        renders=painted,
        colour="ratio" if ratio else "absolute",
        samples=1,
        nodes=tuple(paint_effects(marking.paint) for marking in scene.markings),
        steps=tuple(steps),
    )


def paint_effects(paint: Paint) -> tuple[str, ...]:
    """Names of the paint's effects that are listed, in the order in which they apply."""
    return tuple(name for name in PAINT_EFFECTS if getattr(paint, name) is not None)
