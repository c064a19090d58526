"""Registered twice without residue; every class as Blender wants it."""

import re

import pytest

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

import blender_addon  # noqa: E402 - needs bpy
from blender_addon import handlers, registration  # noqa: E402


def residue():
    """What the extension has put into Blender."""
    classes = [name for name in dir(bpy.types) if name.startswith("PAVEMARK_")]
    heard = [
        (name, each)
        for name in handlers.LISTS
        for each in getattr(bpy.app.handlers, name)
        if each.__module__.startswith("blender_addon")
    ]
    known = sum(each.is_registered for each in registration.CLASSES)
    return known, classes, heard, hasattr(bpy.types.Scene, "pavemark"), dir(bpy.ops.pavemark)


def test_twice_without_residue(registered):
    before = residue()
    assert before[0] == len(registration.CLASSES)
    assert len(before[2]) == len(handlers.LISTS)
    for _ in range(2):
        blender_addon.unregister()
        assert residue() == (0, [], [], False, [])
        blender_addon.register()
        assert residue() == before


def test_names_and_words(registered):
    for each in registration.CLASSES:
        assert re.fullmatch(r"PAVEMARK_(PG|OT|PT|MT)_\w+", each.__name__)
        if issubclass(each, bpy.types.Operator):
            told = getattr(bpy.ops.pavemark, each.bl_idname.removeprefix("pavemark.")).get_rna_type()
            assert told.description and not told.description.endswith("."), each
            for prop in told.properties:
                from_blender = prop.identifier == "rna_type" or each.__module__.endswith("presets")
                assert prop.is_hidden or prop.description or from_blender, (each, prop.identifier)


def test_every_property_of_the_panel_says_what_it_is(registered):
    for each in registration.CLASSES:
        if issubclass(each, bpy.types.PropertyGroup):
            for prop in each.bl_rna.properties:
                if prop.type != "POINTER" and prop.identifier != "name":
                    assert prop.description, (each, prop.identifier)
                    assert not prop.description.endswith("."), (each, prop.identifier)
