"""The whole job with Blender, on the demo images: the same bytes however it is run, and again from a scene's JSON."""

import subprocess
import sys
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from commandline import contents

pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from pavemark.background.plates import make_plate
from pavemark.background.reading import MaskTable
from pavemark.compose.image import compose
from pavemark.plan import plan
from pavemark.records import from_json
from pavemark.scene import Scene

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "assets" / "demo"
COUNT = 5


def run(out, *options):
    job = [str(DEMO / "job.toml"), "--out", str(out), "--count", str(COUNT), "--set", 'inpainter = "navier-stokes"']
    command = [sys.executable, str(ROOT / "render.py"), *job, *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    out = tmp_path_factory.mktemp("job") / "out"
    run(out, "--workers", "1")
    return out


def test_two_workers_and_two_shards_make_the_same_bytes(dataset, tmp_path):
    run(tmp_path / "two", "--workers", "2")
    assert contents(tmp_path / "two") == contents(dataset)
    for shard in ("1/2", "0/2"):
        run(tmp_path / "shards", "--shard", shard)
    assert contents(tmp_path / "shards") == contents(dataset)


def again(path, renderer):
    """The scene of a JSON file, its plate and its layers."""
    scene = from_json(Scene, path)
    name = scene.plate.name
    plate = make_plate(
        DEMO / f"images/{name}.jpg", DEMO / f"masks/{name}.png", 60.0, MaskTable(ground=(0,)), "navier-stokes"
    )
    assert plate.sha256 == scene.plate.sha256
    return scene, plate, renderer.render(scene, plate, plan(scene)) if plan(scene).passes else None


def test_a_scene_and_its_plate_redo_the_image_to_the_bit(dataset, renderer):
    for path in sorted(dataset.glob("scenes/*.json")):
        scene, plate, layers = again(path, renderer)
        written = cv2.imread(str(dataset / f"images/{path.stem}.png"))[..., ::-1]
        assert np.array_equal(compose(scene, plan(scene), plate, layers), written)


def test_paint_lies_where_the_line_mask_says(dataset, renderer):
    """Pixels of the line mask are brighter than the plate; far from it the image is the plate, byte for byte."""
    painted = 0
    for path in sorted(dataset.glob("scenes/*.json")):
        scene, plate, layers = again(path, renderer)
        mask = cv2.imread(str(dataset / f"masks/{path.stem}.png"), cv2.IMREAD_UNCHANGED) > 0
        if not mask.any():
            continue
        painted += 1
        still = attrs.evolve(scene, brightness=None, noise=None)
        rise = compose(still, plan(still), plate, layers).astype(int).sum(2) - plate.image.astype(int).sum(2)
        assert np.median(rise[mask]) > 10
        far = cv2.dilate((layers.decals[..., 3] > 0).astype(np.uint8), np.ones((61, 61))) == 0
        assert not rise[far].any()
    assert painted >= 3
