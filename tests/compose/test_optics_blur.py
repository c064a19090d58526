"""Measured blur against known blur, and the blur given to decals against scipy's."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
from scipy.ndimage import gaussian_filter

from pavemark.compose import optics
from pavemark.geometry.coverage import coverage
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Optics

DATA = Path(__file__).parents[2] / "../shared/data"


def plate(image):
    height, width = image.shape[:2]
    everywhere = np.ones((height, width), bool)
    return Plate("p", Frame(width, height), image, everywhere, ~everywhere, image)


def lines(size=300):
    """Coverage of 15 cm lines at many angles."""
    frame = Frame(size, size)
    rng = np.random.default_rng(3)
    total = np.zeros((size, size))
    for angle in np.linspace(0, 3 * np.pi, 27, endpoint=False):
        centre = rng.uniform(-2.4, 2.4, 2)
        along = np.array([np.cos(angle), np.sin(angle)])
        shape = shapely.buffer(
            shapely.LineString([centre - 0.5 * along, centre + 0.5 * along]), 0.075, cap_style="flat"
        )
        total = np.maximum(total, coverage(shapely.geometry.polygon.orient(shape), frame))
    return total


def picture(blur, noise=0.0):
    grey = 90 + 110 * blur(lines())
    grey = grey[..., None] + np.random.default_rng(0).normal(0, noise, (*grey.shape, 3))
    return plate(np.clip(np.rint(grey), 0, 255).astype(np.uint8))


@pytest.mark.parametrize("noise", [0.0, 3.0])
@pytest.mark.parametrize("sigma", [0.5, 0.8, 1.2, 1.8])
def test_a_known_blur_is_measured(sigma, noise):
    found = np.array(optics.measure(picture(lambda c: gaussian_filter(c, sigma), noise)))
    assert found.shape == (6, 6)
    # Lines of 9 px: their two edges overlap a little at the largest blur.
    assert np.median(found) == pytest.approx(sigma, abs=0.06)


def test_blur_is_measured_where_it_is():
    def blur(c):
        half = np.arange(c.shape[1]) < c.shape[1] / 2
        return np.where(half, gaussian_filter(c, 0.6), gaussian_filter(c, 1.8))

    found = np.array(optics.measure(picture(blur)))
    assert np.median(found[:, 0]) == pytest.approx(0.6, abs=0.15)
    assert np.median(found[:, -1]) == pytest.approx(1.8, abs=0.15)


@pytest.mark.parametrize("noise", [0.0, 5.0])
def test_a_picture_without_edges_tells_nothing(noise):
    grey = 100 + np.random.default_rng(0).normal(0, noise, (200, 200, 3))
    assert optics.measure(plate(np.rint(grey).astype(np.uint8))) == ((optics.UNKNOWN,),)


def test_edges_of_what_is_not_ground_do_not_count():
    image = np.full((200, 200, 3), 120, np.uint8)
    image[60:140, 80:120] = 0
    ground = image[..., 0] > 0
    car = Plate("p", Frame(200, 200), image, ground, np.zeros_like(ground), image)
    assert optics.measure(car) == ((optics.UNKNOWN,),)


def test_the_grid_follows_the_picture_s_shape():
    found = optics.measure(plate(picture(lambda c: gaussian_filter(c, 1.0)).image[:, 100:196]))
    assert len(found) == 6
    assert len(found[0]) == 3


def decals():
    rng = np.random.default_rng(0)
    image = np.zeros((90, 120, 4), np.float32)
    image[30:36, 0:80] = (2.2, 2.0, 1.8, 1)
    image[60:90, 50:70] = rng.uniform(0.2, 1, (30, 20, 4))
    return image


@pytest.mark.parametrize("sigma", [0.7, 1.3])
def test_a_constant_blur_is_a_gaussian(sigma):
    found = optics.apply(Layers(decals()), Optics(((sigma, sigma), (sigma, sigma)))).decals
    wanted = np.stack([gaussian_filter(c, sigma, mode="nearest", truncate=6) for c in np.moveaxis(decals(), -1, 0)], -1)
    # OpenCV ends its kernel at 4 sigma.
    assert np.abs(found - wanted).max() < 2e-3


def test_no_blur_is_the_identity():
    np.testing.assert_array_equal(optics.apply(Layers(decals()), Optics(((0.0,),))).decals, decals())


def test_a_varying_blur_widens_as_it_should():
    """The width of a thin line's profile, as a standard deviation, at every place along it."""
    image = np.zeros((61, 300, 4), np.float32)
    image[30] = 1
    found = optics.apply(Layers(image), Optics(((0.5, 2.5),))).decals[..., 3]
    at = np.arange(61)[:, None] - 30
    width = np.sqrt((found * at**2).sum(0) / found.sum(0))[10:-10]
    wanted = (0.5 + 2.0 * (np.arange(300) + 0.5) / 300)[10:-10]
    # A sampled Gaussian of half a pixel is a little narrower than its name.
    assert np.abs(width - wanted).max() < 0.05
    assert np.abs(width - wanted)[wanted > 1].max() < 0.015


def test_paint_does_not_change_its_colour_by_blur():
    found = optics.apply(Layers(decals()), Optics(((0.5, 2.5),))).decals[20:46]
    seen = found[..., 3] > 1e-3
    np.testing.assert_allclose(
        found[seen][:, :3] / found[seen][:, 3:], np.broadcast_to((2.2, 2.0, 1.8), (seen.sum(), 3)), rtol=1e-3
    )


def test_layers_without_paint_stay():
    empty = Layers(np.zeros((40, 40, 4), np.float32))
    assert not optics.apply(empty, Optics(((1.0,),))).decals.any()


@pytest.mark.skipif(not DATA.exists(), reason="real images are not here")
@pytest.mark.parametrize(("name", "low", "high"), [("lane_0726_1736_0051", 0.5, 1.0), ("psv_4220", 1.3, 2.3)])
def test_real_pictures_measure_as_their_lines_do(name, low, high):
    """An error function fitted to their line edges gives medians of 0.9 and 2.1 px, the pixel's own blur included."""
    image = cv2.cvtColor(cv2.imread(str(DATA / f"full/{name}.jpg")), cv2.COLOR_BGR2RGB)
    ground = cv2.morphologyEx((image.max(2) > 6).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((7, 7))) > 0
    real = Plate(name, Frame(image.shape[1], image.shape[0]), image, ground, ~ground, image)
    assert low < np.median(optics.measure(real)) < high
