"""What a scene calls for: the only place that decides which passes are rendered and which steps are run."""

from __future__ import annotations

import attrs

from pavemark.records import one_of, within
from pavemark.scene import Paint, Scene

PAINT_EFFECTS = ("grain", "wear", "chips", "cracks", "dirt", "pattern")


ENGINES = ("cycles", "eevee")
FILTERS = ("box", "gaussian", "blackman-harris")


@attrs.frozen
class Sampling:
    """How the renderer finds what a pixel shows.

    Attributes
    ----------
    hard : bool
        Whether rays find the edges. Otherwise one ray a pixel, through its centre, meets paint whose coverage of the
        pixel is known; more rays than one find the edges in any case.
    filter : str
        One of FILTERS: how rays are weighed around the pixel's centre.
    width : float
        Pixels across of the filter. A box of 1 is the pixel's own mean.
    threshold : float
        Noise at which a pixel is sent no more rays ("adaptive sampling"); 0 sends each the same number.
    denoise : bool
    engine : str
        One of ENGINES.
    seed : int
        Of the rays' places in the pixel.
    """

    hard: bool = False
    filter: str = attrs.field(default="box", validator=one_of(*FILTERS))
    width: float = attrs.field(default=1.0, validator=within(0.01, 10.0))
    threshold: float = attrs.field(default=0.0, validator=within(0.0, 1.0))
    denoise: bool = False
    engine: str = attrs.field(default="cycles", validator=one_of(*ENGINES))
    seed: int = attrs.field(default=0, validator=within(0, 2**31 - 1))


@attrs.frozen
class Pass:
    """A picture that the renderer makes.

    Attributes
    ----------
    name : str
        The field of `pavemark.layers.Layers` that it fills.
    samples : int
        Rays a pixel.
    sampling : Sampling
    """

    name: str
    samples: int = 1
    sampling: Sampling = Sampling()

    @property
    def hard(self) -> bool:
        """Whether samples find the edges and coverage is not used."""
        return self.samples > 1 or self.sampling.hard


@attrs.frozen
class Plan:
    """What has to be done for one scene.

    Attributes
    ----------
    passes : tuple of Pass
        What the renderer makes; without any it is not started.
    colour : str
        "ratio" or "absolute": which of a paint's two colours the decals carry.
    nodes : tuple of tuple of str
        For each marking the effects for which shader nodes are built.
    steps : tuple of str
        Steps after rendering, in order: "optics", "blend", those of LIGHT, "brightness", "noise".
    """

    passes: tuple[Pass, ...]
    colour: str
    nodes: tuple[tuple[str, ...], ...]
    steps: tuple[str, ...]


LIGHT = ("relief", "shadows", "wet", "glare")
"""Effects that need light, in the order in which they reach the picture, each by a step of its own."""

RAYS = {"relief": 16, "shadows": 8, "wet": 1}
"""Rays a pixel of the passes by which light is simulated; what a smooth floor mirrors is known without (glare)."""


def plan(scene: Scene) -> Plan:
    """Decide what a scene calls for.

    Examples
    --------
    >>> from pavemark.scene import Brightness, PlateRef, Scene
    >>> plan(Scene(0, PlateRef("a", "0" * 64), brightness=Brightness(0.8))).steps
    ('brightness',)
    """
    painted = bool(scene.markings)
    lit = [effect for effect in LIGHT if getattr(scene, effect) is not None]
    passes = (Pass("decals", scene.rays),) * painted + tuple(
        Pass(effect, RAYS[effect]) for effect in lit if effect in RAYS
    )
    steps = ["optics"] * (scene.optics is not None and bool(passes)) + ["blend"] * painted + lit
    steps += [step for step in ("brightness", "noise") if getattr(scene, step) is not None]
    ratio = painted and scene.blend.method == "reflectance"
    return Plan(
        passes=passes,
        colour="ratio" if ratio else "absolute",
        nodes=tuple(paint_effects(marking.paint) for marking in scene.markings),
        steps=tuple(steps),
    )


def paint_effects(paint: Paint) -> tuple[str, ...]:
    """Names of the paint's effects that are listed, in the order in which they apply."""
    return tuple(name for name in PAINT_EFFECTS if getattr(paint, name) is not None)
