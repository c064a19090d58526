"""Four pictures of a chessboard on the ground become one chessboard; the seams lie where the car says."""

import numpy as np
import pytest

from pavemark.cameras import stitch
from pavemark.cameras.rig import SIDES, Fisheye, mounts
from pavemark.ground import Frame

FRAME, EGO = Frame(), stitch.Ego()


def _board(x, y):
    """Fields of 1 m, softened over 6 cm so that a shift shows as a change of grey."""
    return 0.5 + 0.5 * np.clip(np.sin(np.pi * x) * 12, -1, 1) * np.clip(np.sin(np.pi * y) * 12, -1, 1)


def _pictures(fisheye):
    v, u = np.mgrid[0 : fisheye.size, 0 : fisheye.size] + 0.5
    rays = fisheye.unproject(np.stack([u, v], -1))
    for side, mount in mounts(4.4, 1.8).items():
        x, y = np.moveaxis(mount.to_ground(rays), -1, 0)
        yield side, np.nan_to_num(_board(x, y)).astype(np.float32)


def test_a_chessboard_comes_back_within_a_pixel():
    fisheye = Fisheye(1600)
    seen_at = {side: stitch.lookup(FRAME, fisheye, mount) for side, mount in mounts(4.4, 1.8).items()}
    view = stitch.stitch(dict(_pictures(fisheye)), seen_at, stitch.sectors(FRAME, EGO))
    x, y = np.moveaxis(FRAME.pixel_centres(), -1, 0)
    seen = (np.abs(x) > 1.2) | (np.abs(y) > 2.4)

    def error(right, down):
        return np.abs(view - _board(x + right / FRAME.scale, y - down / FRAME.scale))[seen].mean()

    here = error(0, 0)
    assert here < 0.01
    # One pixel off in any direction fits far worse, so the board lies within a pixel of its place.
    assert all(error(*step) > 2 * here for step in ((1, 0), (-1, 0), (0, 1), (0, -1)))


def test_shares_sum_to_one_and_each_camera_has_its_side():
    shares = stitch.sectors(FRAME, EGO)
    np.testing.assert_allclose(sum(shares.values()), 1, atol=1e-6)
    for side, (u, v) in {"front": (300, 20), "left": (20, 300), "right": (580, 300), "rear": (300, 580)}.items():
        assert {name for name in SIDES if shares[name][v, u] > 0} == {side}


@pytest.mark.parametrize(("end", "angle"), [(1, EGO.front), (-1, EGO.rear)])
def test_the_seam_leaves_the_corner_at_its_angle(end, angle):
    shares = stitch.sectors(FRAME, EGO)
    share = shares["front" if end > 0 else "rear"]
    for reach in (0.5, 1.5, 2.5):
        x, y = EGO.width / 2 + reach * np.sin(angle), end * (EGO.length / 2 + reach * np.cos(angle))
        u, v = FRAME.to_image((x, y))
        if FRAME.contains((u, v)):
            row = share[int(v)]
            assert row[int(u) - 4] == 1 and row[int(u) + 4] == 0


def test_the_window_holds_all_that_is_sampled():
    seen_at = np.array([[[100.5, 200.5], [300.0, 420.0]], [[5.0, 5.0], [310.0, 470.0]]], np.float32)
    share = np.array([[1, 0.5], [0, 1]], np.float32)
    assert stitch.window(seen_at, share, 480) == (84, 184, 326, 480)


def test_the_silhouette_is_about_the_car():
    black = stitch.silhouette(FRAME, EGO, np.random.default_rng(3))
    assert black.sum() / FRAME.scale**2 == pytest.approx(EGO.length * EGO.width, rel=0.08)
    assert black[300, 300] and not black[300, 220] and not black[140, 300]
