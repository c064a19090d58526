"""What a scene is expected to cost, by a measured table that ships (`pavemark accuracy --stage effects`)."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import attrs

from pavemark import assets
from pavemark.plan import PAINT_EFFECTS, plan
from pavemark.records import from_json, within
from pavemark.scene import Scene

SHIPPED = "accuracy/costs.json"

_seconds = within(-1.0, 1e4)


@attrs.frozen
class Costs:
    """Seconds of processor time an image, measured on one thread.

    Attributes
    ----------
    versions : dict of str to str
        What it was measured with.
    pixels : int
        Of the image.
    plain : float
        Of an image with markings and no effect, one ray a pixel.
    ray : float
        Of each ray a pixel more.
    effects : dict of str to float
        Of each effect, switched on alone.
    """

    versions: dict[str, str]
    pixels: int = attrs.field(validator=within(1, 10**9))
    plain: float = attrs.field(validator=_seconds)
    ray: float = attrs.field(validator=_seconds)
    effects: dict[str, float]

    def expected(self, scene: Scene) -> float:
        """Seconds that a scene is expected to take, in proportion to its pixels; what is not rendered costs nothing."""
        todo = plan(scene)
        named = {name for name in self.effects if name not in PAINT_EFFECTS and getattr(scene, name) is not None}
        named |= {name for nodes in todo.nodes for name in nodes}
        seconds = sum(max(self.effects[name], 0.0) for name in named & self.effects.keys())
        if scene.markings:
            seconds += self.plain + (scene.rays - 1) * self.ray
        return seconds * scene.plate.frame.width * scene.plate.frame.height / self.pixels


@lru_cache(maxsize=1)
def shipped() -> Costs:
    """The table that ships.

    Raises
    ------
    InputError
        When it is missing or damaged.
    """
    return read(assets.path(SHIPPED))


def read(path: Path) -> Costs:
    """A table from its file.

    Raises
    ------
    InputError
        When it cannot be read, or is no such table.
    """
    return from_json(Costs, path)
