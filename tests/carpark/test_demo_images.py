"""The shipped demo images and their masks belong together."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from blender_addon.carpark.demo import VIEWS

DEMO = Path(__file__).parents[2] / "assets" / "demo"
BY_NAME = {view.name: view for view in VIEWS}


def _pair(name):
    folder = DEMO / BY_NAME[name].folder
    image = cv2.imread(str(folder / "images" / f"{name}.jpg"), cv2.IMREAD_COLOR)
    mask = cv2.imread(str(folder / "masks" / f"{name}.png"), cv2.IMREAD_UNCHANGED)
    return image, mask


def _contrast(grey, mask):
    """How much brighter the markings are than the ground within 8 px, in levels."""
    marking = (mask == 1).astype(np.uint8)
    near = cv2.dilate(marking, np.ones((17, 17))) - cv2.dilate(marking, np.ones((5, 5)))
    return grey[marking == 1].mean() - grey[(near == 1) & (mask == 0)].mean()


def _shifted(mask, right, down):
    return cv2.warpAffine(
        mask, np.float32([[1, 0, right], [0, 1, down]]), mask.shape[::-1], flags=cv2.INTER_NEAREST, borderValue=2
    )


def test_every_view_is_shipped_and_small():
    for folder in (".", "half"):
        names = {view.name for view in VIEWS if view.folder == folder}
        for kind in ("images", "masks"):
            assert {path.stem for path in (DEMO / folder / kind).iterdir()} == names
    assert sum(path.stat().st_size for path in DEMO.rglob("*") if path.is_file()) <= 2.5e6


@pytest.mark.parametrize("name", BY_NAME)
def test_sizes_and_mask_values(name):
    image, mask = _pair(name)
    assert image.shape == ((300, 96, 3) if BY_NAME[name].half else (600, 600, 3))
    assert mask.shape == image.shape[:2] and mask.dtype == np.uint8
    assert set(np.unique(mask)) <= {0, 1, 2}
    assert (mask == 1).any() == bool(BY_NAME[name].rows)
    # The blacked-out car is not ground. JPEG leaves a few levels of ringing in the black.
    black = cv2.erode((image.max(-1) <= 6).astype(np.uint8), np.ones((9, 9))) == 1
    assert black.any() and (mask[black] == 2).all()


@pytest.mark.parametrize("name", [view.name for view in VIEWS if view.rows])
def test_markings_lie_where_the_mask_says(name):
    image, mask = _pair(name)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(float)
    here = _contrast(grey, mask)
    assert here > 5
    step = 2 if BY_NAME[name].half else 3
    for shift in ((step, 0), (-step, 0), (0, step), (0, -step)):
        assert _contrast(grey, _shifted(mask, *shift)) < here, shift
