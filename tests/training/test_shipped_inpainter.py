"""The inpainter that ships, run by onnxruntime alone: what it takes, what it gives, and that it has learnt."""

import hashlib
import re

import cv2
import numpy as np
import pytest

from pavemark import assets

onnxruntime = pytest.importorskip("onnxruntime")

SIZES = [(8, 8), (8, 104), (96, 304), (304, 96), (200, 328), (600, 600)]


@pytest.fixture(scope="module")
def session():
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(assets.path("models/inpainter.onnx"), options, ["CPUExecutionProvider"])


def fill(session, image, hole):
    """Fill an image (H, W, 3) with values from 0 to 1 in a hole (H, W) bool."""
    feeds = {"image": image.transpose(2, 0, 1)[None].astype(np.float32), "mask": hole[None, None].astype(np.float32)}
    return session.run(["filled"], feeds)[0][0].transpose(1, 2, 0)


def ground(height, width, seed=0):
    """Grey asphalt, brighter to the right, with a dark joint every 24 pixels across."""
    rng = np.random.default_rng(seed)
    grain = cv2.GaussianBlur(rng.standard_normal((height, width)).astype(np.float32), (0, 0), 1.0)
    level = 0.4 + 0.2 * np.arange(width) / width + 0.03 * grain / grain.std()
    level = level * np.where(np.arange(height) % 24 < 3, 0.6, 1.0)[:, None]
    return (level[..., None] * (1.0, 0.97, 0.92)).astype(np.float32)


def band(height, width):
    """A hole 14 pixels wide from top to bottom, and one across."""
    hole = np.zeros((height, width), bool)
    hole[:, width // 2 - 7 : width // 2 + 7] = True
    hole[height // 3 : height // 3 + 14, : width // 2] = True
    return hole


def test_it_is_small_and_says_what_it_is(session):
    path = assets.path("models/inpainter.onnx")
    assert path.stat().st_size <= 6_000_000
    assert session.get_modelmeta().custom_metadata_map["pavemark"] == "inpainter 1"
    ports = {port.name: (port.type, port.shape[:2]) for port in (*session.get_inputs(), *session.get_outputs())}
    assert ports == {
        "image": ("tensor(float)", [1, 3]),
        "mask": ("tensor(float)", [1, 1]),
        "filled": ("tensor(float)", [1, 3]),
    }


def test_its_hash_is_told():
    told = assets.path("models/README.md").read_text()
    digest = hashlib.sha256(assets.path("models/inpainter.onnx").read_bytes()).hexdigest()
    assert re.search(rf"inpainter.onnx[^#]*{digest}", told)


@pytest.mark.parametrize("size", SIZES)
def test_it_changes_the_hole_alone_at_every_size(session, size):
    image, hole = np.random.default_rng(1).random((*size, 3), np.float32), np.zeros(size, bool)
    hole[2:-2, 1:6] = True
    filled = fill(session, image, hole)
    assert filled.shape == image.shape
    assert np.isfinite(filled).all() and filled.min() >= 0 and filled.max() <= 1
    assert np.array_equal(filled[~hole], image[~hole])
    assert (filled[hole] != image[hole]).mean() > 0.9


@pytest.mark.parametrize("level", [0.0, 1.0])
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_flat_pictures_and_masks_that_are_all_or_nothing_give_numbers(session, level, share):
    image = np.full((48, 64, 3), level, np.float32)
    filled = fill(session, image, np.full((48, 64), share > 0))
    assert np.isfinite(filled).all() and filled.min() >= 0 and filled.max() <= 1
    if not share:
        assert np.array_equal(filled, image)


def test_flat_ground_stays_flat(session):
    image = np.full((96, 128, 3), (0.5, 0.4, 0.3), np.float32)
    assert np.abs(fill(session, image, band(96, 128)) - image).max() < 3 / 255


def test_paint_in_the_hole_does_not_matter(session):
    image, hole = ground(96, 304), band(96, 304)
    painted = np.where(hole[..., None], 1.0, image)
    assert np.array_equal(fill(session, image, hole)[hole], fill(session, painted, hole)[hole])


def test_shading_goes_on(session):
    image, hole = ground(192, 256), band(192, 256)
    filled = fill(session, image, hole)
    for columns in (np.s_[0:24], np.s_[48:72], np.s_[96:120]):
        made, true = (picture[64:78, columns].mean() for picture in (filled, image))
        # A joint that lies in the hole from end to end cannot be known: it is a twelfth of the light.
        assert abs(made / true - 1) < 0.12
    # From the first columns to the last, the ground grows brighter by a fifth.
    assert filled[64:78, 96:120].mean() > 1.1 * filled[64:78, 0:24].mean()


def test_a_fill_has_texture(session):
    image, hole = ground(192, 256), band(192, 256)
    energy = [
        (picture - cv2.GaussianBlur(picture, (0, 0), 2.0))[40:60, 121:135].std()
        for picture in (fill(session, image, hole), image)
    ]
    assert 0.3 < energy[0] / energy[1] < 1.5


def test_joints_are_dark_in_the_hole(session):
    image, hole = ground(192, 256), band(192, 256)
    hole[64:78, :121] = False
    column = fill(session, image, hole)[:, 121:135].mean((1, 2))
    joint = np.arange(192) % 24 < 3
    assert column[joint].mean() < 0.85 * column[~joint].mean()


def test_the_same_input_gives_the_same_bits(session):
    image, hole = ground(104, 152), band(104, 152)
    assert np.array_equal(fill(session, image, hole), fill(session, image, hole))


@pytest.mark.parametrize("period", [4, 8])
def test_fills_have_no_lattice(session, period):
    """Such networks tend to dots every few pixels: a detector would see by them where markings have been."""
    rng = np.random.default_rng(4)
    grain = cv2.GaussianBlur(rng.standard_normal((256, 256)), (0, 0), 0.8)
    image = np.repeat((0.4 + 0.05 * grain / grain.std())[..., None], 3, -1).astype(np.float32)
    hole = np.zeros((256, 256), bool)
    hole[:, 96:128] = True
    filled = fill(session, image, hole)[:, 96:128].mean(-1)
    fine = filled - cv2.GaussianBlur(filled, (0, 0), 2.0)
    cells = fine.reshape(256 // period, period, 32 // period, period).mean((0, 2))
    by_chance = fine.std() / np.sqrt(fine.size / period**2)
    assert cells.std() < 3 * by_chance
