"""What rays promise: a measured table of errors, and the fewest rays that keep a scene's edges within an error.

Errors on edges scale with the contrast of paint and ground; their shares of it hardly depend on the scene. Where rays
find the edges, the share is that of their number alone. One ray a pixel meets paint of known coverage, so its share is
that of the paint's effects: each counts by its strength, and several by a share of their root sum of squares, for their
worst do not come together.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import attrs
import numpy as np

from pavemark import __version__, assets
from pavemark.colour import LINEAR, lit_grey, to_display, to_linear
from pavemark.errors import InputError
from pavemark.plan import paint_effects
from pavemark.plate import Plate
from pavemark.records import from_json, to_json, within
from pavemark.scene import Blend, Chips, Cracks, Marking, Paint, Scene, Wear

SHIPPED = "accuracy/rays.json"

WHITE = 255.0
"""Levels that paint and ground can differ by at most."""

BRIGHT = 95
"""Percentile of the ground's pixels whose contrast with the paint counts: most edges have less."""

MANY = 2000
"""Pixels of the ground that are asked for it."""

_share = within(0.0, 10.0)


@attrs.frozen
class Rays:
    """So many rays a pixel, and the error on edges that they leave, a share of the contrast."""

    number: int = attrs.field(validator=within(2, 65536))
    error: float = attrs.field(validator=_share)


@attrs.frozen
class OneRay:
    """What one ray a pixel leaves at a scale, shares of the contrast.

    Attributes
    ----------
    scale : float
        Pixels per metre.
    edge : float
        Of fresh paint.
    grain, wear, chips, cracks, dirt, pattern : float
        Of each effect, for a strength of 1; see STRENGTH.
    """

    scale: float = attrs.field(validator=within(1.0, 10000.0))
    edge: float = attrs.field(validator=_share)
    grain: float = attrs.field(validator=_share)
    wear: float = attrs.field(validator=_share)
    chips: float = attrs.field(validator=_share)
    cracks: float = attrs.field(validator=_share)
    dirt: float = attrs.field(validator=_share)
    pattern: float = attrs.field(validator=_share)


@attrs.frozen
class Calibration:
    """A measured table.

    Attributes
    ----------
    versions : dict of str to str
        What it was measured with: "pavemark" and "renderer" among them.
    views : int
        How many it was measured on.
    margin : float
        Factor by which the errors that are told exceed the worst that were measured.
    one_ray : tuple of OneRay
        Ascending by scale.
    together : float
        The share of their root sum of squares that several effects come to, but for the strongest alone.
    rays : tuple of Rays
        Ascending, their errors descending.
    """

    versions: dict[str, str]
    views: int = attrs.field(validator=within(1, 10**9))
    margin: float = attrs.field(validator=within(1.0, 10.0))
    one_ray: tuple[OneRay, ...]
    together: float = attrs.field(validator=within(0.0, 1.0))
    rays: tuple[Rays, ...]

    def __attrs_post_init__(self) -> None:
        scales, numbers = [row.scale for row in self.one_ray], [row.number for row in self.rays]
        for name, values in (("one_ray", scales), ("rays", numbers)):
            if not values or any(low >= high for low, high in pairwise(values)):
                raise ValueError(f"{name}: rows that ascend are allowed, at least one")
        if any(few.error <= many.error for few, many in pairwise(self.rays)):
            raise ValueError("rays: errors that descend are allowed")

    @property
    def least(self) -> float:
        """The smallest error, in 8-bit levels, that can be promised of any scene."""
        return WHITE * self.rays[-1].error

    @property
    def sha256(self) -> str:
        """Hash of all that it says."""
        return hashlib.sha256(to_json(self).encode()).hexdigest()

    def fewest(self, scene: Scene, plate: Plate, error: float) -> int:
        """The fewest rays a pixel that keep an error.

        Parameters
        ----------
        scene : Scene
        plate : Plate
            The scene's.
        error : float
            Root mean square over the pixels that an edge of paint crosses and over the channels, in 8-bit levels of
            the finished image but for its noise; at least `least`. What simulates light has rays of its own, which
            are no part of it.
        """
        if not scene.markings:
            return 1
        brightness = 1.0 if scene.brightness is None else scene.brightness.factor
        most = error / max(brightness * contrast(scene, plate), 1e-9)
        numbers = [1, *(row.number for row in self.rays)]
        return next((rays for rays in numbers if self.share(scene, rays) <= most), numbers[-1])

    def share(self, scene: Scene, rays: int) -> float:
        """The error that so many rays a pixel leave, a share of the contrast.

        Of one ray it is that of the worst marking, at the worse of the two measured scales that the scene's lies
        between; inf where it lies between none.
        """
        if rays > 1:
            return next(row.error for row in self.rays if row.number == rays)
        scale = scene.plate.frame.scale
        below = [row for row in self.one_ray if row.scale <= scale]
        above = [row for row in self.one_ray if row.scale >= scale]
        if not (below and above):
            return math.inf
        return max(
            _combined(row, self.together, marking) for row in (below[-1], above[0]) for marking in scene.markings
        )


