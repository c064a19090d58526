"""What is said of a scene is what is in it, and what is not in it is said to be lacking."""

import json

import attrs
import pytest

from pavemark.errors import InputError
from pavemark.job.explain import explain, explain_json
from pavemark.light import Caster, Glare, Shadows, Sun, Tube
from pavemark.records import to_json
from pavemark.scene import Brightness, Dirt, PlateRef, Scene
from scenes import WHITE, row


def _file(tmp_path, scene):
    path = tmp_path / "scene.json"
    path.write_text(to_json(scene))
    return path


def test_effects_passes_and_steps(tmp_path):
    paint = attrs.evolve(WHITE, dirt=Dirt(0.25, 0.5, 3.0))
    path = _file(tmp_path, attrs.evolve(row(n=3, paint=paint, index=17), brightness=Brightness(0.75)))
    told = json.loads(explain_json(path))
    assert told["index"] == 17 and len(told["slots"]) == 3
    assert told["markings"][0]["effects"] == {"dirt": {"size": 0.25, "strength": 0.5, "seed": 3.0}}
    assert told["effects"]["brightness"] == {"factor": 0.75}
    assert told["passes"] == [{"name": "decals", "samples": 1}]
    assert told["steps"] == ["blend", "brightness"]
    assert {"grain", "wear", "noise", "curvature", "optics"} <= set(told["without"])
    assert not {"dirt", "blend", "brightness"} & set(told["without"])
    text = explain(path)
    assert "dirt        size 0.25, strength 0.5, seed 3" in text
    assert "steps         blend → brightness" in text


def test_rays_are_told(tmp_path):
    path = _file(tmp_path, attrs.evolve(row(), rays=64))
    assert json.loads(explain_json(path))["passes"] == [{"name": "decals", "samples": 64}]
    assert "passes        decals, 64 rays a pixel" in explain(path)
    assert "passes        decals, 1 ray a pixel" in explain(_file(tmp_path, row()))


def test_an_empty_scene_calls_for_nothing(tmp_path):
    text = explain(_file(tmp_path, Scene(0, PlateRef("a", "0" * 64))))
    assert "none: Blender is not started" in text and "none: the plate as it is" in text


def test_light_is_told_with_its_things_counted(tmp_path):
    things = (Caster("pole", (-9.0, 0.0), (0.2, 0.2, 5.0)), Caster("tree", (8.0, 0.0), (3.0, 3.0, 5.0)))
    shadows = Shadows((0.4, 0.4, 0.45), sun=Sun(1.25, 0.5), casters=(*things, things[0]))
    glare = Glare((Tube((0.0, 0.0, 3.0), 1.2, 0.1, 0.0, (40.0,) * 3),) * 7, 0.3, 0.05, ((0.0, 2.0, 0.7),))
    text = explain(_file(tmp_path, attrs.evolve(row(n=1), shadows=shadows, glare=glare)))
    assert "sun (azimuth 1.25, elevation 0.5, angle 0.0093)" in text
    assert "casters 2 pole, 1 tree" in text and "tubes 7" in text
    assert "lamp" not in text
    assert "passes        decals, 1 ray a pixel; shadows, 8 rays a pixel" in text


def test_a_caster_in_the_picture_is_refused(tmp_path):
    inside = row(n=1)
    path = _file(tmp_path, inside)
    told = json.loads(path.read_text())
    caster = {"kind": "car", "foot": [2.6, 1.0], "size": [4.0, 1.8, 1.5]}
    told["shadows"] = {"left": [0.4, 0.4, 0.4], "sun": {"azimuth": 1.0, "elevation": 0.5}, "casters": [caster]}
    path.write_text(json.dumps(told))
    with pytest.raises(InputError, match=r"a car stands in the picture, at \(2\.6, 1\): outside it is allowed"):
        explain(path)
