"""Light on the finished ground: by how much each effect changes it, where, and nowhere else."""

import math

import attrs
import numpy as np
import pytest

from pavemark.colour import to_display, to_linear
from pavemark.compose import light
from pavemark.compose.glare import gleam
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.light import Glare, Lamp, Relief, Shadows, Sun, Tube, Wet
from scenes import plate

FRAME = Frame(40, 30, 10)
PLATE = plate(FRAME, tone=120, texture=5, car=(1.0, 1.0))
IMAGE = PLATE.image.astype(np.float32)
EYES = ((0.0, -1.0, 0.9),)


def linear(image):
    return to_linear(image.astype(np.float64))


def test_a_shadow_leaves_its_share_of_the_light_of_each_channel():
    seen = np.ones((30, 40, 1), np.float32)
    seen[:10] = 0.0
    seen[10:15] = 0.25
    effect = Shadows((0.3, 0.4, 0.5), sun=Sun(0.0, 0.5))
    shaded = light.shadows(IMAGE, PLATE, Layers(shadows=seen), effect)
    share = np.array([0.3, 0.4, 0.5])
    on = PLATE.ground
    dark, half = on.copy(), on.copy()
    dark[10:], half[:10], half[15:] = False, False, False
    np.testing.assert_allclose(linear(shaded)[dark], share * linear(IMAGE)[dark], rtol=1e-4)
    np.testing.assert_allclose(linear(shaded)[half], (share + (1 - share) / 4) * linear(IMAGE)[half], rtol=1e-4)
    np.testing.assert_array_equal(shaded[15:], IMAGE[15:])
    np.testing.assert_array_equal(shaded[~on], IMAGE[~on])


def test_the_shadow_of_a_lamp_fades_with_the_light_that_it_takes_away():
    lamp = Lamp((-1.0, 0.5, 3.0), 0.1)
    effect = Shadows((0.4,) * 3, lamp=lamp)
    shaded = light.shadows(IMAGE, PLATE, Layers(shadows=np.zeros((30, 40, 1), np.float32)), effect)
    v, u = 3, 35
    x, y = FRAME.to_world(np.array([u + 0.5, v + 0.5]))
    # The inverse square, and the cosine of the angle from the vertical, against straight below.
    away = math.dist((x, y, 0.0), lamp.place)
    direct = (3.0 / away) ** 2 * (3.0 / away)
    wanted = 0.4 / (0.4 + 0.6 * direct)
    assert linear(shaded)[v, u] / linear(IMAGE)[v, u] == pytest.approx([wanted] * 3, rel=1e-4)


def test_relief_shows_where_there_is_paint_and_by_the_suns_share():
    decals = np.zeros((30, 40, 4), np.float32)
    decals[5:10, 4:20, 3] = 1.0
    rims = np.full((30, 40, 1), 1.5, np.float32)
    effect = Relief(0.004, 0.004, Sun(0.0, 1.0), left=0.25)
    lit = light.relief(IMAGE, PLATE, Layers(decals=decals, relief=rims), effect)
    np.testing.assert_allclose(linear(lit)[5:10, 4:15], 1.375 * linear(IMAGE)[5:10, 4:15], rtol=1e-4)
    # 4 mm of paint shade 2.6 mm, a pixel at the most.
    np.testing.assert_array_equal(lit[13:], IMAGE[13:])
    half = attrs.evolve(Layers(decals=decals / 2, relief=rims))
    worn = light.relief(IMAGE, PLATE, half, effect)
    np.testing.assert_allclose(linear(worn)[5:10, 4:15], 1.1875 * linear(IMAGE)[5:10, 4:15], rtol=1e-4)


def test_wet_ground_is_darker_and_gleams():
    layer = np.zeros((30, 40, 4), np.float32)
    layer[:5] = (0.05, 0.06, 0.07, 1.0)
    layer[5:8] = (0.025, 0.03, 0.035, 0.5)
    effect = Wet(0.5, 0.5, 1.0, 0.4, (1.0,) * 3, (0.1,) * 3, 0.2, EYES, 1.0)
    wet = linear(light.wet(IMAGE, PLATE, Layers(wet=layer), effect))
    np.testing.assert_allclose(wet[:5], 0.6 * linear(IMAGE)[:5] + (0.05, 0.06, 0.07), rtol=1e-4)
    np.testing.assert_allclose(wet[5:8], 0.8 * linear(IMAGE)[5:8] + (0.025, 0.03, 0.035), rtol=1e-4)
    np.testing.assert_array_equal(wet[8:], linear(IMAGE)[8:])


def test_glare_is_added_and_runs_into_white_channel_by_channel():
    effect = Glare((Tube((0.4, 1.2, 2.5), 1.2, 0.2, 0.3, (900.0, 300.0, 6.0)),), 0.15, 0.05, EYES)
    added = gleam(FRAME, effect, PLATE.ground)
    bright = light.glare(IMAGE, PLATE, effect)
    wanted = to_display(np.minimum(linear(IMAGE) + added, 1.0))
    np.testing.assert_allclose(bright[PLATE.ground], wanted[PLATE.ground], atol=0.05)
    np.testing.assert_array_equal(bright[~PLATE.ground], IMAGE[~PLATE.ground])
    assert (bright[..., 0] > 254.99).any() and bright[..., 2].max() < 255


def test_black_and_white_ground_stay_in_range():
    for tone in (0, 255):
        ground = plate(FRAME, tone=tone)
        image = ground.image.astype(np.float32)
        seen = np.zeros((30, 40, 1), np.float32)
        shaded = light.shadows(image, ground, Layers(shadows=seen), Shadows((0.0,) * 3, sun=Sun(0.0, 0.5)))
        assert (shaded == 0).all()
        effect = Glare((Tube((0.4, 1.2, 2.5), 1.2, 0.2, 0.3, (900.0,) * 3),), 0.15, 0.05, EYES)
        bright = light.glare(image, ground, effect)
        assert np.isfinite(bright).all() and bright.min() >= 0 and bright.max() > 254.99
