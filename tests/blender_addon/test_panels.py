"""Every subpanel draws in every state, and names only properties and operators that exist."""

import types

import pytest

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import document, edits, panel, running  # noqa: E402 - needs bpy
from blender_addon.child import Child  # noqa: E402
from blender_addon.effects import EFFECTS  # noqa: E402


class Pressed:
    """What a button is given."""

    def __init__(self, operator):
        object.__setattr__(self, "known", {prop.identifier for prop in operator.get_rna_type().properties})

    def __setattr__(self, name, value):
        assert name in self.known


class Layout:
    """A layout that holds what is drawn against what exists."""

    def __init__(self, drawn=None):
        self.drawn = [] if drawn is None else drawn

    def row(self, **_):
        return Layout(self.drawn)

    column = row

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties
        self.drawn.append(name)

    def operator(self, name, **_):
        space, _, word = name.partition(".")
        self.drawn.append(name)
        return Pressed(getattr(getattr(bpy.ops, space), word))

    def label(self, text="", **_):
        self.drawn.append(text)

    def menu(self, name, **_):
        assert hasattr(bpy.types, name)

    def progress(self, factor, text):
        assert 0 <= factor <= 1
        self.drawn.append(text)

    def separator(self):
        pass


def draw_all(scene):
    """What all subpanels draw, in their order."""
    context = types.SimpleNamespace(
        scene=scene, region=types.SimpleNamespace(width=280), preferences=bpy.context.preferences, area=None
    )
    drawn = []
    for each in panel.CLASSES:
        shown = types.SimpleNamespace(layout=Layout(drawn))
        for name in dir(each):
            if not name.startswith("__") and not hasattr(shown, name):
                member = getattr(each, name)
                setattr(shown, name, types.MethodType(member, shown) if callable(member) else member)
        for part in ("draw_header", "draw_header_preset", "draw"):
            if part in {name for base in each.__mro__ for name in vars(base)} and hasattr(shown, part):
                getattr(each, part)(shown, context)
    return drawn


def test_the_order_of_the_work(registered):
    parents = {each.__name__: each for each in panel.CLASSES}
    top = [each for each in parents.values() if getattr(each, "bl_parent_id", "") == "PAVEMARK_PT_root"]
    assert [each.bl_label for each in sorted(top, key=lambda each: each.bl_order)] == [
        "Background",
        "Slots",
        "Effects",
        "Render",
        "Batch",
        "Import / Export",
    ]
    inside = [each for each in parents.values() if getattr(each, "bl_parent_id", "") == "PAVEMARK_PT_slots"]
    assert [each.bl_label for each in sorted(inside, key=lambda each: each.bl_order)] == [
        *("Count", "Shape", "Outline", "Line Width", "Colour", "Texture"),
        *("Wear", "Curvature", "Brightness", "Noise"),
    ]
    assert {each.bl_category for each in parents.values() if hasattr(each, "bl_category")} == {"Pavemark"}


def test_an_empty_file(opened):
    drawn = draw_all(opened)
    assert "pavemark.randomize" in drawn and "pavemark.batch" in drawn
    assert any("nothing to render" in text for text in drawn)


def test_a_scene_with_everything_switched_on(drawn):
    for name in EFFECTS:
        getattr(drawn.pavemark, name).use = True
        assert drawn.pavemark.trouble == "", name
    shown = draw_all(drawn)
    assert any(text.startswith("Passes: decals, 1 ray a pixel") for text in shown)
    assert "Drawn or measured: nothing to set" in shown
    assert "96 × 64 px  ·  8.00 m × 5.33 m" in shown


def test_a_count_for_which_there_is_no_room_is_told(drawn):
    count = drawn.pavemark.count
    count.slots, count.use = 1, True
    assert "where there is no room" not in " ".join(draw_all(drawn))
    count.slots = 7
    there = len(document.current(drawn).slots)
    assert there < 7 and f"{there} of 7 slots are there" in " ".join(draw_all(drawn))


def test_processes_and_what_came_of_them(chosen, monkeypatch):
    monkeypatch.setitem(running.children, running.BATCH, Child("Batch", 3, 10, "1.5", "0:00:05"))
    assert "3 of 10  ·  1.5/s  ·  0:00:05 left" in draw_all(chosen)
    monkeypatch.delitem(running.children, running.BATCH)
    monkeypatch.setitem(running.outcomes, running.BATCH, ("ERROR", "out: cannot be written: No space left on device"))
    assert "No space left on device" in " ".join(draw_all(chosen))


def test_trouble_is_told(opened):
    opened.pavemark.background.images = "/nowhere"
    assert "cannot be listed" in opened.pavemark.trouble
    assert any("/nowhere" in text for text in draw_all(opened))
    edits.redraw_editors()
