"""Every operator's poll and execute, and what it leaves alone when it cannot."""

import hashlib
import json
import shutil
import time
import tomllib
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from pavemark.job.config import read
from pavemark.plan import plan
from pavemark.records import from_json, to_json
from pavemark.scene import Area, Marking, Scene, Stroke

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import backdrop, document, lines, operators, running, shot  # noqa: E402 - needs bpy
from blender_addon.effects import EFFECTS, LIGHT  # noqa: E402
from blender_addon.operators import batch  # noqa: E402
from pavemark.compose.image import compose  # noqa: E402


def finish():
    """Look after the processes until all have ended."""
    for _ in range(600):
        running.watch()
        if not running.children:
            return running.outcomes
        time.sleep(0.1)
    raise AssertionError("a process does not end")


def pixels():
    """The image that the Image Editor shows."""
    image = bpy.data.images[shot.IMAGE]
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    width, height = image.size
    return np.rint(values.reshape(height, width, 4)[::-1, :, :3] * 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("step_background", "Choose an AVM image"),
        ("remove_markings", "Choose an AVM image"),
        ("look_down", "It is for a 3D view"),
        ("open_editor", "It is for a 3D view"),
        ("stop", "Nothing runs"),
        ("randomize", "Choose an AVM image"),
        ("draw_again", "Choose an AVM image"),
        ("new_slot", "Choose an AVM image"),
        ("render", "Choose an AVM image"),
        ("save_image", "Choose an AVM image"),
        ("batch", "Choose an AVM image"),
        ("save_scene", "Draw slots first"),
        ("export_job", "Choose an AVM image"),
    ],
)
def test_who_cannot_says_why(opened, name, why):
    operator = getattr(bpy.ops.pavemark, name)
    assert not operator.poll()
    with pytest.raises(RuntimeError, match=why):
        operator()


@pytest.mark.parametrize("name", ["randomize", "draw_again", "new_slot", "render", "save_image"])
def test_on_an_image_with_its_markings_they_come_off_first(opened, inputs, name):
    opened.pavemark.background.images = str(inputs / "images")
    assert opened.pavemark.background.name
    with pytest.raises(RuntimeError, match="Remove the markings of the image first"):
        getattr(bpy.ops.pavemark, name)()


def test_every_operator_is_tried_here():
    tried = {"apply_preset", "add_preset", "open_scene"} | {
        "step_background", "remove_markings", "look_down", "open_editor", "stop", "randomize", "draw_again", "new_slot",
        "render", "save_image", "batch", "save_scene", "export_job",
    }  # fmt: skip
    classes = [each for each in operators.CLASSES if issubclass(each, bpy.types.Operator)]
    assert {each.bl_idname.removeprefix("pavemark.") for each in classes} == tried


def test_stepping_goes_round(chosen):
    names = []
    for step in (1, 1, 1, -1):
        bpy.ops.pavemark.step_background(step=step)
        names.append(chosen.pavemark.background.name)
    assert names == ["b", "c", "a", "c"]


def test_the_ground_lies_at_true_size(chosen):
    (ground,) = [shown for shown in chosen.objects if shown.name.startswith("Pavemark ground")]
    assert tuple(ground.dimensions[:2]) == pytest.approx((8.0, 64 / 12), rel=1e-6)


def test_markings_are_removed_beside_blender(chosen, tmp_path, monkeypatch):
    monkeypatch.setenv("PAVEMARK_CACHE", str(tmp_path / "cache"))
    document.look(chosen)
    assert not chosen.pavemark.background.clean
    bpy.ops.pavemark.remove_markings()
    assert not bpy.ops.pavemark.remove_markings.poll()
    assert finish()[running.PLATES] == ("INFO", "Markings removed")
    assert chosen.pavemark.background.clean
    assert bpy.ops.pavemark.randomize.poll()


