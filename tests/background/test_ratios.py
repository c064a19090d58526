from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.background.ratios import reflectance_ratios
from pavemark.ground import Frame

DATA = Path(__file__).parents[2] / "../shared/data/full"
FRAME = Frame(240, 200, 60)


def display(linear: np.ndarray) -> np.ndarray:
    """sRGB, written out once more: 8-bit levels of linear light."""
    return np.rint(255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)).astype(
        np.uint8
    )


def scene(light: np.ndarray, ratio=(2.0, 1.9, 1.5)):
    """Paint of a known ratio on ground of linear light (H, W): image, mask, hole."""
    mask = np.zeros((200, 240), bool)
    mask[60:70, 20:220] = True
    linear = light[..., None] * np.where(mask[..., None], np.array(ratio), 1.0)
    hole = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9))) > 0
    return display(np.clip(linear, 0, 1)), mask, hole


def measured(light, ground=None, **paint):
    image, mask, hole = scene(light, **paint)
    return reflectance_ratios(image, mask, hole, np.ones_like(mask) if ground is None else ground, FRAME)


def test_a_known_ratio_is_measured_in_linear_light():
    (ratio,) = measured(np.full((200, 240), 0.15))
    # 8-bit rounding of paint and ground is within 1 % here.
    assert ratio == pytest.approx((2.0, 1.9, 1.5), rel=0.01)


def test_a_line_that_runs_into_shadow_keeps_its_ratio():
    light = np.where(np.arange(240) < 140, 0.3, 0.06) * np.ones((200, 1))
    (ratio,) = measured(light)
    assert ratio == pytest.approx((2.0, 1.9, 1.5), rel=0.04)


def test_what_is_not_ground_is_no_reference():
    light = np.full((200, 240), 0.15)
    light[80:] = 0.9
    ground = np.ones((200, 240), bool)
    ground[80:] = False
    (ratio,) = measured(light, ground)
    assert ratio == pytest.approx((2.0, 1.9, 1.5), rel=0.01)


def test_saturated_paint_darkness_and_specks_tell_nothing():
    assert measured(np.full((200, 240), 0.9)) == ()
    assert measured(np.full((200, 240), 0.001)) == ()
    image, mask, hole = scene(np.full((200, 240), 0.15))
    mask[:, 26:] = False
    assert reflectance_ratios(image, mask, hole, np.ones_like(mask), FRAME) == ()


def test_each_marking_has_its_own():
    light = np.full((200, 240), 0.15)
    image, mask, hole = scene(light)
    other = np.zeros_like(mask)
    other[120:130, 20:220] = True
    image[other] = display(np.array(0.45))
    hole |= cv2.dilate(other.astype(np.uint8), np.ones((9, 9))) > 0
    ratios = reflectance_ratios(image, mask | other, hole, np.ones_like(mask), FRAME)
    assert np.array(ratios) == pytest.approx(np.array([(2.0, 1.9, 1.5), (3.0, 3.0, 3.0)]), rel=0.01)


@pytest.mark.skipif(not DATA.exists(), reason="real images are not here")
def test_real_paint_in_a_dim_garage():
    image = cv2.imread(str(DATA / "psv_4220.jpg"))[..., ::-1]
    mask = cv2.imread(str(DATA / "psv_4220_mask.png"), cv2.IMREAD_UNCHANGED) > 0
    hole = cv2.dilate(mask.astype(np.uint8), np.ones((15, 15))) > 0
    ratios = np.array(reflectance_ratios(image, mask, hole, image.max(2) > 12, Frame(1000, 1000, 100)))
    assert len(ratios) == 5
    assert ratios.min() > 1.3
    assert ratios.max() < 3.3


def test_white_on_a_green_floor_is_measured_as_white():
    image, mask, hole = scene(np.full((200, 240), 0.15), ratio=(2.0, 2.0, 2.0))
    floor = display(np.array((0.02, 0.2, 0.05)))
    image[~mask] = floor
    (ratio,) = reflectance_ratios(image, mask, hole, np.ones_like(mask), FRAME)
    luminance = 0.3 / (0.2126 * 0.02 + 0.7152 * 0.2 + 0.0722 * 0.05)
    assert np.dot(ratio, (0.2126, 0.7152, 0.0722)) == pytest.approx(luminance, rel=0.12)
    assert max(ratio) / min(ratio) < 1.7  # to the floor itself it would be 10
