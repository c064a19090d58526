"""The panel's properties mirror the records, and are off until switched on."""

import attrs
import pytest

from pavemark.records import Within, bounds, optional_records
from pavemark.scene import Paint, Scene

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon.effects import EFFECTS, OTHERS, TEXTURE, WITH_SLOTS  # noqa: E402 - needs bpy
from blender_addon.properties.fields import shown  # noqa: E402


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