def test_randomize_draws_what_a_job_draws(drawn, inputs):
    settings = drawn.pavemark
    settings.draw = "preset"
    settings.index = 4
    bpy.ops.pavemark.randomize()
    from pavemark.job.image import read_ground  # noqa: PLC0415
    from pavemark.randomize.scene import randomize  # noqa: PLC0415

    entry = backdrop.chosen(drawn)
    told = {"images": str(inputs / "images"), "masks": str(inputs / "masks"), "metres_per_pixel": 1 / 12}
    job = read(None, told | {"inpainter": "navier-stokes", "segmenter": "strokes", "seed": settings.seed})
    ground = read_ground(entry.image, entry.mask, job)
    assert document.known(drawn) == randomize(ground.plate, 4, settings.seed, job, ground.original, ground.blur)


def test_an_effect_that_is_off_is_in_no_scene_and_in_no_node_tree(drawn):
    settings = drawn.pavemark
    settings.wear.use = True
    assert all(marking.paint.wear for marking in document.known(drawn).markings)
    assert any("wear" in group.name for group in bpy.data.node_groups if group.users)
    settings.wear.use = False
    assert not any(marking.paint.wear for marking in document.known(drawn).markings)
    trees = [material.node_tree for material in bpy.data.materials if material.node_tree]
    assert not any(node.bl_idname == "ShaderNodeGroup" for tree in trees for node in tree.nodes)


def test_sliders_change_the_scene_and_the_view(drawn):
    settings = drawn.pavemark
    settings.wear.use = True
    settings.wear.amount = 0.625
    assert {marking.paint.wear.amount for marking in document.known(drawn).markings} == {0.625}
    settings.line.use = True
    settings.line.width = 0.25
    widths = {stroke.width for marking in document.known(drawn).markings for stroke in marking.strokes}
    assert widths == {0.25}
    settings.noise.use = True
    settings.noise.kind = "gaussian"
    settings.noise.amount = 20.0
    settings.noise.kind = "salt-and-pepper"
    assert document.known(drawn).noise.amount <= 1
    settings.blend.method = "alpha"
    assert document.known(drawn).blend.method == "alpha"
    settings.colour.opacity = 0.5
    assert {marking.paint.opacity for marking in document.known(drawn).markings} == {0.5}
    assert settings.trouble == ""


def test_what_is_held_is_drawn(drawn):
    settings = drawn.pavemark
    before = document.known(drawn).markings[-1].paint
    settings.outline.use = True
    settings.outline.kind = "corner"
    assert {slot.outline for slot in document.known(drawn).slots} == {"corner"}
    assert document.known(drawn).markings[-1].paint == before
    settings.shape.use = True
    settings.shape.kind = "slanted"
    assert {slot.kind for slot in document.known(drawn).slots} == {"slanted"}
    settings.count.use = True
    settings.count.slots = 1
    assert len(document.known(drawn).slots) == 1


def test_three_clicks_make_a_slot(clean):
    bpy.ops.pavemark.new_slot(first=(1.0, 1.5), second=(1.0, -1.0), depth=(3.9, 0.2))
    bpy.ops.pavemark.new_slot(first=(1.05, -0.95), second=(1.0, -2.5), depth=(3.9, -1.6))
    first, second = document.current(clean).slots
    assert first.corners[0] == pytest.approx((1.0, 1.5))
    assert second.corners[0] == first.corners[1]
    assert (first.marks, second.marks) == (("L", "T"), ("T", "L"))
    assert np.degrees(np.arctan2(*np.subtract(first.corners[3], first.corners[0])[::-1])) == pytest.approx(0, abs=1e-6)
    with pytest.raises(RuntimeError, match=r"at least 0\.5 m"):
        bpy.ops.pavemark.new_slot(first=(1.0, 1.5), second=(1.0, 1.4), depth=(3.0, 0.0))
    assert len(document.current(clean).slots) == 2


