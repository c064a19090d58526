"""Outlines of masks and of areas, from nothing at all to a hundred thousand corners."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from shapely.geometry import MultiPolygon, Polygon, box

from hard_cases import STEADY
from pavemark.background.contours import AREA_CHANGE, areas, outlines, simplified, tolerance
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.scene import Area, Curvature, Marking, Stroke
from scenes import WHITE

PIXELS = np.eye(3)
"""The map of a picture whose ground is measured in its own pixels."""

ROUNDING = 1e-12
"""Square metres: areas of a few, from a few hundred coordinates."""

masks = arrays(bool, array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=14))


def painted(*parts, curvature=None):
    strokes = tuple(part for part in parts if isinstance(part, Stroke))
    return outline(Marking("slot", WHITE, strokes, tuple(part for part in parts if isinstance(part, Area))), curvature)


def polygon(area):
    return Polygon(area.ring, area.holes)


def rings(shape):
    return [np.array(ring.coords[:-1]) for ring in (shape.exterior, *shape.interiors)]


def moved(before, after):
    """How far each corner (N, 2) of a ring lies from the side that stands for it in the ring of some of the corners."""
    number = {tuple(corner): k for k, corner in enumerate(before.tolist())}
    kept = sorted(number[tuple(corner)] for corner in after.tolist())
    # Of each corner the last one kept up to it, and the first one after it.
    turn = np.searchsorted(kept, np.arange(len(before)), side="right")
    start, end = before[np.take(kept, turn - 1)], before[np.take(kept, turn, mode="wrap")]
    side, out = end - start, before - start
    along = np.clip((out * side).sum(1) / (side * side).sum(1), 0, 1)
    return float(np.hypot(*(out - along[:, None] * side).T).max())


def assert_sound(shape, simple):
    """All that simplification promises, worked out corner by corner."""
    assert simple.is_valid
    assert len(simple.interiors) == len(shape.interiors)
    # A ring that touches itself passes a corner twice, and is looked at as a whole.
    whole = shape.normalize()
    once = all(len(np.unique(ring, axis=0)) == len(ring) for ring in rings(whole))
    if once:
        far = max(moved(*pair) for pair in zip(rings(whole), rings(simple), strict=True))
    else:
        far = shapely.distance(simple.boundary, shapely.points(shapely.get_coordinates(shape))).max()
    # Coordinates are whole numbers below 1e3: distances from them are exact to 1e-12.
    assert far <= tolerance(shape) + 1e-12
    assert abs(simple.area - shape.area) <= AREA_CHANGE * shape.area


@settings(STEADY, max_examples=150)
@given(masks)
def test_outlines_are_the_mask_and_no_vertex_moves_further_than_epsilon(mask):
    shapes = outlines(mask)
    # Whole numbers are added: areas are exact.
    assert sum(shape.area for shape in shapes) == mask.sum()
    v, u = np.indices(mask.shape) + 0.5
    inside = sum(shapely.contains_xy(shape, u, v).astype(int) for shape in shapes)
    np.testing.assert_array_equal(inside + np.zeros(mask.shape, int), mask)
    for shape in shapes:
        assert shape.is_valid
        assert_sound(shape, simplified(shape))


@pytest.mark.parametrize("seed", range(20))
def test_no_vertex_of_a_blob_moves_further_than_epsilon(seed):
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:120, :120]
    waves = rng.normal(0, 1 / (1 + np.hypot(*np.indices((6, 6)))), (6, 6))
    height = sum(
        waves[i, j] * np.cos(np.pi * (i * v / 40 + j * u / 40) + rng.uniform(0, 2 * np.pi)) for i, j in np.ndindex(6, 6)
    )
    for shape in outlines(height > 0.3):
        assert_sound(shape, simplified(shape))


def test_zero_area_an_empty_mask_has_no_areas():
    assert areas(np.zeros((10, 10), bool), PIXELS) == ()
    assert areas(np.zeros((0, 7), bool), PIXELS) == ()


def test_zero_area_a_flat_polygon_is_left_as_it_is():
    flat = Polygon([(0, 0), (4, 0), (9, 0)])
    # Its width, and with it the tolerance, is nought.
    assert tolerance(flat) == 0
    assert simplified(flat).area == 0


@pytest.mark.parametrize("curvature", [None, Curvature(150.0, 0.4, 2)], ids=["straight", "bent"])
@pytest.mark.parametrize(
    "part",
    [
        pytest.param(Stroke(((1.0, 1.0), (1.0, 1.0)), 0.1), id="stroke of one point"),
        pytest.param(Stroke(((1.0, 1.0), (1.0, 1.0)), 0.1, True), id="closed stroke of one point"),
        pytest.param(Area(((1.0, 1.0),) * 3), id="area of one point"),
        pytest.param(Area(((1.0, 1.0), (2.0, 2.0), (1.0, 1.0))), id="area of two points"),
        pytest.param(Area(((1.0, 1.0), (2.0, 2.0), (3.0, 3.0))), id="area of zero"),
    ],
)
def test_parts_without_extent_paint_nothing(part, curvature):
    got = painted(part, curvature=curvature)
    assert isinstance(got, MultiPolygon)
    # Points on a line are bent apart: by some centimetres over metres.
    assert got.area < 1e-3
    if curvature is None:
        assert got.is_empty or got.area < ROUNDING


def test_two_points_one_pixel_and_two_have_four_corners():
    mask = np.zeros((6, 9), bool)
    mask[1, 1] = mask[4, 3] = mask[4, 4] = True
    one, two = areas(mask, PIXELS)
    # A quarter of a pixel's half width is the tolerance: less than a side, so that no corner goes.
    assert set(one.ring) == {(1, 1), (2, 1), (2, 2), (1, 2)}
    assert set(two.ring) == {(3, 4), (5, 4), (5, 5), (3, 5)}


def test_self_touching_regions_that_meet_at_a_corner_stay_apart():
    mask = np.zeros((40, 40), bool)
    mask[5:15, 5:15] = mask[15:25, 15:25] = True
    assert [polygon(area).area for area in areas(mask, PIXELS)] == [100, 100]


def test_self_touching_a_hole_that_meets_the_outside_at_a_corner_stays_a_hole():
    mask = np.zeros((12, 12), bool)
    mask[2:10, 2:10] = True
    mask[3:6, 3:6] = False
    mask[2, 2] = False
    (area,) = areas(mask, PIXELS)
    assert polygon(area).is_valid
    assert polygon(area).area == 64 - 9 - 1


def test_self_touching_rings_of_an_area():
    eight = Area(((0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0)))
    assert painted(eight).area == pytest.approx(2, abs=ROUNDING)
    crossing = Area(((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)))
    assert painted(crossing).area == pytest.approx(2, abs=ROUNDING)
    for area in (eight, crossing):
        assert painted(area).is_valid


@settings(STEADY, max_examples=100)
@given(st.floats(0, 2 * np.pi), st.floats(0.1, 1.9), st.floats(2.0, 3.9), st.floats(0.1, 4.5))
def test_self_touching_a_hole_along_a_side_of_its_ring_stays_a_hole(turn, left, right, depth):
    axes = np.array([(np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))])

    def turned(*corners):
        return tuple(map(tuple, (np.array(corners) @ axes).tolist()))

    ring = turned((0, 0), (4, 0), (4, 4), (0, 4))
    hole = turned((left, 0), (right, 0), (right, depth), (left, depth))
    # Turned, the sides all but coincide. Corners are moved to a grid of 1.5e-11 m, along some 20 m of outline.
    assert painted(Area(ring, (hole,))).area == pytest.approx(16 - (right - left) * min(depth, 4), abs=1e-9)
    assert painted(Area(ring, (ring,))).area < 1e-9


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
@pytest.mark.parametrize(
    ("path", "length"),
    [
        pytest.param(((0, 0), (2, 0)), 2, id="two points"),
        pytest.param(((0, 0), (1, 0), (2, 0), (0.5, 0)), 2, id="there and back"),
        pytest.param(((0, 0), (2, 0), (0, 0), (1, 0)), 2, id="twice the same"),
    ],
)
def test_self_touching_strokes_that_run_back_on_themselves_are_painted_once(path, length, closed):
    got = painted(Stroke(tuple((float(x), 0.6 * x + y) for x, y in path), 0.2, closed))
    assert got.is_valid
    # Turning back is a corner of 0°, which is cut off: no mitre.
    assert got.area == pytest.approx(0.2 * length * np.hypot(1, 0.6), abs=1e-9)


@settings(STEADY, max_examples=150)
@given(
    st.lists(st.tuples(st.integers(-2, 2), st.integers(-2, 2)), min_size=2, max_size=8),
    st.floats(0.02, 0.5),
    st.booleans(),
)
def test_self_touching_strokes_lose_no_side(points, width, closed):
    path = np.array(points, float)
    got = painted(Stroke(tuple(map(tuple, path.tolist())), width, closed))
    assert got.is_valid
    start, end = (path, np.roll(path, -1, 0)) if closed else (path[:-1], path[1:])
    length = np.hypot(*(end - start).T)
    start, end, length = start[length > 0], end[length > 0], length[length > 0]
    along = (end - start) / length[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], -1)
    for t in np.linspace(0.02, 0.98, 13):
        for side in (-0.49, -0.2, 0.2, 0.49):
            at = start + t * (end - start) + side * width * across
            assert shapely.contains_xy(got, *at.T).all()


@pytest.mark.parametrize("holes", [(), (((1.0, 1.0), (2.0, 1.0), (2.0, 3.0), (1.0, 3.0)),)], ids=["plain", "hole"])
def test_clockwise_rings_are_the_same_paint(holes):
    ring = ((0.0, 0.0), (4.0, 0.0), (3.0, 4.0), (0.5, 3.5))
    frame = Frame(90, 80, 10)
    wanted = coverage(painted(Area(ring, holes)), frame)
    for turned in (Area(ring[::-1], holes), Area(ring, tuple(hole[::-1] for hole in holes))):
        # Where coverage were signed by the order, it would be nought or clipped.
        np.testing.assert_allclose(coverage(painted(turned), frame), wanted, rtol=0, atol=1e-12)


def test_holes_and_islands_are_kept():
    mask = np.zeros((60, 60), bool)
    mask[5:55, 5:55] = True
    mask[15:45, 15:45] = False
    mask[25:35, 25:35] = True
    outer, inner = areas(mask, PIXELS)
    assert polygon(outer).area == 50 * 50 - 30 * 30
    assert len(outer.holes) == 1
    assert polygon(inner).area == 100


def test_holes_a_hole_without_extent_changes_nothing():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    got = painted(Area(ring, (((1.0, 1.0), (2.0, 2.0)), ())))
    assert got.symmetric_difference(box(0, 0, 4, 4)).area < ROUNDING


@pytest.mark.parametrize("inwards", [False, True], ids=["out", "in"])
def test_spikes_one_pixel_wide_keep_their_tip(inwards):
    mask = np.zeros((60, 90), bool)
    mask[10:50, 10:50] = True
    spike = np.s_[30, 12:50] if inwards else np.s_[30, 50:85]
    mask[spike] = not inwards
    (shape,) = outlines(mask)
    simple = simplified(shape)
    assert_sound(shape, simple)
    tip = shapely.Point(12, 30.5) if inwards else shapely.Point(85, 30.5)
    # The two corners of the tip lie half a pixel beside it, and may each move by the tolerance.
    assert simple.boundary.distance(tip) <= 0.5 + tolerance(shape)


def test_1e5_vertices():
    """A region with ragged one-pixel teeth, as a thresholded texture has them: one ring of 10⁵ corners."""
    teeth = np.random.default_rng(0).random((640, 640)) < 0.5
    mask = np.zeros((640, 640), bool)
    mask[1::4, 1:-1] = mask[1:-1, 1] = True
    mask[2::4] |= teeth[2::4]
    mask[:, -1] = mask[-1] = False
    (shape,) = outlines(mask)
    corners = shapely.get_num_coordinates(shape)
    assert corners > 1e5
    assert shape.area == mask.sum()
    assert_sound(shape, simplified(shape))
