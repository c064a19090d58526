"""The truth against the numbers of hand-made scenes."""

import json
import math

import attrs
import numpy as np
import pytest

from pavemark.errors import InputError
from pavemark.geometry.elastic import displace
from pavemark.ground import Frame
from pavemark.labels.truth import HIDDEN, OUTSIDE, VISIBLE, truth
from pavemark.records import from_json, to_json
from pavemark.scene import Curvature, Scene, Slot
from scenes import CAR, plate, row, together

BENT = Curvature(150.0, 0.4, 9)
EVERYWHERE = np.ones((600, 600), bool)


def true(scene, ground=EVERYWHERE):
    return truth(scene, ground)


def image(x, y):
    """World metres in the pixels of the default frame, by hand."""
    return 300 + 60 * x, 300 - 60 * y


def unit(degrees):
    """Unit vector in the picture (y down) from degrees anticlockwise as seen."""
    return math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))


def test_points_of_a_straight_row():
    got = true(row(n=3, start=(1.0, 4.0), entrance=2.5))
    assert [mark.point for mark in got.marks] == [
        pytest.approx(image(1.0, y), abs=1e-9) for y in (4.0, 1.5, -1.0, -3.5)
    ]
    assert [mark.shape for mark in got.marks] == ["L", "T", "T", "L"]
    assert [slot.entrance for slot in got.slots] == [(0, 1), (1, 2), (2, 3)]


@pytest.mark.parametrize("heading", [-90.0, 0.0, 37.0, 180.0])
@pytest.mark.parametrize("angle", [67.0, 90.0, 128.0])
def test_directions_and_angle(heading, angle):
    got = true(row(n=3, heading=heading, angle=angle, entrance=1.5, start=(0.5, 0.5)))
    into_the_slot, towards_p1 = unit(heading + angle), unit(heading + 180)
    for mark in got.marks[:3]:
        assert mark.direction == pytest.approx(into_the_slot, abs=1e-12)
    assert got.marks[3].shape == "L"
    assert got.marks[3].direction == pytest.approx(towards_p1, abs=1e-12)
    assert [slot.angle for slot in got.slots] == pytest.approx([angle] * 3, abs=1e-9)


def test_the_slot_lies_to_the_left_of_its_entrance_as_seen():
    for heading in (-90.0, 10.0, 100.0):
        slot = true(row(n=1, heading=heading)).slots[0]
        (x1, y1), (x2, y2), (x3, y3), _ = slot.corners
        # With y down the left of v = (vx, vy) is (vy, -vx).
        assert (y2 - y1) * (x3 - x2) - (x2 - x1) * (y3 - y2) > 0


def test_curvature_moves_points_and_turns_directions():
    scene = row(n=3, entrance=2.5, curvature=BENT, angle=67.0)
    got = true(scene)
    for slot, labelled in zip(scene.slots, got.slots, strict=True):
        moved = displace(BENT, np.array(slot.corners))
        np.testing.assert_allclose(labelled.corners, [image(x, y) for x, y in moved], atol=1e-9)
        p1, _, _, p4 = np.array(slot.corners)
        step = 1e-6 * (p4 - p1)
        x, y = displace(BENT, p1 + step) - displace(BENT, p1 - step)
        # A difference over 1e-5 m, known to 1e-15 m.
        assert got.marks[labelled.entrance[0]].direction == pytest.approx((x, -y) / np.hypot(x, y), abs=1e-8)
    assert got.marks[0].point != pytest.approx(image(*scene.slots[0].corners[0]), abs=0.05)


def test_a_shared_point_is_merged_before_the_curvature():
    assert len(true(row(n=4, entrance=1.8, curvature=BENT)).marks) == 5


@pytest.mark.parametrize(("gap", "count"), [(0.0, 3), (0.0009, 3), (0.0011, 4)])
def test_points_within_a_millimetre_are_one(gap, count):
    upper = row(n=1, start=(0.0, 3.0), entrance=2.0)
    lower = row(n=1, start=(0.0, 1.0 - gap), entrance=2.0)
    assert len(true(together(upper, lower)).marks) == count


