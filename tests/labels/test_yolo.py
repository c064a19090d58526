"""YOLO pose text, read back word by word."""

import numpy as np
import pytest

from pavemark.ground import Frame
from pavemark.labels import yolo
from pavemark.labels.truth import truth
from pavemark.scene import Curvature
from scenes import CAR, plate, row, together

EVERYWHERE = np.ones((600, 600), bool)


def read(scene, ground=EVERYWHERE):
    """Rows (class, box (4,), corners (4, 2), visibility (4,)), coordinates in shares."""
    rows = []
    for line in yolo.encode(truth(scene, ground)).splitlines():
        words = line.split(" ")
        assert len(words) == 17
        keypoints = np.array(words[5:], float).reshape(4, 3)
        rows.append((int(words[0]), np.array(words[1:5], float), keypoints[:, :2], keypoints[:, 2].astype(int)))
    return rows


def test_a_slot_inside_the_frame():
    ((number, box, corners, visibility),) = read(row(n=1, start=(1.0, 2.0), entrance=2.4, depth=3.6))
    # World x 1 to 4.6 and y 2 to -0.4 of ±5.
    np.testing.assert_allclose(box, [0.78, 0.42, 0.36, 0.24], atol=1e-6)
    np.testing.assert_allclose(corners, [[0.6, 0.3], [0.6, 0.54], [0.96, 0.54], [0.96, 0.3]], atol=1e-6)
    assert number == 0 and visibility.tolist() == [2, 2, 2, 2]


def test_a_slot_that_leaves_the_frame_is_cut_and_its_far_corners_are_zero():
    ((_, box, corners, visibility),) = read(row(n=1, start=(1.0, 2.0), entrance=2.0, depth=6.0))
    np.testing.assert_allclose(box, [0.8, 0.4, 0.4, 0.2], atol=1e-6)
    assert visibility.tolist() == [2, 2, 0, 0]
    assert not corners[2:].any()


@pytest.mark.parametrize("kind", yolo.CLASSES)
def test_classes(kind):
    ((number, *_),) = read(row(n=1, kind=kind))
    assert yolo.data("train", "val")["names"][number] == kind


def test_hidden_under_the_car_is_one():
    asphalt = plate(car=CAR)
    ((_, _, _, visibility),) = read(row(asphalt, n=1, start=(2.0, 1.0), entrance=2.5, heading=180.0), asphalt.ground)
    assert visibility.tolist() == [2, 1, 2, 2]


@pytest.mark.parametrize("seed", range(6))
def test_numbers_stay_within_what_readers_accept(seed):
    rng = np.random.default_rng(seed)
    scenes = [
        row(
            n=4,
            kind="slanted",
            start=tuple(rng.uniform(-6, 6, 2).tolist()),
            heading=rng.uniform(0, 360),
            angle=rng.choice([60.0, 90.0, 130.0]),
            curvature=Curvature(200.0, 0.4, seed),
        )
        for _ in range(6)
    ]
    rows = read(together(*scenes))
    assert rows
    for _, box, corners, visibility in rows:
        assert corners.min() >= 0 and corners.max() <= 1
        assert (box[:2] - box[2:] / 2).min() > -1e-6 and (box[:2] + box[2:] / 2).max() < 1 + 1e-6
        assert box[2:].min() > 0
        assert 2 in visibility[:2]


def test_shares_are_of_each_side_of_the_frame():
    frame = Frame(96, 300, 20.0)
    scene = row(plate(frame), n=1, start=(-1.2, 3.0), entrance=3.0, depth=2.4)
    ((_, box, corners, _),) = read(scene, np.ones((300, 96), bool))
    np.testing.assert_allclose(corners[0], [24 / 96, 90 / 300], atol=1e-6)
    np.testing.assert_allclose(box, [48 / 96, 120 / 300, 48 / 96, 60 / 300], atol=1e-6)


def test_mirroring_exchanges_the_ends():
    # Mirrored, a slot keeps its rule (left of p1 → p2) only if the ends change places.
    (p1, p2, p3, _) = read(row(n=1, depth=3.0))[0][2] * (-1, 1)
    assert np.cross(np.append(p2 - p1, 0), np.append(p3 - p2, 0))[2] > 0
    order = yolo.data("", "")["flip_idx"]
    p1, p2, p3, _ = (read(row(n=1, depth=3.0))[0][2] * (-1, 1))[order]
    assert np.cross(np.append(p2 - p1, 0), np.append(p3 - p2, 0))[2] < 0


def test_without_slots_the_text_is_empty():
    assert yolo.encode(truth(row(n=0), EVERYWHERE)) == ""
