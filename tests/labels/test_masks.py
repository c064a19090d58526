"""Masks against rectangles and half planes written down by hand."""

import attrs
import numpy as np
import pytest

from pavemark.geometry.elastic import displace
from pavemark.ground import Frame
from pavemark.labels import masks
from pavemark.labels.truth import truth
from pavemark.scene import Area, Blend, Curvature, Marking
from scenes import CAR, WHITE, plate, row, together

EVERYWHERE = np.ones((600, 600), bool)


def inside(corners, at):
    """Whether points (..., 2) lie within a convex polygon, and how far from its nearest side."""
    a = np.asarray(corners, float)
    side = np.roll(a, -1, axis=0) - a
    depth = [
        (s[0] * (at[..., 1] - p[1]) - s[1] * (at[..., 0] - p[0])) / np.hypot(*s) for p, s in zip(a, side, strict=True)
    ]
    # Anticlockwise in the world: the inside is on the left.
    return np.min(depth, axis=0) > 0, np.min(np.abs(depth), axis=0)


def test_lines_of_a_closed_slot_are_the_rectangles_of_its_sides():
    scene = row(n=1, start=(1.0, 2.0), entrance=2.5, depth=3.0)
    # World x 1 to 4, y 2 to -0.5, 6 px wide: pixels 360 to 540 and 180 to 330, three more each way.
    wanted = np.zeros((600, 600), np.uint8)
    wanted[177:333, 357:543] = 1
    wanted[183:327, 363:537] = 0
    got = masks.lines(truth(scene, EVERYWHERE))
    np.testing.assert_array_equal(got, wanted)
    assert got.dtype == np.uint8


def test_half_covered_pixels_count():
    # 10.5 px is 0.175 m: three pixels and a half to each side, the half one in; a hair less, out.
    def width(metres):
        return masks.lines(truth(row(n=2, outline="half-closed", width=metres), EVERYWHERE))[150, 360:440].sum()

    assert width(7.0 / 60 + 1e-6) == 8
    assert width(7.0 / 60 - 1e-6) == 6


def test_what_is_not_ground_is_no_line_and_no_slot():
    asphalt = plate(car=CAR)
    scene = row(asphalt, n=2, start=(-3.0, -1.0), heading=0.0, depth=4.0)
    everything = truth(scene, EVERYWHERE)
    labelled = truth(scene, asphalt.ground)
    for mask in (masks.lines, masks.slots):
        assert mask(everything)[~asphalt.ground].any()
        np.testing.assert_array_equal(mask(labelled), np.where(asphalt.ground, mask(everything), 0))


def test_kinds():
    scene = row(n=1)
    for kind, labelled in (("former", False), ("slot", True), ("original", True), ("symbol", True)):
        coat = attrs.evolve(scene.markings[0], kind=kind)
        assert masks.lines(truth(attrs.evolve(scene, markings=(coat,)), EVERYWHERE)).any() == labelled


def test_two_coats_that_share_a_pixel_count_together():
    def box(x0, x1):
        ring = tuple((x / 60, y / 60) for x, y in ((x0, 0), (x1, 0), (x1, 10), (x0, 10)))
        return Marking("original", WHITE, areas=(Area(ring),))

    scene = attrs.evolve(row(n=0), markings=(box(0, 10.4), box(10.7, 20)), blend=Blend())
    assert masks.lines(truth(scene, EVERYWHERE))[295, 300:320].all()


@pytest.mark.parametrize("curvature", [None, Curvature(150.0, 0.5, 3)])
def test_slots_by_number(curvature):
    scene = together(
        row(n=3, angle=67.0, start=(1.2, 3.0), entrance=2.0, curvature=curvature),
        row(n=1, kind="parallel", heading=90.0, start=(-2.0, -3.0), entrance=6.0, depth=2.2),
    )
    got = masks.slots(truth(scene, EVERYWHERE))
    at = Frame().pixel_centres()
    expected = np.zeros((600, 600), int)
    doubtful = np.zeros((600, 600), bool)
    for number, slot in enumerate(scene.slots, 1):
        within, distance = inside(displace(curvature, np.array(slot.corners)), at)
        expected[within] = number
        # Pixels at the border are for coverage to decide; bent sides leave the chord by a few pixels.
        doubtful |= distance < (0.013 if curvature is None else 0.12)
    assert got.dtype == np.uint8 and set(np.unique(got)) == {0, 1, 2, 3, 4}
    np.testing.assert_array_equal(got[~doubtful], expected[~doubtful])
    assert (~doubtful).mean() > 0.75


def test_neighbours_leave_no_gap():
    got = masks.slots(truth(row(n=3, start=(0.0, 3.9), curvature=Curvature(150.0, 0.4, 3)), EVERYWHERE))
    # Along a column through all three: from the first to the last pixel of any slot there is no hole.
    column = got[:, 450]
    used = np.flatnonzero(column)
    assert column[used[0] : used[-1] + 1].all()


def test_more_slots_than_a_byte_holds():
    scene = row(n=300, entrance=0.03, depth=1.0, start=(0.0, 4.5))
    got = masks.slots(truth(scene, EVERYWHERE))
    assert got.dtype == np.uint16 and got.max() == 300


def test_an_empty_scene_has_empty_masks_of_the_frame():
    frame = Frame(96, 300, 20.0)
    labelled = truth(row(plate(frame), n=0), np.ones((300, 96), bool))
    for mask in (masks.lines(labelled), masks.slots(labelled)):
        assert mask.shape == (300, 96) and not mask.any() and mask.dtype == np.uint8
