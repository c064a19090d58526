"""A scene drawn by chance, as a job draws it, with the panel's settings in place of the preset's."""

from __future__ import annotations

from typing import Any

import attrs
import bpy

from pavemark.background.contours import areas
from pavemark.job.config import merge
from pavemark.job.inputs import blur
from pavemark.plate import Plate
from pavemark.randomize.domains import Domains, preset
from pavemark.randomize.scene import randomize
from pavemark.records import structure
from pavemark.scene import Blend, Scene

from .effects import EFFECTS, LIGHT
from .properties import fields


def tables(target: bpy.types.Scene) -> dict[str, Any]:
    """The domains' tables, as a job file would hold them."""
    settings = target.pavemark
    told = preset(settings.preset)
    if settings.draw == "switched":
        told = merge(told, rates({name: getattr(settings, name).use for name in EFFECTS}))
        # What age does besides the effects has no switch: paint is as it is set.
        told = merge(told, {"texture": {"fade": {"rate": 0.0}, "former": {"rate": 0.0}}})
        # Nor has what is painted beside the slots.
        told = merge(told, {"aisle": {"rate": 0.0}})
        told = merge(told, {"layout": {"empty_rate": 0.0}, "blend": values(settings.blend, Blend)})
    return merge(told, _held(settings))


def values(group: bpy.types.PropertyGroup, record: type) -> dict[str, Any]:
    """What a group shows of a record."""
    return {name: fields.value(group, record, name) for name in fields.shown(record)}


def drawn(target: bpy.types.Scene, plate: Plate, besides: dict[str, Any] | None = None) -> Scene:
    """Draw a scene on a plate.

    Parameters
    ----------
    besides : dict or None
        Tables of domains that count more than the panel's.

    Raises
    ------
    InputError
        When a setting is not allowed.
    """
    settings = target.pavemark
    domains = structure(Domains, merge(tables(target), besides or {}), "panel")
    original = areas(plate.markings, plate.frame.matrix) if domains.layout.original_rate else ()
    measured = blur(plate) if domains.optics.rate else None
    return randomize(plate, settings.index, settings.seed, domains, original, measured)


def rates(on: dict[str, bool], **more: Any) -> dict[str, Any]:
    """Tables that have effects drawn always or never: each has one of its name, a domain's or a texture's."""
    domains, texture = (attrs.fields_dict(cls) for cls in (Domains, type(Domains().texture)))
    told: dict[str, Any] = {"texture": {}}
    for name, switched in on.items():
        table = {"rate": float(switched)} | more
        if name in domains:
            told[name] = table
        elif name in texture:
            told["texture"][name] = table
    return told


def _held(settings: bpy.types.PropertyGroup) -> dict[str, Any]:
    """What is held fast of the layout, the shape and the colour."""
    told: dict[str, Any] = {"layout": {}, "shape": {}, "colour": {}}
    if settings.count.use:
        slots = settings.count.slots
        told["layout"] = {"slots": [slots, slots], "run_on": 0.0, "both_sides": float(settings.count.both_sides)}
    if settings.shape.use:
        told["shape"] |= {kind: float(kind == settings.shape.kind) for kind in _words(settings.shape)}
        degrees = round(settings.shape.slant * 57.29577951308232, 3)
        told["shape"] |= {"free_slant": 1.0, "slant": [degrees, degrees]}
    if settings.outline.use:
        told["shape"] |= {
            kind.replace("-", "_"): float(kind == settings.outline.kind) for kind in _words(settings.outline)
        }
    if settings.line.use:
        width = round(settings.line.width, 6)
        told["shape"]["line"] = [width, width]
    if settings.colour.use:
        told["colour"] = {family: float(family == settings.colour.family) for family in ("white", "yellow")}
    return told


def _words(group: bpy.types.PropertyGroup) -> list[str]:
    return [item.identifier for item in group.bl_rna.properties["kind"].enum_items]


def job_tables(target: bpy.types.Scene) -> dict[str, Any]:
    """The domains of a job that draws as the panel does, beside its preset: only what differs from it."""
    told, default = tables(target), preset(target.pavemark.preset)
    kept = {name: _differing(told[name], default.get(name, {})) for name in told}
    structure(Domains, merge(default, kept), "panel")
    return {name: table for name, table in kept.items() if table}


def light_tables(target: bpy.types.Scene) -> dict[str, Any]:
    """All ranges of the effects of light that such a job draws, and of the sun where one of them asks for it."""
    domains = structure(Domains, tables(target), "panel")
    names = [name for name in LIGHT if getattr(domains, name).rate]
    if any("sun" in attrs.fields_dict(EFFECTS[name]) for name in names):
        names.insert(0, "sun")
    return {name: attrs.asdict(getattr(domains, name)) for name in names}


def _differing(told: dict[str, Any], default: dict[str, Any]) -> dict[str, Any]:
    found = {}
    for name, value in told.items():
        if isinstance(value, dict):
            inner = _differing(value, default.get(name, {}))
            found |= {name: inner} if inner else {}
        elif default.get(name) != value:
            found[name] = value
    return found
