"""COCO, decoded by a few lines that share nothing with the writer."""

import json

import attrs
import numpy as np
import pytest

from pavemark.ground import Frame
from pavemark.labels import coco
from pavemark.labels.truth import truth
from pavemark.scene import Curvature
from scenes import CAR, plate, row, together

EVERYWHERE = np.ones((600, 600), bool)
BENT = Curvature(150.0, 0.4, 2)


def read(*scenes, ground=EVERYWHERE):
    fragments = [coco.fragment(truth(scene, ground), f"{scene.index:06d}.png") for scene in scenes]
    return json.loads("".join(coco.dataset(json.loads(json.dumps(fragments)))))


def annotations(data, name):
    (category,) = [entry["id"] for entry in data["categories"] if entry["name"] == name]
    return [entry for entry in data["annotations"] if entry["category_id"] == category]


def decode_polygons(rings, height=600, width=600):
    """Even-odd rule at the pixels' centres."""
    y, x = np.mgrid[:height, :width] + 0.5
    mask = np.zeros((height, width), bool)
    for ring in rings:
        points = np.array(ring).reshape(-1, 2)
        for (x0, y0), (x1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            if y0 != y1:
                mask ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return mask


def decode_runs(segmentation):
    """Runs of 0 and 1 by turns, down the columns."""
    height, width = segmentation["size"]
    pixels, value = [], 0
    for count in segmentation["counts"]:
        pixels += [value] * count
        value = 1 - value
    return np.array(pixels, bool).reshape(width, height).T


def shoelace(ring):
    x, y = np.array(ring).reshape(-1, 2).T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_a_slot():
    data = read(row(n=1, start=(1.0, 2.0), entrance=2.5, depth=3.0, index=7))
    assert data["images"] == [{"id": 7, "file_name": "000007.png", "width": 600, "height": 600}]
    (slot,) = annotations(data, "slot")
    # Pixel indices, so half a pixel less than the image coordinates (360, 180) and so on.
    np.testing.assert_allclose(
        np.array(slot["keypoints"]).reshape(4, 3),
        [[359.5, 179.5, 2], [359.5, 329.5, 2], [539.5, 329.5, 2], [539.5, 179.5, 2]],
    )
    assert slot["bbox"] == [360, 180, 180, 150] and slot["area"] == 180 * 150
    assert (slot["num_keypoints"], slot["image_id"], slot["iscrowd"]) == (4, 7, 0)
    assert (slot["kind"], slot["outline"], slot["marks"], slot["angle"]) == ("perpendicular", "closed", ["L", "L"], 90)
    (ring,) = slot["segmentation"]
    assert len(ring) == 8
    wanted = np.zeros((600, 600), bool)
    wanted[180:330, 360:540] = True
    np.testing.assert_array_equal(decode_polygons([ring]), wanted)


@pytest.mark.parametrize("angle", [67.0, 90.0, 128.0])
@pytest.mark.parametrize("curvature", [None, BENT])
def test_polygons_boxes_and_areas_agree(angle, curvature):
    scene = together(
        row(n=4, kind="slanted", angle=angle, entrance=2.3, curvature=curvature),
        row(n=3, kind="slanted", angle=angle, heading=90.0, start=(-1.6, -6.5), depth=3.0),
    )
    slots = annotations(read(scene), "slot")
    assert len(slots) == 7
    for slot in slots:
        points = np.concatenate([np.array(ring).reshape(-1, 2) for ring in slot["segmentation"]])
        assert points.min() >= 0 and points.max() <= 600
        assert sum(map(shoelace, slot["segmentation"])) == pytest.approx(slot["area"], rel=2e-3)
        assert decode_polygons(slot["segmentation"]).sum() == pytest.approx(slot["area"], rel=5e-3)
        x, y, width, height = slot["bbox"]
        np.testing.assert_allclose([*points.min(0), *points.max(0)], [x, y, x + width, y + height], atol=0.06)
        assert len(points) < 200
        for u, v, visibility in np.array(slot["keypoints"]).reshape(4, 3):
            if visibility == 2:
                # A corner is a corner of the polygon too, half a pixel further in its count.
                assert np.hypot(*(points - (u + 0.5, v + 0.5)).T).min() < 0.06


def test_a_slot_with_one_marking_point_is_listed_with_flags():
    (slot,) = annotations(read(row(n=1, start=(1.0, 6.0), entrance=2.5, depth=3.0)), "slot")
    keypoints = np.array(slot["keypoints"]).reshape(4, 3)
    assert keypoints[:, 2].tolist() == [0, 2, 2, 0]
    assert not keypoints[[0, 3], :2].any()
    assert slot["num_keypoints"] == 2
    assert slot["area"] == pytest.approx(180 * 90)


def test_a_slot_without_marking_point_in_sight_is_not_listed():
    assert not annotations(read(row(n=1, start=(5.5, 1.0), heading=90.0, entrance=2.0, depth=2.0)), "slot")


def test_markings_are_runs_with_their_holes():
    (marking,) = annotations(read(row(n=1, start=(1.0, 2.0), entrance=2.5, depth=3.0)), "marking")
    wanted = np.zeros((600, 600), bool)
    wanted[177:333, 357:543] = True
    wanted[183:327, 363:537] = False
    np.testing.assert_array_equal(decode_runs(marking["segmentation"]), wanted)
    assert marking["area"] == wanted.sum() and marking["bbox"] == [357, 177, 186, 156]
    assert marking["kind"] == "slot"


def test_markings_stop_at_the_car_and_vanish_under_it():
    asphalt = plate(car=CAR)
    crossing = row(asphalt, n=2, start=(-3.0, -1.0), heading=0.0, depth=4.0)
    (marking,) = annotations(read(crossing, ground=asphalt.ground), "marking")
    mask = decode_runs(marking["segmentation"])
    assert mask.any() and not mask[~asphalt.ground].any()
    under = row(asphalt, n=1, start=(-0.5, 0.5), entrance=1.0, depth=1.0)
    assert not read(under, ground=asphalt.ground)["annotations"]


def test_runs_may_begin_with_the_first_pixel_and_end_with_the_last():
    frame = Frame(16, 12, 2.0)
    scene = row(plate(frame), n=1, start=(-6.0, 5.0), entrance=10.0, depth=12.0, width=9.9)
    (marking,) = annotations(read(scene, ground=np.ones((12, 16), bool)), "marking")
    assert marking["segmentation"] == {"size": [12, 16], "counts": [0, 192]}


def test_ids_run_through_all_images_and_empty_images_stay():
    data = read(row(n=2, index=3), row(n=0, index=4), row(n=1, index=5, curvature=BENT))
    assert [image["id"] for image in data["images"]] == [3, 4, 5]
    assert [entry["id"] for entry in data["annotations"]] == [1, 2, 3, 4, 5]
    assert [entry["image_id"] for entry in data["annotations"]] == [3, 3, 3, 5, 5]


def test_the_category_tells_the_corners():
    (slot, marking) = read(row(n=0))["categories"]
    assert slot["keypoints"] == ["p1", "p2", "p3", "p4"] and len(slot["skeleton"]) == 4
    assert "keypoints" not in marking


def test_text_is_the_same_for_the_same_scene():
    scene = row(n=3, curvature=BENT)
    scenes = (scene, attrs.evolve(scene))
    first, second = (list(coco.dataset([coco.fragment(truth(each, EVERYWHERE), "a.png")])) for each in scenes)
    assert first == second
