"""The network's pictures are brought to its scale and back, in one piece or many; its answers are checked."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from pavemark import assets
from pavemark.accuracy.markings import compare
from pavemark.background import segmenter
from pavemark.background.finding import SEGMENTERS, classes
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.onnx import opened

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "assets/demo"
REAL = ROOT / "../shared/data/full"
SCALES = {"images": 60.0, "half/images": 1 / 0.044}


def _graph(path, said="segmenter 1", factor=1.0):
    """A graph whose probabilities are the red and the green channel, times a factor."""
    nodes = [
        helper.make_node("Gather", ["image", "first"], ["both"], axis=1),
        helper.make_node("Mul", ["both", "factor"], ["probability"]),
    ]
    constants = [
        numpy_helper.from_array(np.array([0, 1]), "first"),
        numpy_helper.from_array(np.array(factor, np.float32), "factor"),
    ]
    ports = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, channels, "h", "w"])
        for name, channels in (("image", 3), ("probability", 2))
    ]
    graph = helper.make_graph(nodes, "g", ports[:1], ports[1:], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, {"pavemark": said})
    path.write_bytes(model.SerializeToString())
    return path


@pytest.fixture
def red_and_green(tmp_path, monkeypatch):
    network = opened(_graph(tmp_path / "segmenter.onnx"))
    monkeypatch.setattr(segmenter, "network", lambda: network)
    monkeypatch.setattr(segmenter, "evened", lambda image, scale: image)


def _smooth(height, width):
    v, u = np.mgrid[0:height, 0:width]
    red = 127 + 100 * np.sin(u / 60) * np.cos(v / 70)
    return np.dstack([red, 255 - red, np.zeros_like(red)]).astype(np.uint8)


@pytest.mark.parametrize(("height", "width", "scale"), [(300, 96, 22.7), (8, 300, 60), (333, 217, 60), (500, 500, 100)])
def test_probabilities_lie_where_their_pixels_do(red_and_green, height, width, scale):
    image = _smooth(height, width)
    found = segmenter.segment(image, Frame(width, height, scale))
    assert found.marking.shape == found.ground.shape == (height, width)
    # Bringing a smooth picture to another scale and back costs a level or two.
    assert np.abs(found.marking - image[..., 0] / 255).max() < 0.02
    assert np.abs(found.ground - image[..., 1] / 255).max() < 0.02


def test_pale_is_what_shows_where_contrast_is_even(red_and_green, monkeypatch):
    image, frame = np.full((96, 96, 3), 90, np.uint8), Frame(96, 96, 60)
    monkeypatch.setattr(segmenter, "evened", lambda image, scale: image + np.uint8(scale))
    found = segmenter.segment(image, frame)
    assert np.allclose(found.pale, 150 / 255, atol=0.01)
    assert np.allclose(found.marking, 90 / 255, atol=0.01)
    assert np.allclose(found.ground, 90 / 255, atol=0.01)
    assert np.array_equal(found.ground, segmenter.likely_ground(image, frame))


def test_pale_pieces_count_where_no_marking_is(red_and_green, monkeypatch):
    """A line beside; what makes a found one wider, a stain, and what lies where there is no ground do not."""
    image = np.zeros((120, 120, 3), np.uint8)
    image[:, :100, 1] = 255
    image[20:26, 10:60, 0] = 255
    even = image.copy()
    even[14:32, 10:60, 0] = even[70:78, 10:60, 0] = even[60:119, 106:118, 0] = even[100:110, 40:50, 0] = 255
    monkeypatch.setattr(segmenter, "evened", lambda image, scale: even)
    found = SEGMENTERS["network"].find(image, Frame(120, 120, 48))
    assert found.marking[72:76, 15:55].all(), "pale, beside"
    assert found.marking[22:24, 15:55].all() and not found.marking[28:31].any(), "not wider"
    assert not found.marking[:, 104:].any() and not found.marking[95:].any()


def test_pieces_do_not_show(red_and_green, monkeypatch):
    image, frame = _smooth(400, 500), Frame(500, 400, 48)
    whole = segmenter.segment(image, frame).marking
    monkeypatch.setattr(segmenter, "TILE", 96)
    monkeypatch.setattr(segmenter, "MARGIN", 32)
    assert np.array_equal(segmenter.segment(image, frame).marking, whole)


@pytest.mark.parametrize(("said", "told"), [("inpainter 1", "is not a segmenter")])
def test_another_model_in_its_place_is_refused(tmp_path, monkeypatch, said, told):
    monkeypatch.setattr(assets, "path", lambda name: _graph(tmp_path / "segmenter.onnx", said))
    with pytest.raises(InputError, match=told):
        segmenter.segment(_smooth(64, 64), Frame(64, 64, 48))


@pytest.mark.parametrize("damage", ["truncated", "nan"])
def test_a_damaged_model_is_refused(tmp_path, monkeypatch, damage):
    path = _graph(tmp_path / "segmenter.onnx", factor=np.nan if damage == "nan" else 1.0)
    if damage == "truncated":
        path.write_bytes(path.read_bytes()[:100])
    monkeypatch.setattr(assets, "path", lambda name: path)
    with pytest.raises(InputError, match=r"segmenter\.onnx"):
        segmenter.segment(_smooth(64, 64), Frame(64, 64, 48))


def test_a_mask_wins_over_the_network(red_and_green, tmp_path):
    """Red everywhere says marking, green says ground on the left: the mask's marking and no other counts."""
    image = np.full((120, 120, 3), (255, 0, 0), np.uint8)
    image[:, :60] = (255, 255, 0)
    mask = np.zeros((120, 120), np.uint8)
    mask[50:60] = 1
    cv2.imwrite(str(tmp_path / "mask.png"), mask)
    frame = Frame(120, 120, 48)
    found = classes(image, tmp_path / "mask.png", MaskTable(), SEGMENTERS["network"], frame)
    assert (found.marking == (mask == 1)).all()
    assert found.ground[:, :58].all() and found.ground[mask == 1].all() and not found.ground[:45, 65:].any()
    told = classes(image, tmp_path / "mask.png", MaskTable(ground=(0,)), SEGMENTERS["network"], frame)
    assert told.ground.all() and (told.marking == (mask == 1)).all()