def test_dragged_curves_move_labels(drawn):
    before = document.known(drawn)
    shown = next(each for each in drawn.objects if lines.NUMBER in each)
    shown.location.x += 0.25
    moved = document.current(drawn)
    for old, new in zip(before.slots, moved.slots, strict=True):
        assert np.allclose(np.add(old.corners, (0.25, 0.0)), new.corners, atol=1e-5)
    assert document.known(drawn) == moved
    spline = shown.data.splines[0]
    spline.points[0].co.y += 0.125
    assert document.current(drawn) != moved
    copy = shown.copy()
    copy.data = shown.data.copy()
    copy.location.x -= 1.0
    drawn.collection.objects.link(copy)
    assert len(document.current(drawn).slots) == 2 * len(before.slots)
    bpy.data.objects.remove(shown)
    assert len(document.current(drawn).slots) == len(before.slots)


def test_lines_that_hands_add_are_painted(drawn):
    before = document.known(drawn)
    shown = next(each for each in drawn.objects if lines.NUMBER in each)
    bezier = shown.data.splines.new("BEZIER")
    bezier.bezier_points.add(1)
    for point, x in zip(bezier.bezier_points, (0.0, 1.0), strict=True):
        point.co = (x, 0.5, 0.0)
        point.handle_left, point.handle_right = (x - 0.3, 0.5, 0.0), (x + 0.3, 0.5, 0.0)
    marking = document.current(drawn).markings[0]
    assert len(marking.strokes) == len(before.markings[0].strokes) + 1
    added = marking.strokes[-1]
    assert np.allclose(added.path, [(x, 0.5) for x, _ in added.path]) and len(added.path) == 13
    assert (added.path[0][0], added.path[-1][0]) == pytest.approx((0.0, 1.0), abs=1e-6)
    assert added.width == pytest.approx(before.markings[0].strokes[0].width)
    assert document.current(drawn).slots == before.slots


def test_the_render_is_what_a_job_makes_to_the_bit(drawn, renderer):
    for name in EFFECTS:
        getattr(drawn.pavemark, name).use = True
    bpy.ops.pavemark.render()
    scene, plate = document.current(drawn), backdrop.plate(drawn)
    here = pixels()
    assert drawn.pavemark.seconds > 0
    kinds = ("objects", "meshes", "materials", "images", "scenes")
    before = {kind: len(getattr(bpy.data, kind)) for kind in kinds}
    bpy.ops.pavemark.render()
    assert {kind: len(getattr(bpy.data, kind)) for kind in kinds} == before
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    renderer.target = bpy.context.scene
    headless = compose(scene, plan(scene), plate, renderer.render(scene, plate, plan(scene)))
    assert np.array_equal(here, headless)
    assert np.abs(headless.astype(int) - plate.image).max() > 20


def test_saved_images_join_a_dataset(drawn, tmp_path):
    settings = drawn.pavemark
    settings.folder = str(tmp_path / "set")
    settings.index = 3
    bpy.ops.pavemark.save_image()
    out = tmp_path / "set"
    assert np.array_equal(cv2.imread(str(out / "images/000003.png"))[..., ::-1], pixels())
    assert from_json(Scene, out / "scenes/000003.json") == document.current(drawn)
    for path in ("labels/dmpr/000003.json", "labels/ps2/000003.mat", "labels/yolo/000003.txt", "masks/000003.png"):
        assert (out / path).exists()
    (line,) = (out / "manifest.jsonl").read_text().splitlines()
    told = json.loads(line)
    assert told["by_hand"] and told["input"] == "a.png"
    assert told["files"]["images/000003.png"] == hashlib.sha256((out / "images/000003.png").read_bytes()).hexdigest()
    before = (out / "images/000003.png").read_bytes()
    settings.brightness.use = True
    settings.brightness.factor = 0.5
    bpy.ops.pavemark.save_image()
    assert (out / "images/000003.png").read_bytes() != before
    assert len((out / "manifest.jsonl").read_text().splitlines()) == 1
    assert len(json.loads((out / "labels/coco.json").read_text())["images"]) == 1


