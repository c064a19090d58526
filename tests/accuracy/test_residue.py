import cv2
import numpy as np
import pytest

from pavemark.accuracy.holes import around
from pavemark.accuracy.residue import BINS, residue
from pavemark.ground import Frame

FRAME = Frame(240, 240, 60.0)
RNG = np.random.default_rng(21)
GROUND = np.ones((240, 240), bool)


def asphalt() -> np.ndarray:
    """Display levels (240, 240, 3) float: grain, and light that falls off to one side."""
    grain = cv2.GaussianBlur(RNG.normal(0, 14, (240, 240, 3)), (0, 0), 0.8)
    return 90 + grain + np.linspace(-20, 20, 240)[None, :, None]


BARE = asphalt()
MARKING = np.zeros((240, 240), bool)
MARKING[30:200, 60:66] = True
MARKING[90:96, 60:130] = True
SOFT = cv2.GaussianBlur(MARKING.astype(float), (0, 0), 0.8)[..., None]


def image(levels: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def painted(share: float, colour=(200, 200, 195)) -> np.ndarray:
    """The ground with so much of the paint on it."""
    return image(BARE + share * SOFT * (np.array(colour) - BARE))


BEFORE = painted(1.0)


def measured(after, before=BEFORE, marking=MARKING, ground=GROUND):
    return residue(before, after, marking, ground, FRAME)


def test_paint_itself_is_a_trace_beyond_doubt():
    found = measured(BEFORE)
    assert found.left == pytest.approx(found.paint, rel=0.1)
    assert found.z > 10
    assert found.auc == 1.0
    assert found.rim > 0.5


def test_where_nothing_is_left_nothing_is_found():
    found = measured(image(BARE))
    assert abs(found.left) < 0.5
    assert abs(found.z) < 1
    assert 0.35 < found.auc < 0.65
    assert abs(found.worst) < 1
    assert abs(found.rim) < 0.5
    assert 0.85 < found.texture < 1.15


@pytest.mark.parametrize(("share", "least"), [(0.03, 0.65), (0.1, 0.98)])
def test_a_share_of_the_paint_is_a_share_of_the_contrast(share, least):
    # The finest part is lost in the grain, but not in the mean over the stroke.
    clean, found = measured(image(BARE)), measured(painted(share))
    assert found.left - clean.left == pytest.approx(share * found.paint, rel=0.25)
    assert found.auc > least


def test_a_dark_streak_has_the_other_sign():
    found = measured(painted(-0.1))
    assert found.left < -2
    assert found.auc < 0.05


def test_yellow_is_looked_for_where_paint_was_yellow():
    before = painted(1.0, (170, 140, 40))
    left = painted(0.1, (170, 140, 40))
    found = measured(left, before)
    assert found.left == pytest.approx(0.1 * found.paint, rel=0.35)
    # As bright as the ground, but yellow: in lightness alone nothing would be seen.
    grey, hue = cv2.cvtColor(image(BARE), cv2.COLOR_RGB2LAB), cv2.cvtColor(left, cv2.COLOR_RGB2LAB)
    hue[..., 0] = grey[..., 0]
    assert measured(cv2.cvtColor(hue, cv2.COLOR_LAB2RGB), before).auc > 0.95


def test_an_outline_is_told_by_the_rim_and_the_profile():
    hole = around(MARKING, FRAME)
    edge = hole & ~(cv2.dilate(MARKING.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
    levels = BARE.copy()
    levels[edge] += 12
    clean, found = measured(image(BARE)), measured(image(levels))
    assert abs(found.left - clean.left) < 0.3
    assert found.rim - clean.rim > 2
    rise = np.array(found.profile) - np.array(clean.profile)
    at = dict(zip(BINS, rise, strict=False))
    assert at[0.08] > 3
    assert abs(at[-0.04]) < 0.3
    assert abs(at[0.16]) < 0.5


def test_a_smooth_streak_lacks_texture():
    levels = BARE.copy()
    hole = around(MARKING, FRAME)
    levels[hole] = cv2.GaussianBlur(BARE, (0, 0), 3)[hole]
    found = measured(image(levels))
    assert found.texture < 0.6
    assert abs(found.left) < 0.7


def test_one_remnant_is_among_the_worst():
    levels = BARE.copy()
    levels[92:95, 110:128] += 60
    clean, found = measured(image(BARE)), measured(image(levels))
    assert found.worst - clean.worst > 5
    assert found.left < 2.5


def test_what_cannot_be_measured_is_not():
    assert measured(image(BARE), before=image(BARE)) is None
    assert measured(image(BARE), marking=np.zeros_like(MARKING)) is None
    assert measured(image(BARE), ground=around(MARKING, FRAME)) is None


def test_ground_without_any_texture_tells_no_share_of_it():
    flat = np.full((240, 240, 3), 120, np.uint8)
    found = residue(np.where(MARKING[..., None], np.uint8(255), flat), flat, MARKING, GROUND, FRAME)
    assert found.left == 0.0 and np.isnan(found.texture) and np.isnan(found.z)
