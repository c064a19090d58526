"""The contact sheet shows what is in the files, where the labels say it is."""

import json
import os

import cv2
import numpy as np
import pytest

from commandline import pavemark
from pavemark.job.contact_sheet import LARGEST
from pavemark.job.folder import recorded
from pavemark.job.preview import preview
from pavemark.labels.truth import truth
from pavemark.records import from_json
from pavemark.scene import Scene

SCALE, GAP, HEAD = 4, 6, 38
"""Of the sheet for so small images."""


@pytest.fixture(scope="module")
def dataset(inputs, tmp_path_factory):
    out = tmp_path_factory.mktemp("preview") / "out"
    job = (
        "--images",
        inputs / "images",
        "--masks",
        inputs / "masks",
        "--scale",
        "12",
        "--inpainter",
        "navier-stokes",
        "--segmenter",
        "strokes",
    )
    fixed = ("--set", "layout.empty_rate = 0", "--set", "noise.rate = 0", "--set", "brightness.rate = 0")
    done = pavemark("render", *job, *fixed, "--count", "3", "--seed", "2", "--workers", "1", "--out", out)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture
def tiles(dataset):
    """The four tiles of the first image, at the images' own size."""
    sheet = cv2.imread(str(preview(dataset)))
    assert max(sheet.shape) <= LARGEST
    left = [GAP + column * (96 * SCALE + GAP) for column in range(4)]
    return [sheet[HEAD : HEAD + 64 * SCALE, x : x + 96 * SCALE] for x in left]


def test_image_and_plate_are_shown_as_they_are(dataset, tiles):
    image = cv2.imread(str(dataset / "images/000000.png"))
    assert (tiles[0][SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] == image).all()
    plate = tiles[1][SCALE // 2 :: SCALE, SCALE // 2 :: SCALE].astype(int)
    far = np.ones((64, 96), bool)
    far[:, 34:48] = False  # beyond the former marking and its soft edge the plate is the input image
    source = cv2.imread(str(dataset / recorded(dataset).images / _input(dataset)))
    assert (plate == source)[far].all()
    assert plate[:, 40:42].mean() < source[:, 40:42].mean() - 30


def _input(dataset):
    return from_json(Scene, dataset / "scenes/000000.json").plate.name + ".png"


def test_marking_points_are_drawn_where_they_are(dataset, tiles):
    scene = from_json(Scene, dataset / "scenes/000000.json")
    true = truth(scene, np.ones((64, 96), bool))
    seen = [mark for mark in true.marks if mark.visible]
    assert seen
    for mark in seen:
        column, row = (int(number * SCALE) for number in mark.point)
        red, blue = (255, 64, 64), (64, 160, 255)
        drawn = tiles[2][row, column, ::-1].astype(int)
        assert np.abs(drawn - (red if mark.shape == "T" else blue)).max() < 60, mark


def test_masks_are_shown(dataset, tiles):
    lines = cv2.imread(str(dataset / "masks/000000.png"), cv2.IMREAD_UNCHANGED) > 0
    shown = tiles[3][SCALE // 2 :: SCALE, SCALE // 2 :: SCALE]
    assert lines.any() and ((shown == 255).all(-1) == lines).all()


def test_without_the_inputs_the_rest_is_shown(dataset, inputs, tmp_path):
    there = (dataset / recorded(dataset).images).resolve()
    away = there.with_name("elsewhere")
    there.rename(away)
    try:
        sheet = cv2.imread(str(preview(dataset)))
    finally:
        away.rename(there)
    assert (sheet[HEAD + 4 : HEAD + 60, GAP + 96 * SCALE + GAP + 4] == 48).all()


@pytest.fixture
def selection(dataset, tmp_path):
    """Of the last image of the dataset, and nothing else of it."""
    out = tmp_path / "kept"
    out.mkdir()
    (out / "selection.json").write_text(json.dumps({"dataset": os.path.relpath(dataset, out)}))
    last = (dataset / "manifest.jsonl").read_text().splitlines()[-1]
    (out / "manifest.jsonl").write_text(last + "\n")
    return out


def test_a_selection_shows_what_it_keeps(dataset, selection):
    done = pavemark("preview", selection)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(selection / "preview.png")
    sheet = cv2.imread(str(selection / "preview.png"))
    tile = sheet[HEAD : HEAD + 64 * SCALE, GAP : GAP + 96 * SCALE]
    assert (tile[SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] == cv2.imread(str(dataset / "images/000002.png"))).all()
    assert sheet.shape[0] < HEAD + 2 * 64 * SCALE, "one image"


def test_a_selection_that_has_its_images_needs_no_dataset(dataset, selection):
    (selection / "selection.json").write_text('{"dataset": "."}')
    (selection / "job.json").write_bytes((dataset / "job.json").read_bytes())
    for name in json.loads((selection / "manifest.jsonl").read_text())["files"]:
        (selection / name).parent.mkdir(parents=True, exist_ok=True)
        (selection / name).write_bytes((dataset / name).read_bytes())
    done = pavemark("preview", selection)
    assert done.returncode == 0, done.stderr
    sheet = cv2.imread(str(selection / "preview.png"))
    tile = sheet[HEAD : HEAD + 64 * SCALE, GAP : GAP + 96 * SCALE]
    assert (tile[SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] == cv2.imread(str(dataset / "images/000002.png"))).all()


def test_a_selection_of_what_is_no_longer_there(selection):
    manifest = selection / "manifest.jsonl"
    manifest.write_text(manifest.read_text().replace("000002", "000007"))
    done = pavemark("preview", selection)
    assert done.returncode == 2 and "holds none of the images that are kept" in done.stderr