def test_scenes_are_saved_and_opened(drawn, tmp_path):
    path = tmp_path / "scene.json"
    drawn.pavemark.wear.use = True
    bpy.ops.pavemark.save_scene(filepath=str(path))
    scene = document.known(drawn)
    assert path.read_text() == to_json(scene)
    bpy.ops.pavemark.randomize()
    assert document.known(drawn) != scene
    bpy.ops.pavemark.open_scene(filepath=str(path))
    assert document.current(drawn) == scene
    assert drawn.pavemark.wear.use and not drawn.pavemark.noise.use


def test_what_is_painted_beside_slots_is_opened_with_them(drawn, tmp_path):
    """The panel draws no aisle; a job does, and its scenes are for the panel too."""
    scene = document.known(drawn)
    (slot, *_) = [marking for marking in scene.markings if marking.kind == "slot"]
    line = Marking("aisle", slot.paint, (Stroke(((-2.0, -1.0), (-2.0, 1.0)), 0.1),))
    floor = Marking("floor", slot.paint, areas=(Area(((-1.0, -1.0), (0.0, -1.0), (0.0, 0.0))),))
    path = tmp_path / "scene.json"
    path.write_text(to_json(attrs.evolve(scene, markings=(floor, line, *scene.markings))))
    bpy.ops.pavemark.open_scene(filepath=str(path))
    found = document.current(drawn)
    assert [marking.kind for marking in found.markings][:3] == ["floor", "aisle", "slot"]
    assert found.slots == scene.slots and found.markings[0].areas == floor.areas
    bpy.ops.pavemark.render()


@pytest.mark.parametrize("text", ["{", "[]", '{"index": 0}', '{"index": 0, "plate": {"name": "a", "sha256": "x"}}'])
def test_a_broken_scene_is_refused_and_nothing_is_lost(drawn, tmp_path, text):
    before = drawn.pavemark.document
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(RuntimeError, match=r"broken\.json: "):
        bpy.ops.pavemark.open_scene(filepath=str(path))
    assert drawn.pavemark.document == before
    assert drawn.pavemark.background.name == "a"


def test_a_scene_of_another_image_is_refused_and_nothing_is_lost(drawn, tmp_path):
    before = document.known(drawn)
    path = tmp_path / "other.json"
    path.write_text(to_json(attrs.evolve(before, plate=attrs.evolve(before.plate, name="elsewhere"))))
    with pytest.raises(RuntimeError, match="holds no image elsewhere"):
        bpy.ops.pavemark.open_scene(filepath=str(path))
    assert document.known(drawn) == before
    assert drawn.pavemark.background.name == "a"
    bpy.ops.pavemark.render()


def test_an_image_deleted_in_use_is_told_and_nothing_is_lost(drawn, inputs, tmp_path):
    shutil.copytree(inputs / "images", tmp_path / "images")
    drawn.pavemark.background.images = str(tmp_path / "images")
    before = document.known(drawn)
    (tmp_path / "images" / "a.png").unlink()
    with pytest.raises(RuntimeError, match="a is not there any more: choose another image"):
        bpy.ops.pavemark.render()
    drawn.pavemark.wear.use = True
    assert "a is not there any more" in drawn.pavemark.trouble
    assert document.known(drawn) == before
    shutil.copy(inputs / "images" / "a.png", tmp_path / "images")
    bpy.ops.pavemark.render()
    assert document.known(drawn) == before


def test_a_job_is_exported_as_the_panel_says(drawn, inputs, tmp_path):
    settings = drawn.pavemark
    settings.wear.use = True
    settings.outline.use, settings.outline.kind = True, "open"
    settings.batch_count, settings.seed = 7, 11
    path = tmp_path / "job.toml"
    bpy.ops.pavemark.export_job(filepath=str(path))
    job = read(path, {})
    assert (job.count, job.seed, job.pixels_per_metre) == (7, 11, 12.0)
    assert (job.texture.wear.rate, job.noise.rate, job.optics.rate) == (1.0, 0.0, 0.0)
    assert (job.shape.open, job.shape.closed, job.shape.corner) == (1.0, 0.0, 0.0)
    assert Path(job.images).resolve() == inputs / "images"
    assert 'images = "../' in path.read_text()


