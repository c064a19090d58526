"""The camera's electronics meter, tint and blur the way their parameters say, and repeat to the bit."""

import attrs
import numpy as np
import pytest

from pavemark.cameras import sensor

PLAIN = sensor.Sensor(0.2, (1.0, 1.0, 1.0), 0.0, 0.0, 0.0, 0.0, 0.0, 100, 1)


def _develop(light, electronics):
    return sensor.develop(light.astype(np.float32), np.ones(light.shape[:2], bool), electronics)


@pytest.mark.parametrize("brightness", [0.01, 1.0, 50.0])
def test_exposure_brings_any_light_to_the_target(brightness):
    picture = _develop(np.full((64, 64, 3), brightness), PLAIN)
    # sRGB of 0.2 is 123.6.
    assert np.abs(picture.astype(float) - 124).max() <= 1


def test_exposure_is_metered_on_the_part_in_use():
    light = np.full((64, 64, 3), 0.1, np.float32)
    light[:32] = 5.0
    used = np.zeros((64, 64), bool)
    used[32:] = True
    assert abs(int(sensor.develop(light, used, PLAIN)[50, 50, 1]) - 124) <= 1


def test_balance_tints_and_the_rim_is_darker():
    light = np.full((64, 64, 3), 1.0)
    red = _develop(light, attrs.evolve(PLAIN, balance=(1.2, 1.0, 0.8)))[32, 32].astype(int)
    assert red[0] > red[1] + 5 > red[2] + 10
    dim = _develop(light, attrs.evolve(PLAIN, vignette=0.5))
    assert dim[32, 32, 1] > dim[32, 2, 1] + 20


def test_sharpening_draws_halos():
    light = np.full((64, 64, 3), 0.1)
    light[:, 32:] = 0.4
    flat, sharp = (_develop(light, attrs.evolve(PLAIN, sharpen=s))[32, :, 1].astype(int) for s in (0.0, 1.2))
    assert sharp.min() < flat.min() - 5 and sharp.max() > flat.max() + 5


def test_the_same_seed_makes_the_same_picture():
    noisy = sensor.sample(np.random.default_rng(4), 2.0, 0.2)
    assert noisy == sensor.sample(np.random.default_rng(4), 2.0, 0.2)
    light = np.random.default_rng(5).uniform(0, 1, (48, 48, 3))
    assert np.array_equal(_develop(light, noisy), _develop(light, noisy))
    assert not np.array_equal(_develop(light, noisy), _develop(light, attrs.evolve(noisy, seed=noisy.seed + 1)))
