"""The stage: order of decals, colours, curves to edit, the ground plane, and nothing left behind."""

import subprocess
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

from pavemark.ground import Frame
from pavemark.layers import read
from pavemark.plan import plan
from pavemark.scene import Area, Blend, Curvature, Dirt, Marking, Paint, Stroke
from scenes import plate, rendered, row

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import curves  # noqa: E402 - needs bpy
from blender_addon.settings import Cycles, Output, Window  # noqa: E402
from blender_addon.stage import Stage  # noqa: E402

ROOT = Path(__file__).parents[2]


def bands(*tones: float, method: str = "normal"):
    """Coats of grey, coincident, one above the other."""
    stroke = Stroke(((-3.0, 0.2), (3.0, 0.7)), 0.5)
    coats = tuple(Marking("slot", Paint((t, t, t), (t / 100, t / 100, t / 100)), (stroke,)) for t in tones)
    return attrs.evolve(row(plate(), n=0), markings=coats, blend=Blend(method=method))


def test_colours_are_ratios_or_absolute_as_the_blend_asks(renderer):
    ratio, absolute = (rendered(renderer, bands(240, method=method)) for method in ("reflectance", "alpha"))
    assert ratio[280, 300, :3] == pytest.approx([2.4] * 3, abs=2e-3)
    assert absolute[280, 300, :3] == pytest.approx([((240 / 255 + 0.055) / 1.055) ** 2.4] * 3, abs=1e-3)


def test_areas_with_holes(renderer):
    square = Area(((-2, -2), (2, -2), (2, 2), (-2, 2)), holes=(((-1, -1), (1, -1), (1, 1), (-1, 1)),))
    scene = attrs.evolve(bands(200), markings=(Marking("original", bands(200).markings[0].paint, areas=(square,)),))
    alpha = rendered(renderer, scene)[..., 3]
    assert alpha.sum() / 3600 == pytest.approx(12, rel=1e-3)
    assert alpha[300, 300] == 0
    assert alpha[300, 300 - 90] == 1


def test_curves_hold_the_marking():
    marking = Marking(
        "slot",
        bands(1).markings[0].paint,
        (Stroke(((0, 0), (1.5, 0.25)), 0.125), Stroke(((0, 0), (1, 0), (1, 1)), 0.1, closed=True)),
        (Area(((0, 0), (3, 0), (3, 3)), (((1, 0.5), (2, 0.5), (2, 1)),)), Area(((5, 5), (6, 5), (6, 6)))),
    )
    lines, filled = curves.strokes("lines", marking, 0.1), curves.areas("filled", marking, 0.1)
    read = curves.read_strokes(lines)
    assert [stroke.closed for stroke in read] == [False, True]
    assert [stroke.width for stroke in read] == pytest.approx([0.125, 0.1], abs=1e-7)
    assert [np.allclose(a.path, b.path, atol=1e-6) for a, b in zip(read, marking.strokes, strict=True)] == [True, True]
    assert curves.read_areas(filled) == marking.areas
    bpy.data.batch_remove([lines, filled])


def test_nothing_is_left_behind(renderer):
    scene = row(plate(), n=3)
    kinds = ("objects", "meshes", "curves", "materials", "images", "cameras", "collections")
    rendered(renderer, scene)
    before = {kind: len(getattr(bpy.data, kind)) for kind in kinds}
    rendered(renderer, scene)
    assert {kind: len(getattr(bpy.data, kind)) for kind in kinds} == before


def test_only_listed_effects_build_nodes(renderer):
    scene = row(plate(), n=1)
    stage = Stage(bpy.context.scene)
    stage.markings(scene, plan(scene), hard=False)
    trees = [material.node_tree for material in bpy.data.materials if material.name.startswith("Marking")]
    kinds = {node.bl_idname for tree in trees for node in tree.nodes}
    stage.clear()
    assert not kinds & {"ShaderNodeGroup", "ShaderNodeTexNoise", "ShaderNodeTexVoronoi"}


@pytest.mark.parametrize("frame", [Frame(), Frame(96, 300, 1 / 0.044)])
def test_the_ground_plane_shows_the_plate_and_both_routes_agree(renderer, frame, tmp_path):
    """The whole ground rendered equals decals over the plate, in linear light, to one grey level."""
    background = plate(frame, tone=110, texture=25)
    scene = attrs.evolve(row(background, n=2), blend=Blend(method="alpha"))
    apart = renderer.render(scene, background, plan(scene)).decals
    target = bpy.context.scene
    stage = Stage(target)
    stage.camera(frame)
    stage.ground(background)
    stage.markings(scene, plan(scene), hard=False)
    Cycles(transparent=4).apply(target)
    Output(frame, Window(0, 0, frame.width, frame.height), str(tmp_path / "whole.exr")).apply(target)
    bpy.ops.render.render(write_still=True)
    stage.clear()
    whole = read(tmp_path / "whole.exr", "RGB")
    share = background.image / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    over = apart[..., :3] + (1 - apart[..., 3:]) * linear

    def levels(light):
        return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)

    assert np.abs(levels(whole) - levels(over)).max() <= 1.0


def test_layers_of_a_killed_process_are_swept():
    """Layers pass through memory; a process killed while it renders leaves some there, the next removes them."""
    start = "from blender_addon.renderer import BlenderRenderer, MEMORY; from pavemark import files; "
    left = 'print(files.aside(MEMORY / "pavemark-layers.exr"))'
    where = subprocess.run([sys.executable, "-c", start + left], capture_output=True, text=True, check=True, cwd=ROOT)
    path = Path(where.stdout.splitlines()[-1])
    path.write_bytes(b"half")
    subprocess.run([sys.executable, "-c", start + "BlenderRenderer()"], capture_output=True, check=True, cwd=ROOT)
    assert not path.exists()


def test_beside_every_decal_lie_its_curves_unbent_and_out_of_the_render():
    scene = row(plate(), n=2, curvature=Curvature(150, 0.4, 1))
    stage = Stage(bpy.context.scene)
    stage.markings(scene, plan(scene), hard=False)
    drawn = {shown.type: shown for shown in stage.collection.objects}
    read = curves.read_strokes(drawn["CURVE"].data)
    hidden, rendered = drawn["CURVE"].hide_render, not drawn["MESH"].hide_render
    stage.clear()
    assert hidden and rendered
    assert len(read) == len(scene.markings[0].strokes)
    assert all(np.allclose(a.path, b.path, atol=1e-6) for a, b in zip(read, scene.markings[0].strokes, strict=True))


def test_groups_of_another_version_are_not_used(renderer):
    scene = row(plate(), n=1)
    scene = attrs.evolve(
        scene,
        markings=tuple(attrs.evolve(m, paint=attrs.evolve(m.paint, dirt=Dirt(0.5, 0.9, 3.0))) for m in scene.markings),
    )
    drawn = rendered(renderer, scene)
    group = bpy.data.node_groups["Pavemark dirt"]
    group.nodes.clear()
    assert not np.array_equal(rendered(renderer, scene), drawn)
    group["pavemark_version"] = "0.0.1"
    assert np.array_equal(rendered(renderer, scene), drawn)
    bpy.data.node_groups.remove(group)