def test_without_a_mask_markings_lie_on_found_ground(red_and_green):
    image = np.zeros((120, 120, 3), np.uint8)
    image[:, :60, 1] = 255
    image[50:60, :, 0] = 255
    image[5, 5, 0] = 255
    found = classes(image, None, MaskTable(), SEGMENTERS["network"], Frame(120, 120, 48))
    assert found.marking[52:58, :55].all() and not found.marking[:, 65:].any()
    assert not found.marking[:20].any(), "a speck is no marking"


def _demo():
    for folder, scale in SCALES.items():
        for path in sorted((DEMO / folder).glob("*.jpg")):
            yield pytest.param(path, scale, id=path.stem)


@pytest.mark.parametrize(("path", "scale"), list(_demo()))
def test_markings_of_the_demo_images_are_found(path, scale):
    """They were made by another renderer, and nothing was learnt from them."""
    image = cv2.imread(str(path))[..., ::-1]
    mask = cv2.imread(str(path.parent.parent / "masks" / f"{path.stem}.png"), cv2.IMREAD_UNCHANGED)
    frame = Frame(image.shape[1], image.shape[0], scale)
    found = SEGMENTERS["network"].find(image, frame)
    if (mask == 1).any():
        assert compare(found.marking, mask == 1).f1 > LEAST.get(path.stem, 0.75)
    else:
        assert found.marking.mean() < 0.02
    assert not (found.marking & ~found.ground).any()


# Yellow on light concrete, old paint on patches, bricks.
LEAST = {"concrete_yellow": 0.6, "patched_open": 0.38, "brick_slanted": 0.68}


@pytest.mark.parametrize("size", [(8, 300), (300, 8), (33, 47), (8, 8)])
def test_any_size_will_do(size):
    image = np.random.default_rng(1).integers(0, 255, (*size, 3), dtype=np.uint8)
    found = segmenter.segment(image, Frame(size[1], size[0], 60))
    assert found.marking.shape == size and np.isfinite(found.marking).all() and np.isfinite(found.ground).all()


def test_the_model_is_small_and_says_what_it_is():
    path = assets.path(segmenter.MODEL)
    assert path.stat().st_size <= 5_000_000
    assert opened(path).metadata["licence"] == "GPL-3.0-or-later"


@pytest.mark.skipif(not REAL.is_dir(), reason="real images are not here")
def test_markings_of_a_real_image_are_found():
    image = cv2.imread(str(REAL / "lane_0727_1051_0157.jpg"))[..., ::-1]
    mask = cv2.imread(str(REAL / "lane_0727_1051_0157_mask.jpg")).max(-1) > 127
    found = SEGMENTERS["network"].find(image, Frame(image.shape[1], image.shape[0], 60.0))
    assert compare(found.marking, mask).f1 > 0.9
