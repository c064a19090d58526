"""`blender -b -P render.py -- JOB.toml` against the wheel: labels to the bit, pixels to the level."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def pair(blender, demo, tmp_path_factory):
    """The same job by the program and by the wheel."""
    out = tmp_path_factory.mktemp("out")
    # One worker: the machine is shared by two Blenders otherwise.
    options = [str(demo / "job.toml"), "--workers", "1", "--out"]
    blender.run("-b", "--python-exit-code", "1", "-P", ROOT / "render.py", "--", *options, out / "program")
    subprocess.run(
        [sys.executable, ROOT / "render.py", *options, out / "wheel"], check=True, env={**blender.environment}
    )
    return out / "program", out / "wheel"


def test_labels_and_masks_are_equal_to_the_bit(pair):
    program, wheel = pair
    compared = 0
    for folder in ("labels", "masks", "slots"):
        for path in sorted((wheel / folder).rglob("*")):
            if path.is_file():
                assert (program / path.relative_to(wheel)).read_bytes() == path.read_bytes(), path
                compared += 1
    assert compared == 4 * 5 + 1


def numbers(value):
    """All numbers of plain data, in order; everything else as it is."""
    if isinstance(value, dict):
        return [leaf for name in sorted(value) for leaf in (name, *numbers(value[name]))]
    return [leaf for item in value for leaf in numbers(item)] if isinstance(value, list) else [value]


def test_scenes_say_the_same(pair):
    """What is drawn is the same to the bit. What is measured on the plate, blur and ratios, goes through sums of
    float32, which another numpy adds up in another order: 6e-8 apart with 2.4 and 2.5."""
    program, wheel = pair
    for path in sorted((wheel / "scenes").glob("*.json")):
        here, there = (numbers(json.loads((out / "scenes" / path.name).read_text())) for out in (program, wheel))
        assert len(here) == len(there)
        for a, b in zip(here, there, strict=True):
            assert a == b or a == pytest.approx(b, rel=1e-6)


def test_pixels_are_equal(pair):
    """Equal to the bit between the program 5.2.2 and the wheel 5.2.3; the measured numbers could cost a rounding."""
    program, wheel = pair
    for path in sorted((wheel / "images").glob("*.png")):
        here, there = (cv2.imread(str(out / "images" / path.name)).astype(int) for out in (program, wheel))
        assert np.abs(here - there).max() <= 1, path.name
        assert (here != there).any(2).mean() < 1e-4, path.name


def test_the_manifest_names_the_program(pair, blender):
    program, wheel = pair
    rows = [json.loads((out / "manifest.jsonl").read_text().splitlines()[0]) for out in (program, wheel)]
    assert all(row["versions"]["renderer"].startswith("Blender 5.") for row in rows)


def test_a_run_leaves_the_users_extensions_alone(blender, pair):
    told = blender.run("-b", "--python-expr", "import pavemark, cv2, shapely; print('all there')")
    assert "all there" in told
