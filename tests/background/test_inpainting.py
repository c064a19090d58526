import cv2
import numpy as np
import pytest

from pavemark.background.inpainting import METHODS, inpainter
from pavemark.errors import InputError

RNG = np.random.default_rng(3)
EVERY = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def paving(height: int, width: int) -> np.ndarray:
    """Grey ground, levels 90 to 150, with joints every 12 pixels."""
    image = RNG.integers(110, 150, (height, width, 3)).astype(np.uint8)
    image[::12] = image[:, ::12] = 90
    return image


def stripe(height: int, width: int) -> np.ndarray:
    hole = np.zeros((height, width), bool)
    hole[height // 3 : height // 3 + 6] = True
    return hole


@EVERY
def test_the_paint_is_gone_and_nothing_else_is_changed(method):
    image, hole = paving(80, 90), stripe(80, 90)
    image[hole] = 255
    before = image.copy()
    clean = method.fill(image, hole, np.zeros_like(hole))
    assert np.array_equal(image, before)
    assert np.array_equal(clean[~hole], image[~hole])
    assert clean[hole].max() <= 170
    assert clean[hole].min() >= 70


@EVERY
def test_channels_keep_their_places(method):
    image = np.full((40, 50, 3), (180, 90, 30), np.uint8)
    hole = stripe(40, 50)
    image[hole] = 255
    # Frequency selection and its colour conversion round by a few levels.
    assert np.abs(method.fill(image, hole, np.zeros_like(hole)).astype(int) - (180, 90, 30)).max() <= 4


@EVERY
def test_what_is_kept_out_does_not_bleed_in_and_stays(method):
    image, hole = paving(60, 90), stripe(60, 90)
    keep_out = np.zeros_like(hole)
    keep_out[:, 40:60] = True
    image[keep_out] = 0
    clean = method.fill(image, hole, keep_out)
    assert not clean[keep_out].any()
    assert clean[hole & ~keep_out].min() >= 70


@EVERY
def test_same_input_same_bytes(method):
    image, hole = paving(64, 64), stripe(64, 64)
    first = method.fill(image, hole, np.zeros_like(hole))
    method.fill(paving(50, 70), stripe(50, 70), np.zeros((50, 70), bool))
    assert np.array_equal(method.fill(image, hole, np.zeros_like(hole)), first)


@EVERY
@pytest.mark.parametrize("shape", [(1, 2), (8, 8), (9, 30), (100, 13), (100, 101)])
@pytest.mark.parametrize("where", ["left", "bottom", "all but a corner"])
def test_holes_at_the_border_of_images_of_any_size_are_filled_with_ground(method, shape, where):
    image = RNG.integers(100, 121, (*shape, 3)).astype(np.uint8)
    hole = np.zeros(shape, bool)
    hole[{"left": np.s_[:, :1], "bottom": np.s_[-5:, 1:], "all but a corner": np.s_[:]}[where]] = True
    hole[0, -1] = False
    if where == "all but a corner":
        hole[: max(1, shape[0] // 3), -max(1, shape[1] // 3) :] = False
    image[hole] = 255
    clean = method.fill(image, hole, np.zeros(shape, bool))
    assert np.array_equal(clean[~hole], image[~hole])
    if hole.any():
        assert clean[hole].max() <= 135
        assert clean[hole].min() >= 85


@EVERY
def test_an_empty_hole_gives_a_copy(method):
    image = paving(20, 20)
    clean = method.fill(image, np.zeros((20, 20), bool), np.ones((20, 20), bool))
    assert np.array_equal(clean, image)
    assert clean is not image


@EVERY
def test_a_hole_without_any_source_is_refused(method):
    hole = stripe(20, 20)
    with pytest.raises(ValueError, match="no pixel is left"):
        method.fill(paving(20, 20), hole, ~hole)


@EVERY
def test_the_number_of_threads_does_not_matter(method):
    image, hole = paving(64, 64), stripe(64, 64)
    threads, results = cv2.getNumThreads(), []
    for count in (1, 3):
        cv2.setNumThreads(count)
        results.append(method.fill(image, hole, np.zeros_like(hole)))
    cv2.setNumThreads(threads)
    assert np.array_equal(*results)


def test_methods_go_by_name():
    assert inpainter("patchmatch").name == "patchmatch"
    with pytest.raises(InputError, match="'lama': allowed patchmatch, fsr, navier-stokes"):
        inpainter("lama")
