"""What outlives a step back, a file that is saved and loaded, and a preset."""

from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import document, handlers, lines  # noqa: E402 - needs bpy


def step(message):
    """What a person's act leaves: a step to go back to."""
    bpy.ops.ed.undo_push(message=message)


def target():
    return bpy.context.scene


def paths():
    """The points that the curves hold."""
    return [
        tuple(map(tuple, (point.co for point in spline.points)))
        for shown in target().objects
        if lines.NUMBER in shown
        for spline in shown.data.splines
    ]


def decals():
    return sorted(shown.name for shown in target().objects if shown.type == "MESH")


def test_undo_and_redo(drawn):
    first, curves = document.current(drawn), paths()
    step("before")
    bpy.ops.pavemark.randomize()
    target().pavemark.seed += 3
    second = document.current(target())
    assert second != first
    step("randomized")
    target().pavemark.wear.use = True
    third = document.current(target())
    step("worn")
    bpy.ops.ed.undo()
    assert document.current(target()) == second
    assert not target().pavemark.wear.use
    bpy.ops.ed.undo()
    assert document.current(target()) == first
    assert paths() == curves
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert document.current(target()) == third
    assert target().pavemark.wear.use
    assert len(decals()) == 1 + len(third.markings)


def test_a_drag_is_undone_with_its_labels(drawn):
    step("before")
    before = document.current(target())
    shown = next(each for each in target().objects if lines.NUMBER in each)
    shown.location.x += 0.5
    handlers.follow()
    step("dragged")
    after = document.current(target())
    assert after.slots != before.slots
    bpy.ops.ed.undo()
    assert document.current(target()) == before
    bpy.ops.ed.redo()
    assert document.current(target()) == after


def test_save_and_reload(drawn, tmp_path):
    drawn.pavemark.noise.use = drawn.pavemark.wear.use = True
    shown = next(each for each in drawn.objects if lines.NUMBER in each)
    shown.data.splines[0].points[0].co.x += 0.125
    scene, curves, there = document.current(drawn), paths(), decals()
    bpy.ops.pavemark.render()
    image = np.array(bpy.data.images["Pavemark image"].pixels[:])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert target().pavemark.document == ""
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert document.current(target()) == scene
    assert paths() == curves
    assert decals() == there
    assert target().pavemark.wear.use and target().pavemark.noise.use
    assert np.array_equal(np.array(bpy.data.images["Pavemark image"].pixels[:]), image)
    sheets = [image for image in bpy.data.images if image.name.startswith("Marking")]
    assert sheets and max(sheets[0].pixels[:]) == 1.0  # drawn anew: pixels that are made are in no file


def test_a_file_whose_image_is_gone_loads_and_says_so(drawn, inputs, tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.png").write_bytes((inputs / "images" / "a.png").read_bytes())
    drawn.pavemark.background.images = str(tmp_path / "images")
    scene = document.current(drawn)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    (tmp_path / "images" / "a.png").unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    assert document.current(target()) == scene
    assert "holds no image" in target().pavemark.trouble


def test_presets_come_back(drawn):
    settings = drawn.pavemark
    settings.wear.use = settings.noise.use = settings.outline.use = True
    settings.wear.amount = 0.375
    settings.noise.kind = "laplacian"
    settings.outline.kind = "open"
    bpy.ops.pavemark.add_preset(name="Worn and open")
    (path,) = Path(bpy.utils.user_resource("SCRIPTS", path="presets/pavemark")).glob("*.py")
    assert "wear.amount" in path.read_text()
    for name in ("wear", "noise", "outline"):
        getattr(settings, name).use = False
    settings.outline.use, settings.outline.kind = True, "closed"
    assert {slot.outline for slot in document.current(drawn).slots} == {"closed"}
    bpy.ops.pavemark.apply_preset(filepath=str(path), menu_idname="PAVEMARK_MT_presets")
    scene = document.current(drawn)
    assert {slot.outline for slot in scene.slots} == {"open"}
    assert {marking.paint.wear.amount for marking in scene.markings if marking.kind == "slot"} == {0.375}
    assert scene.noise.kind == "laplacian"
    path.write_text("nonsense(")
    with pytest.raises(RuntimeError, match="is not a preset of this panel"):
        bpy.ops.pavemark.apply_preset(filepath=str(path), menu_idname="PAVEMARK_MT_presets")
    assert document.current(drawn) == scene
    bpy.ops.pavemark.add_preset(name="Worn and open", remove_name=True)
    assert not path.exists()
