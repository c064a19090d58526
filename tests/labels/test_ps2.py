"""ps2.0 files, read back with scipy and used as the published readers use them."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from pavemark.labels import ps2
from pavemark.labels.truth import truth
from pavemark.scene import Curvature, PlateRef, Scene, Slot
from scenes import CAR, plate, row, together

EVERYWHERE = np.ones((600, 600), bool)
LAYOUT = Path(__file__).parents[2] / "../shared/data/layout/ps2_train_slots.jsonl"


def read(scene, ground=EVERYWHERE):
    return loadmat(io.BytesIO(ps2.encode(truth(scene, ground))))


def test_a_row():
    got = read(row(n=2, start=(1.0, 2.0), entrance=2.5))
    # World (1, 2) is the image point (360, 180); the first pixel's centre, 0.5 there, is 1 here.
    np.testing.assert_allclose(got["marks"], [[360.5, 180.5], [360.5, 330.5], [360.5, 480.5]], atol=1e-9)
    np.testing.assert_array_equal(got["slots"], [[1, 2, 1, 90], [2, 3, 1, 90]])
    assert got["marks"].dtype == np.float64


@pytest.mark.parametrize(("angle", "form"), [(67.0, 2), (89.0, 2), (120.0, 3), (137.4, 3)])
@pytest.mark.parametrize("heading", [-90.0, 90.0, 20.0])
def test_slanted(angle, form, heading):
    slots = read(row(n=2, kind="slanted", angle=angle, heading=heading, start=(0.0, 0.0), entrance=1.2))["slots"]
    np.testing.assert_array_equal(slots, [[1, 2, form, round(angle)], [2, 3, form, round(angle)]])


def test_the_far_corners_follow_from_the_row_as_the_labelling_tool_draws_them():
    scene = row(n=1, kind="slanted", angle=120.0, heading=-70.0, start=(0.5, 1.0))
    got = read(scene)
    i, j, _, degrees = got["slots"][0]
    p1, p2 = got["marks"][i - 1], got["marks"][j - 1]
    a = np.deg2rad(degrees)
    depth = (p2 - p1) @ np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    x, y = np.array(scene.slots[0].corners[3]) - scene.slots[0].corners[0]
    np.testing.assert_allclose(depth / np.hypot(*depth), np.array([x, -y]) / np.hypot(x, y), atol=1e-9)


@pytest.mark.parametrize("kind", ["perpendicular", "parallel"])
def test_right_angled_kinds_stay_at_90_when_bent(kind):
    slots = read(row(n=3, kind=kind, curvature=Curvature(200.0, 0.3, 1)))["slots"]
    np.testing.assert_array_equal(slots[:, 2:], [[1, 90]] * 3)


def test_indices_count_visible_points_only():
    asphalt = plate(car=CAR)
    # The first point lies above the frame; the car hides nothing of the second row.
    scene = together(
        row(asphalt, n=3, start=(1.6, 5.5), entrance=2.6), row(asphalt, n=1, start=(-1.6, -2.0), heading=90.0)
    )
    got = read(scene, asphalt.ground)
    np.testing.assert_allclose(got["marks"][:, 1], [126.5, 282.5, 438.5, 420.5, 264.5], atol=1e-9)
    np.testing.assert_array_equal(got["slots"][:, :2], [[1, 2], [2, 3], [4, 5]])


def test_a_lone_visible_point_is_listed_without_a_slot():
    got = read(row(n=1, start=(1.6, 6.0), entrance=2.6))
    assert got["marks"].shape == (1, 2) and got["slots"].shape == (0, 4)


def test_without_slots_the_arrays_are_empty_but_there():
    got = read(row(n=0))
    assert got["marks"].shape == (0, 2) and got["slots"].shape == (0, 4)
    assert len(got["slots"]) == 0


def test_published_readers_can_index_with_the_slots():
    got = read(row(n=2))
    marks, slots = np.array(got["marks"]), np.array(got["slots"])
    marks[:, 0:4] -= 300.5
    partner = np.full((10, 2), -1, np.int32)
    for slot in slots:
        partner[slot[0] - 1, 0] = slot[1] - 1
    assert partner[:3, 0].tolist() == [1, 2, -1]
    np.testing.assert_allclose(
        (marks[:, :2] + 300) / 600, np.array([m.point for m in truth(row(n=2), EVERYWHERE).marks]) / 600
    )


def test_bytes_hold_no_date():
    data = ps2.encode(truth(row(n=2), EVERYWHERE))
    assert data[:116].rstrip() == b"MATLAB 5.0 MAT-file, parking-slot labels"
    # Bytes 116 to 123 hold no subsystem offset, 124 to 127 version 5 and the order of bytes.
    assert data[124:128] == b"\x00\x01IM"
    assert data == ps2.encode(truth(row(n=2), EVERYWHERE))


@pytest.mark.skipif(not LAYOUT.exists(), reason="the real layouts are not here")
def test_types_and_sides_agree_with_real_labels():
    real = [slot for line in LAYOUT.open() for slot in json.loads(line)["slots"]]
    chosen = [slot for slot in real if slot["type"] != 1] + [slot for slot in real if slot["type"] == 1][:300]
    assert len(chosen) > 500
    reference = PlateRef("real", "0" * 64)
    for slot in chosen:
        depth = 150 * np.array([np.cos(slot["depth_angle"]), np.sin(slot["depth_angle"])])
        p1, p2 = np.array(slot["p1"]), np.array(slot["p2"])
        corners = reference.frame.to_world(np.array([p1, p2, p2 + depth, p1 + depth]))
        kind = "slanted" if slot["type"] != 1 else "perpendicular"
        placed = Slot(tuple(map(tuple, corners.tolist())), kind, ("T", "T"), "closed")
        rows = ps2.slot_rows(truth(Scene(0, reference, slots=(placed,)), EVERYWHERE))
        assert [line[2] for line in rows] == [slot["type"]] * len(rows)
