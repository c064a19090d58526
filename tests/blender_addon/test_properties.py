"""The panel's properties mirror the records, and are off until switched on."""

import attrs
import pytest

from pavemark.light import Sun
from pavemark.records import Within, bounds, optional_records
from pavemark.scene import Paint, Scene

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon.effects import EFFECTS, OTHERS, TEXTURE, WITH_SLOTS  # noqa: E402 - needs bpy
from blender_addon.properties.fields import shown, value  # noqa: E402
from blender_addon.properties.hearing import deaf  # noqa: E402


def test_every_effect_of_the_contract_has_a_group_and_a_place(opened):
    wanted = {*optional_records(Paint), *optional_records(Scene)} - {"blend"}
    assert {*TEXTURE, *WITH_SLOTS, *OTHERS} == wanted == set(EFFECTS)
    assert {"wear", "curvature", "noise", "brightness", "optics", "tyres"} <= wanted
    assert not any(getattr(opened.pavemark, name).use for name in wanted)


def test_bounds_are_the_records(opened):
    checked = 0
    for name, record in EFFECTS.items():
        group = getattr(opened.pavemark, name)
        for field, attribute in shown(record).items():
            limits, prop = bounds(attribute, Within), group.bl_rna.properties[field]
            if limits is not None:
                assert (prop.hard_min, prop.hard_max) == pytest.approx((limits.low, limits.high), rel=1e-6)
                checked += 1
    assert checked > 15


def test_seeds_that_blender_cannot_hold_are_not_shown():
    assert "seed" not in shown(EFFECTS["noise"])
    assert "seed" in shown(EFFECTS["wear"])
    assert set(shown(EFFECTS["curvature"])) == {"alpha", "sigma"}


def test_lengths_and_angles_have_units(opened):
    settings = opened.pavemark
    assert settings.wear.bl_rna.properties["size"].unit == "LENGTH"
    assert settings.pattern.bl_rna.properties["angle"].unit == "ROTATION"
    assert settings.line.bl_rna.properties["width"].unit == "LENGTH"


def test_records_without_bounds_have_none():
    assert bounds(attrs.fields(Scene).markings, Within) is None


def properties(cls, path=""):
    """(path, property) of a group and all groups in it."""
    for name in cls.__annotations__:
        prop = cls.bl_rna.properties[name]
        if prop.type in {"POINTER", "COLLECTION"}:
            yield from properties(cls.__annotations__[name].keywords["type"], f"{path}{name}.")
        else:
            yield f"{path}{name}", prop


def test_every_property_has_a_tooltip_of_its_own(opened):
    found = list(properties(type(opened.pavemark)))
    assert len(found) > 90
    said = {}
    for path, prop in found:
        assert len(prop.description) >= 10, path
        said.setdefault(prop.description, []).append(path)
    assert [paths for paths in said.values() if len(paths) > 1] == []


@pytest.mark.parametrize(
    ("path", "unit", "subtype"),
    [
        ("relief.height", "LENGTH", "DISTANCE"),
        ("relief.bevel", "LENGTH", "DISTANCE"),
        ("wet.skyline", "ROTATION", "ANGLE"),
        ("sun.elevation", "ROTATION", "ANGLE"),
        ("sun.azimuth", "ROTATION", "ANGLE"),
        ("curvature.alpha", "NONE", "PIXEL"),
        ("lamp.place", "LENGTH", "TRANSLATION"),
        ("lamp.radius", "LENGTH", "DISTANCE"),
        ("tubes.length", "LENGTH", "DISTANCE"),
    ],
)
def test_units(opened, path, unit, subtype):
    prop = dict(properties(type(opened.pavemark)))[path]
    assert (prop.unit, prop.subtype) == (unit, subtype)


def test_what_blender_has_no_unit_for_is_named(opened):
    assert opened.pavemark.noise.bl_rna.properties["amount"].name == "Level / Share"
    # Wear's is a share, as its slider shows.
    assert opened.pavemark.wear.bl_rna.properties["amount"].name == "Amount"


@pytest.mark.parametrize("end", ["hard_min", "hard_max"])
def test_a_slider_at_its_end_is_within_the_records_bounds(opened, end):
    """Blender keeps 24 bits of a bound: the last of them may lie beyond."""
    told, checked = opened.pavemark, 0
    with deaf():
        for group, record in [(getattr(told, name), each) for name, each in EFFECTS.items()] + [(told.sun, Sun)]:
            for field, attribute in shown(record).items():
                limits, prop = bounds(attribute, Within), group.bl_rna.properties[field]
                if limits is not None and prop.type == "FLOAT":
                    at = getattr(prop, end)
                    setattr(group, field, (at,) * prop.array_length if prop.is_array else at)
                    limits(None, attribute, value(group, record, field))
                    checked += 1
    assert checked > 25
