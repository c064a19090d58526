"""The fisheye model is exact both ways, and a point of the ground comes back through camera and stitching."""

import numpy as np
import pytest

from pavemark.cameras.rig import SIDES, Fisheye, Mount, mounts
from pavemark.cameras.stitch import lookup
from pavemark.ground import Frame


def test_projection_and_its_inverse_agree():
    fisheye = Fisheye(640)
    rng = np.random.default_rng(1)
    theta, phi = rng.uniform(0, fisheye.fov / 2, 2000), rng.uniform(0, 2 * np.pi, 2000)
    rays = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)], -1)
    rays = np.concatenate([rays, [[0.0, 0.0, -1.0]]])
    uv = fisheye.project(rays)
    np.testing.assert_allclose(fisheye.unproject(uv), rays, atol=1e-9)
    np.testing.assert_allclose(fisheye.project(fisheye.unproject(uv)), uv, atol=1e-9)


def test_the_angle_grows_with_the_radius_and_the_picture_is_upright():
    fisheye = Fisheye(600, np.pi)
    np.testing.assert_allclose(fisheye.project(np.array([1.0, 0.0, -1.0])), (450, 300))
    np.testing.assert_allclose(fisheye.project(np.array([0.0, 1.0, 0.0])), (300, 0), atol=1e-9)


@pytest.mark.parametrize("side", SIDES)
def test_a_ground_point_comes_back(side):
    frame, fisheye, mount = Frame(), Fisheye(700), mounts(4.4, 1.8)[side]
    rng = np.random.default_rng(2)
    uv = rng.uniform(0, 600, (500, 2))
    ground = frame.to_world(uv)
    rays = mount.to_camera(np.column_stack([ground, np.zeros(500)]))
    back = mount.to_ground(fisheye.unproject(fisheye.project(rays)))
    np.testing.assert_allclose(frame.to_image(back), uv, atol=1e-6)


def test_cameras_face_their_side():
    ahead = {"front": (0, 4), "left": (-4, 0.55), "right": (4, 0.55), "rear": (0, -4)}
    for side, mount in mounts(4.4, 1.8).items():
        right, _, back = mount.to_camera((*ahead[side], 0.0))
        assert abs(right) < 1e-9 and back < 0, side
        assert np.linalg.det(mount.rotation) == pytest.approx(1)


def test_lookup_is_the_pinpoint_of_the_pixel_centre():
    frame, fisheye, mount = Frame(40, 40, 4.0), Fisheye(500), Mount((0.3, 2.0, 0.7), 0.2, 0.6, 0.05)
    x, y = 10.5 / 4 - 5, 5 - 3.5 / 4
    expected = fisheye.project(mount.to_camera((x, y, 0.0)))
    np.testing.assert_allclose(lookup(frame, fisheye, mount)[3, 10], expected, atol=1e-4)
