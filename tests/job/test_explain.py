"""What is said of a scene is what is in it, and what is not in it is said to be lacking."""

import json

import attrs

from pavemark.job.explain import explain, explain_json
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
    assert "passes        decals, 64 samples a pixel" in explain(path)
    assert "passes        decals, 1 sample a pixel" in explain(_file(tmp_path, row()))


def test_an_empty_scene_calls_for_nothing(tmp_path):
    text = explain(_file(tmp_path, Scene(0, PlateRef("a", "0" * 64))))
    assert "none: Blender is not started" in text and "none: the plate as it is" in text