@pytest.mark.parametrize("name", ["export_job", "save_scene"])
def test_nothing_is_written_into_a_folder_that_was_mistyped(drawn, name, tmp_path):
    (tmp_path / "jobs").mkdir()
    (tmp_path / "file").touch()
    for folder in ("jbos", "jobs/deep/er", "file"):
        with pytest.raises(RuntimeError) as refused:
            getattr(bpy.ops.pavemark, name)(filepath=str(tmp_path / folder / "it.json"))
        (line,) = str(refused.value).strip().splitlines()
        assert line == f"Error: {tmp_path / folder}: is no folder that is there: make it first, or choose another one"
    assert {path.name for path in tmp_path.rglob("*")} == {"jobs", "file"}
    getattr(bpy.ops.pavemark, name)(filepath=str(tmp_path / "jobs" / "it.json"))
    assert (tmp_path / "jobs" / "it.json").is_file()


def test_a_job_says_what_its_light_is_drawn_from(drawn, tmp_path):
    path, settings = tmp_path / "job.toml", drawn.pavemark

    def told():
        bpy.ops.pavemark.export_job(filepath=str(path))
        read(path, {})
        return {name: table for name, table in tomllib.loads(path.read_text()).items() if name in ("sun", *LIGHT)}

    assert not {name for name, table in told().items() if table.keys() - {"rate"}}
    settings.wet.use = True
    assert told().keys() == {"wet"}
    assert told()["wet"].keys() == {"rate", "share", "pools", "size", "darkening", "sky", "around", "skyline"}
    assert (told()["wet"]["rate"], told()["wet"]["share"], told()["wet"]["skyline"]) == (1.0, [0.1, 0.9], [5.0, 30.0])
    settings.wet.use = False
    settings.shadows.use = settings.glare.use = True
    assert told().keys() == {"sun", "shadows", "glare"}
    assert told()["sun"] == {"azimuth": [-180.0, 180.0], "elevation": [12.0, 60.0], "angle": [0.53, 2.0]}
    assert told()["shadows"]["kinds"] == ["tree", "pole", "car", "roof"]
    assert {"ceiling", "length", "gap", "rows", "radiance"} <= told()["glare"].keys()
    settings.draw = "preset"
    assert told() == {}, "the preset simulates no light"


def test_a_largest_error_is_the_jobs_and_the_panels(drawn):
    settings = drawn.pavemark
    settings.grain.use = True
    settings.grain.contrast = 0.5
    bpy.ops.pavemark.render()
    assert document.known(drawn).rays == 1
    off = settings.off
    assert off > 4.0
    assert "max_error" not in batch.job_tables(drawn)
    settings.max_error = 4.0
    assert batch.job_tables(drawn)["max_error"] == 4.0
    bpy.ops.pavemark.render()
    assert document.known(drawn).rays > 1
    assert 0 < settings.off <= 4.0
    settings.max_error = 0.0
    bpy.ops.pavemark.render()
    assert (document.known(drawn).rays, settings.off) == (1, off)
    settings.max_error = 0.01
    with pytest.raises(RuntimeError, match=r"max_error: 0\.01 8-bit levels: allowed from"):
        bpy.ops.pavemark.render()


@pytest.mark.parametrize("scale", [60.0, 22.7, 48.5, 1 / 0.044])
def test_the_scale_of_a_job_survives_blenders_float32(scale, opened, inputs):
    told = opened.pavemark.background
    told.images = str(inputs / "images")
    told.metres_per_pixel = 1 / scale
    assert backdrop.job(opened).pixels_per_metre == scale
