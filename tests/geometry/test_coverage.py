"""Coverage against shapely's area of each pixel's intersection with the shape."""

import numpy as np
import pytest
import shapely
from shapely.geometry import MultiPolygon, Polygon, box

from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import polygons
from pavemark.ground import Frame

FRAME = Frame(13, 10, 4.0)
V, U = np.mgrid[: FRAME.height, : FRAME.width]
PIXELS = shapely.box(U, V, U + 1, V + 1)

# Each pixel sums a few dozen products of coordinates up to 1e3 px: 1e-10 leaves room for their rounding.
ROUNDING = 1e-10


def reference(shape):
    """Area of each pixel's intersection with a shape in image coordinates."""
    return shapely.area(shapely.intersection(shape, PIXELS))


def covered(shape, frame=FRAME):
    """Coverage of a shape given in image coordinates."""
    return coverage(polygons(shapely.transform(shape, frame.to_world)), frame)


def assert_exact(shape):
    # Shares below 1e-9 count as none; hence the wider tolerance.
    np.testing.assert_allclose(covered(shape), reference(shape), rtol=0, atol=2e-9)


def star(rng, centre, radius, corners, snap):
    turns = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = radius * rng.uniform(0.2, 1, corners)
    ring = centre + np.stack([np.cos(turns), np.sin(turns)], -1) * reach[:, None]
    return polygons(shapely.make_valid(Polygon(np.round(ring) if snap else ring)))


@pytest.mark.parametrize("snap", [False, True])
@pytest.mark.parametrize("seed", range(40))
def test_random_polygons(seed, snap):
    rng = np.random.default_rng(seed)
    shape = star(rng, rng.uniform(-4, 16, 2), 10 ** rng.uniform(-0.5, 2), rng.integers(3, 12), snap)
    assert_exact(shape)


@pytest.mark.parametrize("seed", range(20))
def test_unions_with_holes(seed):
    rng = np.random.default_rng(seed)
    shape = shapely.union_all([star(rng, rng.uniform(0, 12, 2), 5, 7, False) for _ in range(4)])
    for _ in range(3):
        shape = shape.difference(star(rng, rng.uniform(0, 12, 2), 2, 6, False))
    assert_exact(polygons(shape))


@pytest.mark.parametrize(
    "shape",
    [
        box(2, 3, 5, 7),
        box(2.25, 3.5, 2.75, 3.75),
        box(-3, 2.5, 4.5, 4.5),
        box(9.5, 2.5, 20, 4.5),
        box(3.5, -4, 4.5, 2.5),
        box(3.5, 8.5, 4.5, 30),
        box(-5, -5, 50, 50),
        Polygon([(-1e4, -1e4), (1e4, -1e4 + 3), (1e4, 1e4)]),
        Polygon([(0.1, 0.1), (12.9, 0.1004), (12.9, 0.1008)]),
        Polygon([(0, 0), (13, 10), (13, 9.999), (0.001, 0)]),
        MultiPolygon([box(0, 0, 2, 2), box(2, 2, 4, 4)]),
        box(1, 1, 9, 9).difference(box(2.2, 2.2, 8.8, 8.8)),
        box(-2, -2, 15, 12).difference(box(3.25, 3.25, 5.5, 20)),
    ],
    ids=lambda shape: shape.wkt[:40],
)
def test_single_cases(shape):
    assert_exact(shape)


def test_nothing_covers_nothing():
    assert not coverage(MultiPolygon(), FRAME).any()


def test_sum_is_the_area():
    rng = np.random.default_rng(5)
    shape = star(rng, np.array((6.3, 5.1)), 4.5, 40, False)
    assert covered(shape).sum() == pytest.approx(shape.area, abs=ROUNDING)


def test_whole_pixels_shift_exactly():
    # Quarters are exact in binary, so not a bit may differ.
    rng = np.random.default_rng(6)
    ring = np.round(rng.uniform(8, 24, (9, 2)) * 4) / 4
    shape = polygons(shapely.convex_hull(shapely.linestrings(ring)))
    frame = Frame(64, 48, 4.0)
    moved = shapely.transform(shape, lambda points: points + np.array((17, 11)))
    np.testing.assert_array_equal(covered(moved, frame)[11:, 17:], covered(shape, frame)[:-11, :-17])


def test_complement():
    rng = np.random.default_rng(7)
    shape = star(rng, np.array((6, 5)), 6, 15, False)
    rest = polygons(box(-1, -1, 14, 11).difference(shape))
    np.testing.assert_allclose(covered(shape) + covered(rest), 1.0, rtol=0, atol=2e-9)


def test_shape_does_not_depend_on_the_frame_around_it():
    shape = Polygon([(-0.9, -0.8), (1.1, -0.4), (0.2, 0.9)])
    small, large = Frame(16, 16, 5.0), Frame(32, 48, 5.0)
    np.testing.assert_allclose(coverage(shape, large)[16:32, 8:24], coverage(shape, small), rtol=0, atol=ROUNDING)
