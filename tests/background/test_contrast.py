"""Even contrast: pale lines stand out, however large the picture, and hues stay."""

import cv2
import numpy as np
import pytest

from pavemark.background.contrast import evened


def floor(height, width, scale, paler, seed=0):
    """A brown floor with grain, and a vertical line of 0.15 m on it, lighter by so many levels."""
    grain = np.random.default_rng(seed).normal(0, 2, (height, width, 1))
    image = np.array([120, 95, 80]) + grain
    line = np.zeros((height, width), bool)
    middle, half = width // 2, max(1, round(0.075 * scale))
    line[:, middle - half : middle + half] = True
    image[line] += paler
    return np.clip(image, 0, 255).round().astype(np.uint8), line


def stands_out(image, line):
    """By how much the line is lighter than the floor beside it."""
    near = cv2.dilate(line.astype(np.uint8), np.ones((1, 25))) > line
    lightness = image.mean(-1)
    return lightness[line].mean() - lightness[near].mean()


@pytest.mark.parametrize(("height", "width", "scale"), [(600, 600, 60), (300, 96, 22.7), (1000, 1000, 100)])
def test_a_pale_line_stands_out(height, width, scale):
    image, line = floor(height, width, scale, 8)
    assert stands_out(evened(image, scale), line) > 1.8 * stands_out(image, line)


def test_contrast_grows_no_more_than_the_limit_allows():
    image, line = floor(600, 600, 60, 8)
    before, less, more = (stands_out(each, line) for each in (image, evened(image, 60, 1.5), evened(image, 60, 4)))
    assert before < less < more < 5 * before


def test_a_hue_stays():
    image, _ = floor(300, 300, 60, 8)
    before, after = (cv2.cvtColor(each, cv2.COLOR_RGB2LAB)[..., 1:].astype(int) for each in (image, evened(image, 60)))
    assert np.abs(np.median(before - after, (0, 1))).max() <= 1


@pytest.mark.parametrize("size", [(1, 1), (8, 300), (300, 8), (33, 47)])
def test_any_size_will_do(size):
    image = np.random.default_rng(1).integers(0, 255, (*size, 3), dtype=np.uint8)
    found = evened(image, 60)
    assert found.shape == image.shape and found.dtype == np.uint8
    assert np.array_equal(evened(np.ascontiguousarray(image[::-1])[::-1], 60), found), "any memory layout"
