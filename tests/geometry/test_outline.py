"""Outlines: joins, ends and corners as paint has them, areas exact, no seams."""

import math

import numpy as np
import pytest
import shapely
from shapely.geometry import Point, box

from pavemark.geometry.outline import outline
from pavemark.scene import Area, Curvature, Marking, Stroke
from scenes import WHITE, row

# Areas of a few square metres from a few hundred coordinates.
ROUNDING = 1e-12


def shape(*parts, curvature=None):
    strokes = tuple(part for part in parts if isinstance(part, Stroke))
    areas = tuple(part for part in parts if isinstance(part, Area))
    return outline(Marking("slot", WHITE, strokes, areas), curvature)


def assert_same(got, wanted):
    assert got.symmetric_difference(wanted).area == pytest.approx(0, abs=ROUNDING)


def line(*points, width=0.1, closed=False):
    return Stroke(tuple((float(x), float(y)) for x, y in points), width, closed)


def test_a_stroke_is_a_rectangle_with_square_ends():
    got = shape(line((0, 0), (3, 0), width=0.2))
    assert_same(got, box(0, -0.1, 3, 0.1))


def test_a_corner_is_mitred():
    got = shape(line((0, 0), (2, 0), (2, 1), width=0.2))
    assert_same(got, shapely.union_all([box(0, -0.1, 2.1, 0.1), box(1.9, -0.1, 2.1, 1)]))


def test_a_t_is_one_piece_without_a_seam():
    got = shape(line((0, 0), (4, 0)), line((2, 0), (2, 3)))
    assert len(got.geoms) == 1
    assert got.area == pytest.approx(4 * 0.1 + 2.95 * 0.1, abs=ROUNDING)
    assert got.contains(box(1.96, -0.04, 2.04, 2.9))


def test_an_l_of_two_strokes_is_their_union():
    got = shape(line((-0.05, 0), (2, 0)), line((0, -0.05), (0, 3)))
    assert_same(got, shapely.union_all([box(-0.05, -0.05, 2, 0.05), box(-0.05, -0.05, 0.05, 3)]))


@pytest.mark.parametrize("first", range(4))
def test_a_closed_stroke_is_mitred_at_every_corner(first):
    corners = [(0, 0), (2.5, 0), (2.5, 5), (0, 5)]
    got = shape(line(*corners[first:], *corners[:first], width=0.2, closed=True))
    assert_same(got, box(-0.1, -0.1, 2.6, 5.1).difference(box(0.1, 0.1, 2.4, 4.9)))
    assert got.area == pytest.approx(2 * 0.2 * 7.5, abs=ROUNDING)


@pytest.mark.parametrize("angle", [67, 90, 128])
def test_a_closed_parallelogram_keeps_its_width_all_round(angle):
    s = np.array((math.cos(math.radians(angle)), math.sin(math.radians(angle)))) * 5
    corners = np.array([(0, 0), (2.6, 0), (2.6 + s[0], s[1]), tuple(s)])
    got = shape(line(*corners, width=0.2, closed=True))
    # Offsetting a polygon by ±w/2 with full corners: the area between is the perimeter times w.
    assert got.area == pytest.approx(0.2 * (2 * 2.6 + 2 * 5), abs=ROUNDING)
    for corner in corners:
        assert got.contains(Point(corner))
    assert len(got.geoms) == 1 and len(got.geoms[0].interiors) == 1


def test_repeated_points_change_nothing():
    plain = shape(line((0, 0), (2, 0), (2, 1)))
    assert shape(line((0, 0), (0, 0), (2, 0), (2, 0), (2, 1), (2, 1))).equals(plain)


def test_a_closed_stroke_that_repeats_its_first_point():
    plain = shape(line((0, 0), (2, 0), (2, 1), (0, 1), closed=True))
    assert_same(shape(line((0, 0), (2, 0), (2, 1), (0, 1), (0, 0), closed=True)), plain)


def test_a_marking_without_parts_is_empty():
    assert shape().is_empty


def test_areas_keep_their_holes():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    hole = ((1.0, 1.0), (2.0, 1.0), (2.0, 3.0), (1.0, 3.0))
    got = shape(Area(ring, (hole,)))
    assert got.area == pytest.approx(14, abs=ROUNDING)
    assert not got.contains(Point(1.5, 2))


def test_shells_run_anticlockwise_and_holes_clockwise():
    got = shape(line((0, 0), (0, 5), (2, 5), (2, 0), closed=True))
    assert all(part.exterior.is_ccw and not any(ring.is_ccw for ring in part.interiors) for part in got.geoms)


@pytest.mark.parametrize("kind", ["closed", "half-closed", "open", "corner"])
@pytest.mark.parametrize("angle", [67.0, 90.0, 128.0])
def test_a_bent_row_stays_close_to_the_straight_one(kind, angle):
    straight, bent = (
        outline(row(n=4, outline=kind, angle=angle, curvature=c).markings[0], c)
        for c in (None, Curvature(150.0, 0.4, 7))
    )
    assert bent.is_valid
    assert len(bent.geoms) == len(straight.geoms)
    assert bent.area == pytest.approx(straight.area, rel=0.02)
    # Displacements are about 1 px of 1/60 m; ten times that would be another drawing.
    assert 0.001 < straight.hausdorff_distance(bent) < 0.2


def test_bent_strokes_keep_their_width():
    curvature = Curvature(200.0, 0.3, 5)
    got = shape(line((-4, 0), (4, 0), width=0.15), curvature=curvature)
    ends = shapely.union_all([Point(x, 0).buffer(0.5) for x in (-4, 4)])
    border = shapely.segmentize(got.boundary.difference(ends), 0.02)
    sides = shapely.points(shapely.get_coordinates(border))
    top = [p.y for p in sides]
    assert max(top) - min(top) > 0.15
    middle = shape(line((-4, 0), (4, 0), width=0.002), curvature=curvature)
    # The chords' sagitta, and half the width of what stands for the centre line.
    np.testing.assert_allclose(shapely.distance(middle, sides), 0.075 - 0.001, atol=2e-3)
