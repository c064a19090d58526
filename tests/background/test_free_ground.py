"""Free ground on masks drawn by hand, whose right answer is known."""

import numpy as np
import pytest
import shapely

from pavemark.background.free_ground import SLIVER, SPECK, free_ground, regions
from pavemark.ground import Frame

FRAME = Frame(240, 200, 40.0)  # 6 m × 5 m; SPECK is 160 px, SLIVER 8 px
NOTHING = np.zeros((200, 240), bool)


def sure(ground: np.ndarray) -> np.ndarray:
    return np.where(ground, 0.9, 0.1).astype(np.float32)


def cleaned(ground, markings=NOTHING, ego=NOTHING, frame=FRAME):
    return free_ground(sure(ground), markings, ego, frame)


def test_what_is_clean_stays_as_it_is():
    ground = ~NOTHING
    ground[40:160, 100:180] = False  # a car
    ground[:, :30] = False  # a wall
    np.testing.assert_array_equal(cleaned(ground), ground)
    np.testing.assert_array_equal(cleaned(~NOTHING), ~NOTHING)
    assert not cleaned(NOTHING).any()


@pytest.mark.parametrize(("side", "kept"), [(12, False), (13, True)])
@pytest.mark.parametrize("scale", [1, 3])
def test_holes_and_pieces_below_a_tenth_of_a_square_metre_go_at_any_scale(side, kept, scale):
    assert (12 / 40) ** 2 < SPECK < (13 / 40) ** 2
    ground = ~NOTHING
    ground[:, 100:140] = False
    ground[50 : 50 + side, 110 : 110 + side] = True
    ground[50 : 50 + side, 40 : 40 + side] = False
    ground = ground.repeat(scale, 0).repeat(scale, 1)
    found = free_ground(sure(ground), ground & False, ground & False, Frame(240 * scale, 200 * scale, 40.0 * scale))
    assert found[55 * scale, 115 * scale] == kept
    assert found[55 * scale, 45 * scale] != kept
    assert not found[20 * scale, 120 * scale]
    assert found[20 * scale, 20 * scale]


@pytest.mark.parametrize(("width", "kept"), [(6, False), (10, True)])
def test_slivers_between_things_go_and_wide_strips_keep_their_corners(width, kept):
    assert 6 / 40 < SLIVER < 10 / 40
    ground = NOTHING.copy()
    ground[:, :80] = True
    ground[100 : 100 + width, 80:200] = True
    found = cleaned(ground)
    assert found[103, 190] == kept
    assert found[:, :80].all()
    if kept:
        np.testing.assert_array_equal(found, ground)


def test_a_strip_along_the_border_may_go_on_beyond_it():
    ground = NOTHING.copy()
    ground[:, :5] = True
    np.testing.assert_array_equal(cleaned(ground), ground)


def test_markings_are_ground_and_the_ego_car_is_not_whatever_the_network_says():
    ground = ~NOTHING
    ground[60:140, 100:140] = False
    markings, ego = NOTHING.copy(), NOTHING.copy()
    markings[90:110, 90:150] = True
    ego[90:96, 10:16] = True  # 0.02 m²: no speck that goes
    ego[90:110, 140:150] = True
    found = cleaned(ground, markings, ego)
    assert not found[ego].any()
    assert found[markings & ~ego].all()
    assert not found[70, 120]


def test_a_piece_counts_as_large_as_it_is_without_its_holes():
    ground = NOTHING.copy()
    ground[50:64, 50:64] = True
    ground[54:60, 54:60] = False  # 196 px with the hole, 160 without it
    assert cleaned(ground)[50:64, 50:64].all()


def test_a_thing_reaches_as_far_as_ground_is_doubted_and_doubt_alone_is_no_thing():
    probability = np.full((200, 240), 0.9, np.float32)
    probability[50:150, 20:100] = 0.79  # a car's smeared body
    probability[80:120, 40:60] = 0.39  # and its wheels
    probability[50:150, 140:220] = 0.41  # a seam, wet ground
    found = free_ground(probability, NOTHING, NOTHING, FRAME)
    assert not found[50:150, 20:100].any()
    assert found.sum() == found.size - 8000
    probability[80:120, 40:60] = 0.81
    assert free_ground(probability, NOTHING, NOTHING, FRAME).all()


def test_paint_parts_what_is_doubted():
    probability = np.full((200, 240), 0.7, np.float32)
    probability[:, :40] = 0.1
    line = NOTHING.copy()
    line[:, 100:104] = True
    found = free_ground(probability, line, NOTHING, FRAME)
    assert not found[:, :100].any()
    assert found[:, 100:].all()


def test_the_regions_are_the_pieces_in_metres_largest_first():
    ground = NOTHING.copy()
    ground[:40, :40] = True  # 1 m², upper left
    ground[:, 100:] = True
    ground[80:120, 140:180] = False
    first, second = regions(ground, FRAME)
    assert first.area_m2 == pytest.approx(3.5 * 5 - 1)
    assert second.area_m2 == pytest.approx(1)
    outer = shapely.Polygon(first.polygon.ring, first.polygon.holes)
    wanted = shapely.Polygon(shapely.box(-0.5, -2.5, 3, 2.5).exterior, [shapely.box(0.5, -0.5, 1.5, 0.5).exterior])
    assert outer.symmetric_difference(wanted).area < 1e-9
    assert shapely.Polygon(second.polygon.ring).symmetric_difference(shapely.box(-3, 1.5, -2, 2.5)).area < 1e-9
    assert regions(NOTHING, FRAME) == ()


def test_ragged_outlines_are_simplified_to_one_percent_of_their_length():
    v, u = np.mgrid[:200, :240]
    ground = v > 60 + 0.3 * u + 2 * np.sin(u / 3)
    (region,) = regions(ground, FRAME)
    assert len(region.polygon.ring) <= 6
    assert region.area_m2 == pytest.approx(ground.sum() / 1600)
    assert shapely.Polygon(region.polygon.ring).area == pytest.approx(region.area_m2, rel=0.05)
