import cv2
import numpy as np
import pytest

from networks import KINDS, network
from pavemark.background import contracts, models
from pavemark.background.inpainting.crops import CONTEXT, filled_in_crops, windows
from pavemark.background.inpainting.learned import Learned
from pavemark.errors import InputError
from pavemark.onnx import opened

EVERY = pytest.mark.parametrize("kind", KINDS)


@pytest.fixture
def learned(tmp_path, monkeypatch):
    """A function that writes a graph of a kind, records it and gives its inpainter."""
    monkeypatch.setenv("PAVEMARK_MODELS", str(tmp_path / "models"))

    def make(kind, fill="mean", **changes):
        return Learned(models.add(network(tmp_path / "net.onnx", fill=fill, **KINDS[kind] | changes), None, None, ()))

    return make


@pytest.fixture
def unproven(tmp_path):
    """The same, of graphs that no trial has seen."""

    def make(kind, fill="mean", **changes):
        file = network(tmp_path / "net.onnx", fill=fill, **KINDS[kind] | changes)
        digest, white = opened(file).sha256, KINDS[kind]["white"]
        return Learned(models.Model(name="net", file=str(file), sha256=digest, bytes=1, contract=kind, white=white))

    return make


def ground(height, width):
    return np.random.default_rng(5).integers(100, 121, (height, width, 3)).astype(np.uint8)


