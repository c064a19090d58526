"""The colours of real markings, measured once and shipped as assets/palette.json."""

from __future__ import annotations

from functools import lru_cache

import attrs

from pavemark import assets
from pavemark.records import from_json, within
from pavemark.scene import RGB


@attrs.frozen
class Shade:
    """One measured paint.

    Attributes
    ----------
    rgb : tuple of float
        Display sRGB, 0–255.
    ratio : tuple of float
        Reflectance ratio to the ground beside it, linear light.
    weight : float
        How often it is drawn among its family.
    """

    rgb: RGB = attrs.field(validator=within(0, 255))
    ratio: RGB = attrs.field(validator=within(0.01, 100.0))
    weight: float = attrs.field(validator=within(0.0, 1e6))


@attrs.frozen
class Palette:
    """All measured paints by family, and from what they were measured."""

    provenance: str
    white: tuple[Shade, ...]
    yellow: tuple[Shade, ...]


@lru_cache(maxsize=1)
def palette() -> Palette:
    """The shipped palette."""
    return from_json(Palette, assets.path("palette.json"))
