"""Which effects there are: every field of the contract that may be None. A new one appears by itself."""

from __future__ import annotations

from pavemark import light
from pavemark.records import optional_records
from pavemark.scene import Paint, Scene

PAINT = optional_records(Paint)
"""Effects of a paint, by name, with their records."""

WHOLE = {name: record for name, record in optional_records(Scene).items() if name != "blend"}
"""Effects of the whole image."""

EFFECTS = PAINT | WHOLE

WITH_SLOTS = ("wear", "curvature", "brightness", "noise")
"""Those that have a place of their own among the settings of slots."""

TEXTURE = tuple(name for name in PAINT if name not in WITH_SLOTS)

OTHERS = tuple(name for name in WHOLE if name not in WITH_SLOTS)
"""Those that stand under Effects."""

LIGHT = tuple(name for name, record in EFFECTS.items() if record.__module__ == light.__name__)
"""Those that need light."""

LABELLED = ("slot", "original", "aisle", "symbol")
"""Kinds of markings whose paint the panel sets; a former coat keeps its own."""


def suns(scene: Scene) -> dict[str, light.Sun]:
    """The sun of each effect of the whole image that has one: it is one and the same."""
    found = {name: getattr(getattr(scene, name), "sun", None) for name in WHOLE}
    return {name: sun for name, sun in found.items() if sun is not None}