def stripe(height, width):
    hole = np.zeros((height, width), bool)
    hole[height // 2 : height // 2 + 6, 1:-1] = True
    return hole


def nowhere(hole):
    return np.zeros_like(hole)


@EVERY
def test_range_polarity_and_channels_are_those_of_the_kind(learned, kind):
    image, hole = ground(70, 90), stripe(70, 90)
    image[hole] = 255
    before = image.copy()
    clean = learned(kind, (0.8, 0.4, 0.2)).fill(image, hole, nowhere(hole))
    assert (clean[hole] == (204, 102, 51)).all()
    assert np.array_equal(clean[~hole], image[~hole])
    assert np.array_equal(image, before)


@EVERY
def test_what_is_white_and_more_is_white(learned, kind):
    image, hole = np.full((40, 50, 3), 255, np.uint8), stripe(40, 50)
    brighter = (1.0, 1.0, 1.0) if kind == "migan" else (1.02, 1.5, 1.0)
    assert (learned(kind, brighter).fill(image, hole, nowhere(hole)) == 255).all()


def test_a_lama_of_either_range_is_told_by_a_trial(learned):
    image, hole = ground(40, 50), stripe(40, 50)
    for kind in ("lama-512", "lama-dynamic"):
        for white in (1.0, 255.0):
            inpainter = learned(kind, (0.8, 0.4, 0.2), white=white)
            assert inpainter.model.white == white
            assert (inpainter.fill(image, hole, nowhere(hole))[hole] == (204, 102, 51)).all()
            models.remove("net")


@EVERY
def test_no_paint_is_shown_to_the_network(learned, kind, monkeypatch):
    # A graph that fills nothing is not recorded otherwise.
    monkeypatch.setattr(contracts, "BLACK", 0)
    # The graph gives back what lies under the hole: black, or, for MI-GAN, which blends its fill into it, ground.
    image, hole = ground(70, 90), stripe(70, 90)
    image[hole] = 255
    clean = learned(kind, "shown").fill(image, hole, nowhere(hole))[hole]
    assert (clean.min(), clean.max()) == (100, 120) if kind == "migan" else (clean == 0).all()


@EVERY
def test_what_is_kept_out_is_not_seen_and_stays(learned, kind):
    image, hole = ground(60, 90), stripe(60, 90)
    keep_out = nowhere(hole)
    keep_out[:, 40:60] = True
    image[hole], image[keep_out] = 255, 0
    clean = learned(kind).fill(image, hole, keep_out)
    assert not clean[keep_out].any()
    assert np.abs(clean[hole & ~keep_out].astype(int) - 110).max() <= 2


@EVERY
@pytest.mark.parametrize("outside", ["image", "fill"])
def test_nothing_outside_the_hole_is_changed_whatever_the_network_gives(unproven, kind, outside):
    image, hole = ground(70, 90), stripe(70, 90)
    keep_out = nowhere(hole)
    keep_out[:, :30] = True
    clean = unproven(kind, (0.0, 1.0, 0.0), outside=outside).fill(image, hole, keep_out)
    wanted = hole & ~keep_out
    assert np.array_equal(clean[~wanted], image[~wanted])
    assert (clean[wanted] == (0, 255, 0)).all()


@EVERY
@pytest.mark.parametrize("shape", [(8, 8), (8, 300), (13, 9), (101, 67), (96, 300), (513, 520)])
@pytest.mark.parametrize("where", ["one pixel", "corner pixel", "every border", "all but a corner"])
def test_images_of_any_size_and_holes_anywhere(learned, kind, shape, where):
    image, hole = ground(*shape), np.zeros(shape, bool)
    if where == "every border":
        hole[:2] = hole[-2:] = hole[:, :2] = hole[:, -2:] = True
    else:
        hole[{"one pixel": (5, 5), "corner pixel": (-1, 0), "all but a corner": ...}[where]] = True
        hole[:5, -5:] &= where != "all but a corner"
    image[hole] = 255
    if where == "all but a corner" and shape == (513, 520) and kind in ("lama-512", "migan"):
        with pytest.raises(ValueError, match="512×512 px are nothing but hole"):
            learned(kind).fill(image, hole, nowhere(hole))
        return
    clean = learned(kind).fill(image, hole, nowhere(hole))
    assert np.array_equal(clean[~hole], image[~hole])
    # 25 pixels of noise are the fewest that are left.
    assert np.abs(clean[hole].astype(int) - 110).max() <= 6


@EVERY
def test_an_empty_hole_gives_a_copy_and_a_full_one_is_refused(learned, kind):
    inpainter, image, empty = learned(kind), ground(20, 20), np.zeros((20, 20), bool)
    clean = inpainter.fill(image, empty, ~empty)
    assert np.array_equal(clean, image) and clean is not image
    with pytest.raises(ValueError, match="no pixel is left"):
        inpainter.fill(image, ~empty, empty)
    with pytest.raises(ValueError, match="no pixel is left"):
        inpainter.fill(image, stripe(20, 20), ~stripe(20, 20))


@EVERY
def test_a_wider_image_is_not_squeezed(learned, kind):
    """The graph fills with the column's number: in one crop it rises by 0.255 levels a pixel, never by more."""
    image, hole = ground(40, 500), stripe(40, 500)
    row = learned(kind, "across").fill(image, hole, nowhere(hole))[23, :, 0].astype(float)
    inside = np.arange(1, 499)
    assert np.abs(row[1:-1] - 255 * (inside + 1) / 1000).max() <= 0.51


@EVERY
def test_crops_of_other_light_leave_no_step(learned, kind):
    """The graph fills with a crop's mean. Across a ramp of 150 levels neighbouring crops differ by 35 to 50 levels."""
    image = np.empty((60, 1500, 3), np.uint8)
    image[:] = np.linspace(50, 200, 1500)[:, None]
    hole = stripe(60, 1500)
    row = learned(kind).fill(image, hole, nowhere(hole))[33, 1:-1, 0].astype(int)
    assert row[-1] - row[0] >= 70
    assert np.abs(np.diff(row)).max() <= 4
    # Most of the hole is a single crop's, not a mixture.
    assert (np.diff(row) == 0).mean() >= 0.8


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "migan"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_network_without_numbers_is_an_error(unproven, kind, value):
    inpainter = unproven(kind, (0.5, value, 0.5))
    with pytest.raises(InputError, match=r"net\.onnx: .*no finite numbers"):
        inpainter.fill(ground(40, 50), stripe(40, 50), np.zeros((40, 50), bool))


@EVERY
def test_a_network_of_another_size_than_it_says_is_an_error(unproven, kind):
    with pytest.raises(InputError, match=r"net\.onnx: \w+ has the shape \[1, 3, \d+, \d+\]: \[1, 3, \d+, \d+\] is"):
        unproven(kind, halved=True).fill(ground(40, 50), stripe(40, 50), np.zeros((40, 50), bool))


@EVERY
def test_same_input_same_bytes_with_one_thread(learned, kind):
    inpainter = learned(kind)
    image, hole = ground(64, 64), stripe(64, 64)
    first = inpainter.fill(image, hole, nowhere(hole))
    inpainter.fill(ground(50, 700), stripe(50, 700), np.zeros((50, 700), bool))
    assert np.array_equal(inpainter.fill(image, hole, nowhere(hole)), first)
    options = opened(inpainter.model.file)._session.get_session_options()
    assert (options.intra_op_num_threads, options.inter_op_num_threads) == (1, 1)


def blob(shape, seed):
    coarse = np.random.default_rng(seed).random((shape[0] // 40 + 2, shape[1] // 40 + 2))
    noise = cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)
    return noise > np.quantile(noise, 0.8)


@pytest.mark.parametrize("shape", [(600, 600), (1000, 1000), (300, 1400), (513, 512), (8, 2000)])
@pytest.mark.parametrize("seed", range(3))
def test_every_pixel_of_a_hole_is_in_a_crop_with_its_context(shape, seed):
    hole = blob(shape, seed)
    found = windows(hole, 512)
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    well = np.zeros(shape, bool)
    for down, across in found:
        assert 0 <= down.start < down.stop <= shape[0] and 0 <= across.start < across.stop <= shape[1]
        assert (down.stop - down.start, across.stop - across.start) == (min(512, shape[0]), min(512, shape[1]))
        high = ((rows >= down.start + CONTEXT) | (down.start == 0)) & (
            (rows < down.stop - CONTEXT) | (down.stop == shape[0])
        )
        wide = ((columns >= across.start + CONTEXT) | (across.start == 0)) & (
            (columns < across.stop - CONTEXT) | (across.stop == shape[1])
        )
        well |= high & wide
    assert well[hole].all()
    # Hardly more than a plain grid has.
    grid = np.prod([-(-max(side - 2 * CONTEXT, 1) // (512 - 2 * CONTEXT)) for side in shape])
    assert len(found) <= 1.2 * grid


def test_a_small_hole_has_one_crop_with_the_hole_in_its_middle():
    hole = np.zeros((1000, 1200), bool)
    hole[400:420, 700:740] = True
    assert windows(hole, 512) == [(slice(154, 666), slice(464, 976))]
    assert windows(np.zeros_like(hole), 512) == []


def test_the_fills_of_crops_are_weighted_to_one():
    hole = blob((700, 1100), 0)
    image = np.zeros((700, 1100, 3), np.uint8)
    clean = filled_in_crops(image, hole, 512, lambda image, hole: np.full(image.shape, 77.4))
    assert (clean[hole] == 77).all() and not clean[~hole].any()


def test_the_texture_of_one_crop_is_kept_but_in_the_passage():
    """The mean of two noises has 0.7 of their contrast, that of the four crops that overlap here half."""
    hole = np.zeros((600, 600), bool)
    hole[100:500] = True
    rng = np.random.default_rng(1)
    image = np.zeros((600, 600, 3), np.uint8)
    clean = filled_in_crops(image, hole, 512, lambda image, hole: rng.normal(128, 20, image.shape))[hole]
    assert clean.std() >= 0.9 * 20
