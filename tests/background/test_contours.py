import math

import cv2
import numpy as np
import pytest
import shapely
from shapely import affinity

from pavemark.background.contours import areas, outlines, simplified, tolerance
from pavemark.ground import Frame, homography

IMAGE = np.diag([1.0, 1.0, 1.0])
RNG = np.random.default_rng(2)


def raster(shape, size: int = 160) -> np.ndarray:
    """The pixels whose centres, at k + 0.5, lie in the shape."""
    u, v = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    return shapely.contains_xy(shape, u, v)


def polygon(area) -> shapely.Polygon:
    return shapely.Polygon(area.ring, area.holes)


def test_the_outline_of_a_pixel_runs_around_it():
    mask = np.zeros((20, 30), bool)
    mask[3:8, 10:25] = True
    (area,) = areas(mask, IMAGE)
    assert set(area.ring) == {(10.0, 3.0), (25.0, 3.0), (25.0, 8.0), (10.0, 8.0)}


def test_a_frame_maps_to_metres():
    mask = np.zeros((600, 600), bool)
    mask[300:360, 300:420] = True
    (area,) = areas(mask, Frame().matrix)
    assert polygon(area).equals_exact(shapely.box(0, -1, 2, 0).normalize(), 1e-9) or (
        polygon(area).symmetric_difference(shapely.box(0, -1, 2, 0)).area < 1e-9
    )


@pytest.mark.parametrize("seed", range(40))
def test_thin_strokes_keep_their_shape_and_no_vertex_leaves_the_outline(seed):
    rng = np.random.default_rng(seed)
    width, length = rng.uniform(3, 10), rng.uniform(50, 110)
    stroke = affinity.rotate(
        shapely.box(-length / 2, -width / 2, length / 2, width / 2), rng.uniform(0, 180), origin=(0, 0)
    )
    stroke = affinity.translate(stroke, *(80 + rng.uniform(-1, 1, 2)))
    (shape,) = outlines(raster(stroke))
    simple = simplified(shape)
    assert simple.is_valid
    assert shape.hausdorff_distance(simple) <= tolerance(shape) + 1e-9
    assert tolerance(shape) <= width / 2
    assert abs(simple.area - shape.area) <= 0.05 * shape.area
    assert len(simple.exterior.coords) <= len(shape.exterior.coords)
    # One pixel of the grid, and at the ends a quarter of the width.
    assert simple.hausdorff_distance(stroke) < 1 + width / 4


def test_compact_shapes_take_one_percent_of_their_contour():
    (shape,) = outlines(raster(shapely.Point(80, 80).buffer(60)))
    assert tolerance(shape) == pytest.approx(0.01 * shape.length)
    simple = simplified(shape)
    assert len(simple.exterior.coords) < 30
    assert shape.hausdorff_distance(simple) <= 0.01 * shape.length


def test_outlines_agree_with_opencv_on_random_masks():
    mask = cv2.GaussianBlur(RNG.normal(0, 1, (120, 120)), (0, 0), 3) > 0.02
    _, _, statistics, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    shapes = outlines(mask)
    assert sorted(shape.area for shape in shapes) == sorted(statistics[1:, cv2.CC_STAT_AREA])
    assert all(area >= 0 for area in (polygon(area).area for area in areas(mask, IMAGE)))


def test_a_homography_maps_the_outline():
    mask = np.zeros((100, 100), bool)
    mask[20:80, 20:80] = True
    corners = np.array([[20, 20], [80, 20], [80, 80], [20, 80]], float)
    target = np.array([[-1, 2], [1.5, 2.2], [2, -1], [-1.2, -1.1]])
    (area,) = areas(mask, homography(corners, target))
    assert all(min(math.dist(point, wanted) for point in area.ring) < 1e-9 for wanted in target)
