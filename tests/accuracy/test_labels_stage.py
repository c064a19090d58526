"""The labels stage: files of known contents read back, and errors that are known to be there."""

import json

import numpy as np
import pytest

from pavemark import files
from pavemark.accuracy import label_files, labels
from pavemark.accuracy.labels import FLOORS, LINES, POINTS, contenders, judge, scenes, work
from pavemark.accuracy.race import Contender, Run
from pavemark.labels import coco, dmpr, ps2, yolo
from pavemark.labels.truth import truth
from scenes import row

EVERYWHERE = np.ones((600, 600), bool)
CORNERS = [[360.0, 180.0], [360.0, 330.0], [540.0, 330.0], [540.0, 180.0]]
"""Image coordinates of p1 … p4 of the slot below: world (1, 2), 2.5 m down, 3 m to the right."""


@pytest.fixture(scope="module")
def true():
    return truth(row(n=1, start=(1.0, 2.0), entrance=2.5, depth=3.0), EVERYWHERE)


def test_points_read_back_in_image_coordinates(true):
    for found in (label_files.ps2_points(ps2.encode(true)), label_files.dmpr_points(dmpr.encode(true).encode())):
        np.testing.assert_allclose(found, CORNERS[:2], atol=1e-4)
    fragment = json.dumps(coco.fragment(true, "a.png")).encode()
    yolos = label_files.yolo_points(yolo.encode(true).encode(), 600, 600)
    for found in (yolos, label_files.coco_points(fragment)):
        np.testing.assert_allclose(found, CORNERS, atol=1e-3)
    (floor,) = label_files.coco_floors(fragment)
    assert floor.area == pytest.approx(150 * 180, abs=0.1) and floor.bounds == (360, 180, 540, 330)


def test_files_without_slots_have_no_points():
    none = truth(row(n=0), EVERYWHERE)
    assert label_files.ps2_points(ps2.encode(none)).shape == (0, 2)
    assert label_files.dmpr_points(dmpr.encode(none).encode()).shape == (0, 2)
    assert label_files.yolo_points(yolo.encode(none).encode(), 600, 600).shape == (0, 2)
    assert label_files.coco_points(json.dumps(coco.fragment(none, "a.png")).encode()).shape == (0, 2)


def error(problem, family, setting="", change=lambda data: data):
    one = Contender(problem, family, setting)
    return judge(Run(one, list(map(change, work(one))), (1.0,)))["error"]


def test_what_ships_is_within_its_rounding():
    assert error(POINTS, "ps2.0") < 1e-9
    assert error(POINTS, "DMPR") <= 0.5e-4 * 2**0.5 * 1.001  # four digits, in both coordinates
    assert error(POINTS, "YOLO") <= 0.5e-7 * 600 * 2**0.5 * 1.001  # seven, shares of 600 pixels
    assert 1e-4 < error(POINTS, "COCO") <= 0.5e-3 * 2**0.5 * 1.001  # three
    assert 0.02 < error(FLOORS, "COCO", f"{coco.SMOOTH:g} px") < coco.SMOOTH + 0.01
    assert error(FLOORS, "COCO", "0 px") < 0.01 < 0.5 < error(FLOORS, "COCO", "1 px") < 1.01


def test_what_is_off_by_half_a_pixel_is_found():
    def shifted(data):
        label = json.loads(data)
        label["marks"] = [[x + 0.5, *rest] for x, *rest in label["marks"]]
        return json.dumps(label).encode()

    assert error(POINTS, "DMPR", change=shifted) == pytest.approx(0.5, abs=1e-3)

    def lost(data):
        label = json.loads(data)
        return json.dumps(label | {"marks": label["marks"][1:]}).encode()

    assert error(POINTS, "DMPR", change=lost) > 50


def test_masks():
    ships = error(LINES, "half of the pixel covered")
    # A pixel's border is at most half its diagonal from a straight edge through it; corners are cut off by more.
    assert 0.5 < ships < 1.2
    assert ships == pytest.approx(error(LINES, "pixel's centre covered"), abs=0.2)

    def thicker(data):
        mask = label_files.mask(data)
        return files.png((mask | np.roll(mask, 2, 1)).astype(np.uint8))

    assert error(LINES, "half of the pixel covered", change=thicker) > 1.9


def test_each_format_and_each_knob_ships_once():
    every = contenders()
    assert sum(one.ships for one in every if one.problem == POINTS) == 4
    assert [sum(one.ships for one in every if one.problem == what) for what in (FLOORS, LINES)] == [1, 1]
    assert any(scene.curvature for scene in scenes()) and len(scenes()) == labels.IMAGES
    assert work(None) is None
