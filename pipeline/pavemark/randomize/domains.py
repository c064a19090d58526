"""The domains of a job: one table each in the job file, and the presets that ship."""

from __future__ import annotations

import tomllib
from typing import Any

import attrs

from pavemark import assets
from pavemark.randomize import (
    aisle,
    brightness,
    colour,
    curvature,
    glare,
    layout,
    noise,
    optics,
    relief,
    shadows,
    shape,
    stops,
    sun,
    texture,
    wet,
)
from pavemark.scene import Blend


@attrs.frozen
class Domains:
    """What may be drawn for an image, by domain; `blend` is how its markings enter the plate."""

    layout: layout.Ranges = attrs.field(factory=layout.Ranges)
    shape: shape.Ranges = attrs.field(factory=shape.Ranges)
    colour: colour.Ranges = attrs.field(factory=colour.Ranges)
    texture: texture.Ranges = attrs.field(factory=texture.Ranges)
    noise: noise.Ranges = attrs.field(factory=noise.Ranges)
    aisle: aisle.Ranges = attrs.field(factory=aisle.Ranges)
    stops: stops.Ranges = attrs.field(factory=stops.Ranges)
    curvature: curvature.Ranges = attrs.field(factory=curvature.Ranges)
    brightness: brightness.Ranges = attrs.field(factory=brightness.Ranges)
    blend: Blend = attrs.field(factory=Blend)
    optics: optics.Ranges = attrs.field(factory=optics.Ranges)
    sun: sun.Ranges = attrs.field(factory=sun.Ranges)
    relief: relief.Ranges = attrs.field(factory=relief.Ranges)
    shadows: shadows.Ranges = attrs.field(factory=shadows.Ranges)
    wet: wet.Ranges = attrs.field(factory=wet.Ranges)
    glare: glare.Ranges = attrs.field(factory=glare.Ranges)


def preset(name: str) -> dict[str, Any]:
    """The tables of a shipped preset, "default" or "paper", as a job file would hold them.

    Raises
    ------
    InputError
        When there is no such preset.
    """
    return tomllib.loads(assets.path(f"presets/{name}.toml").read_text(encoding="utf-8"))
