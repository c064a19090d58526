from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.background.ego import ego_car
from pavemark.ground import Frame

DATA = Path(__file__).parents[2] / "../shared/data/full"
RNG = np.random.default_rng(5)
FULL, HALF = Frame(), Frame(96, 300, 1 / 0.044)


def garage(frame: Frame, tone: float, noise: float = 3.0) -> np.ndarray:
    image = RNG.normal(tone, noise, (frame.height, frame.width, 3))
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def through_jpeg(image: np.ndarray) -> np.ndarray:
    return cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])[1], cv2.IMREAD_COLOR)


@pytest.mark.parametrize(
    ("frame", "car"),
    [
        (FULL, np.s_[170:430, 245:355]),
        (HALF, np.s_[115:230, 84:]),
        (HALF, np.s_[115:230, :12]),
        (HALF, np.s_[115:230, :3]),
    ],
)
@pytest.mark.parametrize("tone", [25, 150])
def test_the_car_is_found_with_its_soft_edge(frame, car, tone):
    image = garage(frame, tone)
    image[car] = 0
    expected = np.zeros(image.shape[:2], np.uint8)
    expected[car] = 1
    found = ego_car(through_jpeg(image), frame)
    assert not (expected.astype(bool) & ~found).any()
    assert not (found & (cv2.dilate(expected, np.ones((11, 11))) == 0)).any()


@pytest.mark.parametrize("tone", [0, 8, 15, 30, 150])
def test_no_car_in_a_picture_without_one(tone):
    assert not ego_car(garage(FULL, tone), FULL).any()
    assert not ego_car(garage(HALF, tone), HALF).any()


def test_shadows_and_parked_black_cars_are_not_the_ego_car():
    image = garage(HALF, 120)
    # Noise is what tells a deep shadow at the border from the patch that no camera sees.
    image[110:200, :30] = garage(Frame(30, 90, 20), 14)
    assert not ego_car(image, HALF).any()
    parked = garage(HALF, 120)
    cv2.ellipse(parked, (0, 150), (32, 45), 0, 0, 360, (2, 2, 2), -1)
    cv2.ellipse(parked, (0, 190), (14, 60), 0, 0, 360, (2, 2, 2), -1)
    parked[90:215, 88:] = 0
    found = ego_car(parked, HALF)
    assert found[:, 90:].any()
    assert not found[:, :60].any()


def test_a_small_black_thing_at_the_centre_is_not_a_car():
    image = garage(FULL, 120)
    image[280:320, 280:320] = 0
    assert not ego_car(image, FULL).any()


@pytest.mark.skipif(not DATA.exists(), reason="real images are not here")
@pytest.mark.parametrize(
    ("name", "scale", "share"),
    [("ps2_161", 60, 0.068), ("psv_4220", 100, 0.069), ("spfcn_demo", 60, 0.069), ("lane_0727_1051_0157", 60, 0.198)],
)
def test_the_car_in_real_images(name, scale, share):
    image = cv2.imread(str(DATA / f"{name}.jpg"))[..., ::-1]
    frame = Frame(image.shape[1], image.shape[0], scale)
    found = ego_car(image, frame)
    assert found.mean() == pytest.approx(share, rel=0.03)
    assert found[frame.height // 2, frame.width // 2]
