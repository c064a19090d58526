"""A group of properties made from a record: bounds, words and descriptions are the record's own."""

import functools
import inspect
import math
import re
import typing
from collections.abc import Callable

import attrs
import bpy

from pavemark.records import OneOf, Within, bounds

LENGTHS = {"size", "width", "edge", "sigma", "height", "bevel", "length", "radius", "place", "foot"}
"""Fields in metres."""

ANGLES = {"angle", "skyline", "azimuth", "elevation", "turn"}
"""Fields in radians."""

PIXELS = {"margin", "alpha"}
"""Fields in pixels."""

SPOKEN = {("Noise", "amount"): "Level / Share"}
"""Names of fields in what Blender has no unit for: short enough for the panel not to cut them off."""

VECTORS = {n: tuple[(float,) * n] for n in (2, 3)}
"""Colours and places, by how many numbers they are."""

LARGEST = 2**31 - 1
"""Whole numbers beyond it do not fit Blender's properties; a field that may hold one, such as a seed, is not shown."""


def shown(record: type) -> dict[str, attrs.Attribute]:
    """The fields of a record that sliders, menus and ticks can show: numbers, colours, places, words and whether."""
    kinds = typing.get_type_hints(record)
    found = {}
    for field in attrs.fields(record):
        limits = bounds(field, Within)
        fits = kinds[field.name] is not int or limits is None or limits.high <= LARGEST
        if kinds[field.name] in (int, float, str, bool, *VECTORS.values()) and fits:
            found[field.name] = field
    return found


def value(group: bpy.types.PropertyGroup, record: type, name: str) -> object:
    """What a group says of a field of a record."""
    told, limits = getattr(group, name), bounds(attrs.fields_dict(record)[name], Within)

    def allowed(number: float) -> float:
        # Blender's numbers have 24 bits: its bound may lie beyond the record's by the last of them.
        return min(max(number, limits.low), limits.high) if limits else number

    if isinstance(told, float):
        return allowed(told)
    return told if isinstance(told, (int, str)) else tuple(map(allowed, told))


def group(
    record: type, name: str, changed: Callable[[str], Callable], extra: dict | None = None, without: str = ""
) -> type[bpy.types.PropertyGroup]:
    """A PropertyGroup class with the fields that can be shown.

    Parameters
    ----------
    record : type
        A frozen attrs class.
    name : str
        Ends the class's name.
    changed : callable
        From the name of a field to the callback for its changes.
    extra : dict or None
        Properties beside the record's own.
    without : str
        A field that is not to be shown.
    """
    kinds = typing.get_type_hints(record)
    made = {
        field.name: _property(field, kinds[field.name], record, changed(field.name))
        for field in shown(record).values()
        if field.name != without
    }
    return type(
        f"PAVEMARK_PG_{name}",
        (bpy.types.PropertyGroup,),
        {"__annotations__": (extra or {}) | made, "__module__": __name__},
    )


def _property(field: attrs.Attribute, kind: type, record: type, update: Callable):
    said = {
        "name": SPOKEN.get((record.__name__, field.name), field.name.replace("_", " ").title()),
        "description": description(record, field.name),
        "update": update,
    }
    given = field.default if isinstance(field.default, (int, float, str, bool)) else None
    if kind is bool:
        return bpy.props.BoolProperty(default=bool(given), **said)
    if kind is str:
        words = bounds(field, OneOf).allowed
        items = [(word, word.replace("-", " ").capitalize(), "") for word in words]
        return bpy.props.EnumProperty(items=items, default=given or words[0], **said)
    limits = bounds(field, Within) or Within(0.0, 1.0)
    if kind is int:
        low, high = round(limits.low), round(limits.high)
        unit = {"subtype": "PIXEL"} if field.name in PIXELS else {}
        return bpy.props.IntProperty(default=low if given is None else given, min=low, max=high, **unit, **said)
    count = next((n for n, vector in VECTORS.items() if vector == kind), 1)
    unit = {}
    if field.name in LENGTHS:
        unit = {"subtype": "DISTANCE" if count == 1 else "TRANSLATION", "unit": "LENGTH"}
    elif field.name in PIXELS:
        unit = {"subtype": "PIXEL"}
    elif count > 1:
        unit = {}
    elif field.name in ANGLES:
        unit = {"subtype": "ANGLE", "unit": "ROTATION"}
    elif (limits.low, limits.high) == (0.0, 1.0):
        unit = {"subtype": "FACTOR"}
    # A step is a hundredth of its number; the eye wants one in a hundred of what may be set.
    soft = min(limits.high, max(1.0, limits.low))
    precision = 3 if limits.low >= 0.01 or limits.low == 0 else 4
    start = min(max(0.5, limits.low), limits.high) if given is None else given
    said |= {"min": limits.low, "max": limits.high, "precision": precision, **unit}
    said["step"] = max(0.01, 100 * 10 ** math.floor(math.log10(soft / 100)))
    if count > 1:
        return bpy.props.FloatVectorProperty(default=(start,) * count, size=count, **said)
    return bpy.props.FloatProperty(default=start, **said)


def description(record: type, field: str) -> str:
    """What a record's docstring says of a field, or of itself, in one line without a full stop."""
    return _descriptions(record).get(field) or _descriptions(record)[""]


@functools.cache
def _descriptions(record: type) -> dict[str, str]:
    # Since 3.13 Python itself takes the indentation away.
    summary, _, rest = inspect.cleandoc(record.__doc__ or record.__name__).partition("\n")
    found = {"": summary}
    # numpydoc: names and their type in a line, what they are indented below it.
    for names, text in re.findall(r"^(\w[\w, ]*) : .*\n((?:    .*\n?)+)", rest, re.MULTILINE):
        found |= dict.fromkeys(re.split(r", *", names), text)
    return {name: " ".join(text.replace("`", "").split()).removesuffix(".") for name, text in found.items()}
