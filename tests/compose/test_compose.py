"""The steps together, brightness, noise, colour."""

import hashlib

import attrs
import cv2
import numpy as np
import pytest
from scipy import stats

from pavemark.colour import to_display, to_linear
from pavemark.compose import brightness, noise
from pavemark.compose.image import compose
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.scene import Blend, Brightness, Marking, Noise, Optics, Paint, Scene, Stroke

FRAME = Frame(120, 90)
PAINT = Paint(rgb=(230, 230, 225), ratio=(2.2, 2.2, 2.1))
LINE = Marking("slot", PAINT, strokes=(Stroke(((-0.5, 0), (0.5, 0)), 0.1),))


@pytest.fixture
def plate():
    rng = np.random.default_rng(0)
    image = np.clip(rng.normal(100, 10, (90, 120, 3)), 0, 255).astype(np.uint8)
    return Plate("p", FRAME, image, np.ones((90, 120), bool), np.zeros((90, 120), bool), image)


@pytest.fixture
def layers():
    decals = np.zeros((90, 120, 4), np.float32)
    decals[42:48, 30:90] = (2.2, 2.2, 2.1, 1)
    return Layers(decals)


def run(plate, layers, **effects):
    scene = Scene(0, plate.ref, **effects)
    return compose(scene, plan(scene), plate, layers)


def test_a_scene_without_steps_is_its_plate(plate):
    image = run(plate, None)
    assert image.dtype == np.uint8
    np.testing.assert_array_equal(image, plate.image)


def test_steps_not_listed_are_not_run(plate, layers, monkeypatch):
    for module in (brightness, noise):
        monkeypatch.setattr(module, "apply", None)
    image = run(plate, layers, markings=(LINE,), blend=Blend())
    assert (image != plate.image).any(-1)[42:48, 30:90].mean() > 0.9
    np.testing.assert_array_equal(image[:39], plate.image[:39])


def test_optics_softens_the_paint_before_it_is_blended(plate, layers):
    flat = attrs.evolve(plate, image=np.full_like(plate.image, 96))
    effects = {"markings": (LINE,), "blend": Blend(margin=4)}
    sharp = run(flat, layers, **effects)[:, 60, 0].astype(int)
    soft = run(flat, layers, **effects, optics=Optics(((1.2,),)))[:, 60, 0].astype(int)
    assert np.abs(np.diff(soft)).max() < 0.5 * np.abs(np.diff(sharp)).max()
    assert soft[44] == pytest.approx(sharp[44], abs=3)


def test_there_is_one_rounding_at_the_end(plate):
    dark = run(plate, None, brightness=Brightness(0.3), noise=Noise("gaussian", 0.4, 5))
    rng = np.random.Generator(np.random.PCG64(5))
    exact = plate.image * 0.3 + 0.4 * rng.standard_normal(plate.image.shape, np.float32)
    assert np.abs(dark - exact).max() <= 0.5 + 1e-3  # float32 at 255 is exact to 1.5e-5


def test_everything_on_repeats_to_the_bit_and_depends_on_the_seed(plate, layers):
    effects = {
        "markings": (LINE,),
        "optics": Optics(((0.5, 1.5),)),
        "blend": Blend(edge_blur=True),
        "brightness": Brightness(1.3),
        "noise": Noise("laplacian", 4, 7),
    }
    first, second = (hashlib.sha256(run(plate, layers, **effects).tobytes()).hexdigest() for _ in range(2))
    assert first == second
    effects["noise"] = attrs.evolve(effects["noise"], seed=8)
    assert hashlib.sha256(run(plate, layers, **effects).tobytes()).hexdigest() != first


def test_srgb_is_exact_both_ways():
    levels = np.arange(256, dtype=np.uint8)
    assert np.abs(to_display(to_linear(levels)) - levels).max() < 1e-9
    # Published values: 50 % display is 21.4 % light, and the knee lies at 0.04045 of the display.
    assert to_linear(np.uint8(188)) == pytest.approx(0.502886, abs=1e-6)
    assert to_linear(np.uint8(10)) == pytest.approx(10 / 255 / 12.92)


@pytest.mark.parametrize("factor", [0.5, 0.8, 1.2])
def test_brightness_scales_the_levels(factor):
    image = np.random.default_rng(0).uniform(0, 200, (40, 40, 3)).astype(np.float32)
    np.testing.assert_allclose(brightness.apply(image, Brightness(factor)), image * factor, rtol=1e-6)


@pytest.mark.parametrize(
    ("kind", "law"),
    [("gaussian", stats.norm(scale=6)), ("laplacian", stats.laplace(scale=6 / np.sqrt(2)))],
)
def test_noise_has_the_law_and_deviation_asked_for(kind, law):
    image = np.full((200, 200, 3), 128, np.float32)
    added = noise.apply(image, Noise(kind, 6, 3)) - image
    # 120,000 draws: the deviation is known to 0.4 %, the mean to 0.02 levels.
    assert added.std() == pytest.approx(6, rel=0.02)
    assert abs(added.mean()) < 0.08
    assert stats.kstest(added.ravel(), law.cdf).pvalue > 0.01
    assert abs(np.corrcoef(added[..., 0].ravel(), added[..., 1].ravel())[0, 1]) < 0.02


@pytest.mark.parametrize("edge_blur", [False, True])
@pytest.mark.parametrize("method", ["reflectance", "normal", "mixed", "alpha"])
def test_what_stands_in_front_cuts_the_paint_to_the_pixel(plate, method, edge_blur):
    """A round pillar, a slanted bumper, a post of one pixel: soft paint, made softer, ends where they begin."""
    v, u = np.mgrid[:90, :120]
    things = ((u - 60) ** 2 + (v - 45) ** 2 < 150) | (u + 0.7 * v < 55) | ((u == 90) & (v > 20) & (v < 70))
    on = attrs.evolve(plate, ground=~things)
    alpha = np.clip(1.3 - np.abs(v - 45) / 6, 0, 1)[..., None]
    paint = np.array((2.2, 2.2, 2.1)) if method == "reflectance" else to_linear(np.array([230, 230, 225], np.uint8))
    soft = Layers(np.concatenate([alpha * paint, alpha], -1).astype(np.float32))
    effects = {"blend": Blend(method=method, edge_blur=edge_blur), "optics": Optics(((1.8,),))}
    image = run(on, soft, markings=(LINE,), **effects)
    np.testing.assert_array_equal(image[things], on.image[things])
    # Right beside them there is paint: the cut is not a wide berth.
    beside = (cv2.dilate(things.astype(np.uint8), np.ones((3, 3))) > 0) & ~things & (np.abs(v - 45) < 3)
    assert (image[beside].astype(int) - on.image[beside]).mean() > 25
