"""What level ground mirrors: the law of reflection, seams, and how much at which angle."""

import numpy as np
import pytest

from pavemark.geometry.mirror import SEAM, mirrored, schlick, seen_by

EYES = ((0.0, 2.0, 0.7), (-1.0, 0.0, 1.0), (1.0, 0.0, 1.0))
POINTS = np.random.default_rng(0).uniform(-5, 5, (200, 2))


def test_rays_leave_as_they_came():
    rays = mirrored(POINTS, np.array(EYES[0]))
    came = np.column_stack([POINTS, np.zeros(200)]) - EYES[0]
    came /= np.linalg.norm(came, axis=1, keepdims=True)
    np.testing.assert_allclose(rays, came * (1, 1, -1), atol=1e-12)
    assert mirrored(np.array([[0.0, 2.0]]), np.array(EYES[0]))[0] == pytest.approx((0, 0, 1))


def test_points_are_seen_by_the_nearest_camera_and_near_a_seam_by_two():
    shares = seen_by(POINTS, EYES)
    away = np.linalg.norm(POINTS[:, None] - np.array(EYES)[:, :2], axis=-1)
    assert shares.sum(1) == pytest.approx(np.ones(200))
    assert (shares.argmax(1) == away.argmin(1)).all()
    assert ((shares > 0) == (away < away.min(1, keepdims=True) + SEAM)).all()
    assert seen_by(np.array([[0.0, -3.0]]), EYES)[0] == pytest.approx((0, 0.5, 0.5))


def test_more_is_mirrored_at_grazing_angles():
    assert schlick(np.array([1.0, 0.0]), 0.02) == pytest.approx((0.02, 1.0))
    assert schlick(np.array([np.cos(np.radians(60))]), 0.02) == pytest.approx([0.02 + 0.98 / 32])