def _combined(row: OneRay, together: float, marking: Marking) -> float:
    added = parts(row, marking.paint)
    return math.hypot(row.edge, max([*added, together * math.hypot(*added)]))


def parts(row: OneRay, paint: Paint) -> list[float]:
    """What each effect of a paint adds, a share of the contrast."""
    return [getattr(row, name) * STRENGTH[name](getattr(paint, name)) for name in paint_effects(paint)]


def _worn(wear: Wear) -> float:
    return math.sqrt(0.1 / wear.size)


def _cracked(cracks: Cracks) -> float:
    return math.sqrt(min(1.0, cracks.width / cracks.size))


def _chipped(chips: Chips) -> float:
    return math.sqrt(chips.share)


STRENGTH: dict[str, Callable[..., float]] = {
    "grain": lambda grain: grain.contrast,
    "wear": _worn,
    "chips": _chipped,
    "cracks": _cracked,
    "dirt": lambda dirt: dirt.strength,
    "pattern": lambda pattern: pattern.strength,
}
"""How strong an effect is, in the measure that its error was found to follow: chips and cracks by the root of the share
of paint that they take, wear by the fineness of its patches (10 cm: 1) and by no amount."""


def contrast(scene: Scene, plate: Plate) -> float:
    """How far the scene's paint stands out from the plate's ground: display levels, at most WHITE.

    Root mean square over the channels, for the marking that stands out most, at the bright end of the ground.
    """
    levels = plate.image[plate.ground]
    if not len(levels):
        return 0.0
    levels = levels[:: max(1, len(levels) // MANY)]
    return max(_stands_out(marking, scene.blend, levels) for marking in scene.markings)


def _stands_out(marking: Marking, blend: Blend, levels: np.ndarray) -> float:
    paint, ground = marking.paint, LINEAR[levels]
    rough = 0.0 if paint.grain is None else paint.grain.contrast
    dark = 0.0 if paint.dirt is None else paint.dirt.strength
    found = []
    for factor in (1 + rough, (1 - rough) * (1 - dark)):
        # What would be brighter than white is not cut off here: its edge is as steep as if it were not.
        if blend.method == "reflectance":
            painted = factor * np.array(paint.ratio) * lit_grey(np.maximum(ground, LINEAR[1]))
            shown = to_display(ground + paint.opacity * (painted - ground))
        else:
            shown = levels + paint.opacity * (to_display(factor * to_linear(np.array(paint.rgb))) - levels)
        found.append(np.sqrt(((shown - levels) ** 2).mean(-1)))
    return min(WHITE, float(np.percentile(np.maximum(*found), BRIGHT)))


def shipped() -> Calibration:
    """The table that ships with this version."""
    return read(assets.path(SHIPPED))


def read(path: Path) -> Calibration:
    """Read a table.

    Raises
    ------
    InputError
        When it cannot be read, is not such a table, or was measured with another version of Pavemark.
    """
    table = from_json(Calibration, path)
    measured = table.versions.get("pavemark", "an unknown version")
    if measured != __version__:
        raise InputError(
            path,
            f"was measured with pavemark {measured}, this is {__version__}: pavemark accuracy --calibrate renews it",
        )
    return table
