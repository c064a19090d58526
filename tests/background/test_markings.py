from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from pavemark.background.ego import ego_car
from pavemark.background.markings import find_markings
from pavemark.ground import Frame

DATA = Path(__file__).parents[2] / "../shared/data/full"
RNG = np.random.default_rng(11)
WHITE, YELLOW = (170, 170, 165), (150, 125, 60)


def asphalt(frame: Frame, tone: float = 95.0) -> np.ndarray:
    """Grey ground with fine grain and light that falls off across the picture."""
    light = np.linspace(0.6, 1.4, frame.width)[None, :, None]
    grain = cv2.GaussianBlur(RNG.normal(0, 12, (frame.height, frame.width)), (0, 0), 1.0)[..., None]
    return np.clip(tone * light + grain, 0, 255)


def painted(frame: Frame, lines, colour) -> tuple[np.ndarray, np.ndarray]:
    image, truth = asphalt(frame), np.zeros((frame.height, frame.width), np.uint8)
    for start, end, width in lines:
        across = max(1, round(width * frame.scale))
        cv2.line(truth, *(tuple(int(x) for x in frame.to_image(p)) for p in (start, end)), 1, across)
    light = image / 95.0
    soft = cv2.GaussianBlur(truth.astype(float), (0, 0), 0.8)[..., None]
    mixed = image * (1 - soft) + np.array(colour, float) * light * soft
    return np.clip(np.rint(mixed), 0, 255).astype(np.uint8), truth > 0


def scores(found: np.ndarray, truth: np.ndarray, reach: float = 3.0) -> tuple[float, float]:
    """Precision and recall at a tolerance of `reach` pixels."""
    precision = (distance_transform_edt(~truth)[found] <= reach).mean() if found.any() else 0.0
    recall = (distance_transform_edt(~found)[truth] <= reach).mean() if found.any() else 0.0
    return precision, recall


@pytest.mark.parametrize("colour", [WHITE, YELLOW])
@pytest.mark.parametrize("frame", [Frame(300, 300, 60), Frame(96, 300, 1 / 0.044), Frame(400, 400, 100)])
def test_lines_are_found_where_they_are(frame, colour):
    x, y = (side / 2 for side in frame.size)
    lines = [
        ((-x, 0.4), (x, 0.7), 0.12),
        ((0.3 * x, -y), (0.1 * x, 0.5), 0.15),
        ((-0.9 * x, -y), (-0.5 * x, -0.5), 0.1),
    ]
    image, truth = painted(frame, lines, colour)
    found = find_markings(image, np.ones_like(truth), frame)
    precision, recall = scores(found, truth)
    assert precision > 0.95
    assert recall > 0.9
    # As wide as painted, to a quarter.
    assert found.sum() == pytest.approx(truth.sum(), rel=0.25)


def test_bare_ground_shadow_edges_and_soft_glare_hold_no_markings():
    frame = Frame(300, 300, 60)
    image = asphalt(frame)
    image[:, 150:] *= 0.5
    across = np.arange(300)[:, None, None]
    image *= 1 + 1.5 * np.exp(-(((across - 80) / 45) ** 2))
    assert not find_markings(np.clip(image, 0, 255).astype(np.uint8), np.ones((300, 300), bool), frame).any()


def test_bricks_are_not_lines():
    frame = Frame(300, 300, 60)
    image = asphalt(frame)
    image[::6] *= 0.8
    image[:, ::12] *= 0.8
    assert find_markings(image.astype(np.uint8), np.ones((300, 300), bool), frame).mean() < 0.01


def test_what_is_not_ground_is_not_searched():
    frame = Frame(300, 300, 60)
    image, truth = painted(frame, [((-2, 0), (2, 0), 0.15)], WHITE)
    ground = np.ones_like(truth)
    ground[:, :150] = False
    found = find_markings(image, ground, frame)
    assert not found[:, :150].any()
    assert found[truth & ground].mean() > 0.8


def test_the_smallest_image_is_searched():
    for frame in (Frame(8, 8, 60), Frame(8, 8, 1000), Frame(8, 8, 1)):
        assert find_markings(np.zeros((8, 8, 3), np.uint8), np.ones((8, 8), bool), frame).shape == (8, 8)


@pytest.mark.skipif(not DATA.exists(), reason="real images are not here")
@pytest.mark.parametrize("name", ["lane_0726_1736_0051", "lane_0727_1051_0157"])
def test_real_lines_are_found(name):
    image = np.ascontiguousarray(cv2.imread(str(DATA / f"{name}.jpg"))[..., ::-1])
    truth = cv2.imread(str(DATA / f"{name}_mask.jpg")).max(2) > 128
    frame = Frame(image.shape[1], image.shape[0], 60)
    ground = ~ego_car(image, frame)
    precision, recall = scores(find_markings(image, ground, frame), truth & ground)
    assert precision > 0.85
    assert recall > 0.9