def test_a_junction_is_a_t_whichever_slot_comes_first():
    scene = row(n=2)
    (first, second) = scene.slots
    odd = attrs.evolve(first, marks=("L", "L"))
    for slots in ((odd, second), (second, odd)):
        got = true(attrs.evolve(scene, slots=slots))
        shared = set(got.slots[0].entrance) & set(got.slots[1].entrance)
        mark = got.marks[shared.pop()]
        assert (mark.shape, mark.direction) == ("T", pytest.approx((1.0, 0.0), abs=1e-12))


def test_points_outside_the_frame_and_on_the_car_are_not_visible():
    asphalt = plate(car=CAR)
    # p1 above the frame, p2 beside the car, the next under it.
    scene = row(asphalt, n=2, start=(0.0, 5.5), heading=-90.0, entrance=3.0, depth=2.0)
    got = true(scene, asphalt.ground)
    assert [mark.visible for mark in got.marks] == [False, True, False]
    assert [slot.visibility for slot in got.slots] == [
        (OUTSIDE, VISIBLE, VISIBLE, OUTSIDE),
        (VISIBLE, HIDDEN, VISIBLE, VISIBLE),
    ]
    assert [slot.paired for slot in got.slots] == [False, False]
    assert [slot.seen for slot in got.slots] == [True, True]


def test_the_border_belongs_to_the_frame_on_one_side_only():
    left = row(n=1, start=(-5.0, 1.0), heading=-90.0, entrance=2.0)
    right = row(n=1, start=(5.0, -1.0), heading=90.0, entrance=2.0)
    assert [mark.visible for mark in true(left).marks] == [True, True]
    assert [mark.visible for mark in true(right).marks] == [False, False]
    assert not true(right).slots[0].seen


def test_unpainted_corners_are_not_visible():
    for outline, far in (("closed", VISIBLE), ("half-closed", VISIBLE), ("open", VISIBLE), ("corner", HIDDEN)):
        slot = true(row(n=1, outline=outline, depth=2.0)).slots[0]
        assert slot.visibility == (VISIBLE, VISIBLE, far, far)


def test_a_slot_without_visible_marking_point_is_not_seen():
    slot = true(row(n=1, start=(5.5, 1.0), heading=90.0, entrance=2.0, depth=2.0)).slots[0]
    assert slot.visibility == (OUTSIDE, OUTSIDE, VISIBLE, VISIBLE)
    assert not slot.seen
    assert slot.region.area == pytest.approx(2.0 * 1.5 * 3600)


def test_frames_of_any_size_and_scale():
    frame = Frame(96, 300, 1 / 0.044)
    scene = row(plate(frame), n=2, start=(-1.0, 3.0), entrance=2.5)
    marks = truth(scene, np.ones((300, 96), bool)).marks
    assert marks[1].point == pytest.approx((48 - 1 / 0.044, 150 - 0.5 / 0.044), abs=1e-9)
    assert all(mark.visible for mark in marks)


def test_former_coats_are_not_labelled():
    scene = row(n=2)
    kinds = ("former", "slot", "original", "symbol")
    scene = attrs.evolve(scene, markings=tuple(attrs.evolve(scene.markings[0], kind=kind) for kind in kinds))
    assert [kind for kind, _ in true(scene).markings] == ["slot", "original", "symbol"]


def test_an_empty_scene():
    got = true(row(n=0))
    assert (got.marks, got.slots, got.markings) == ((), (), ())


def test_corners_must_run_anticlockwise(tmp_path):
    corners = row(n=1).slots[0].corners
    for wrong in (corners[::-1], (corners[0],) * 4, (corners[0], corners[2], corners[1], corners[3])):
        with pytest.raises(ValueError, match="corners"):
            Slot(wrong, "parallel", ("L", "L"), "closed")
    file = tmp_path / "scene.json"
    data = json.loads(to_json(row(n=1)))
    data["slots"][0]["corners"].reverse()
    file.write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"corners .* anticlockwise"):
        from_json(Scene, file)
