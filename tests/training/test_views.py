"""Views of our own: the truth lies where the pixels say it does, and the same stream draws the same view."""

import numpy as np
import pytest

from pavemark.training import bodies, canvas, paint, views
from pavemark.training.canvas import SIDE


def _rng(number):
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(5, spawn_key=(number,))))


@pytest.fixture(scope="module")
def pairs():
    """Views with their markings, and the same without."""
    return [(views.sample(_rng(k)), views.sample(_rng(k), painted=False)) for k in range(4)]


def test_the_same_stream_draws_the_same_view(pairs):
    again = views.sample(_rng(0))
    assert (again.image == pairs[0][0].image).all()
    assert (again.marking == pairs[0][0].marking).all() and (again.ground == pairs[0][0].ground).all()


def test_paint_is_where_the_truth_says(pairs):
    """Markings change the pixels of the mask; exposure, which follows the whole picture, changes all alike."""
    told = 0
    for painted, bare in pairs:
        assert not bare.marking.any() and (painted.ground == bare.ground).all()
        change = np.log((painted.image + 8.0) / (bare.image + 8.0)).mean(-1)
        elsewhere = painted.ground & ~painted.marking
        if painted.marking.sum() > 500:
            told += 1
            change = np.abs(change - np.median(change[elsewhere]))
            assert np.median(change[painted.marking]) > 2 * np.median(change[elsewhere])
    assert told >= 2


def test_markings_lie_on_free_ground(pairs):
    for painted, _ in pairs:
        assert not (painted.marking & ~painted.ground).any()
        assert painted.image.shape == (SIDE, SIDE, 3) and painted.image.dtype == np.uint8


def test_the_car_with_the_cameras_is_no_ground(pairs):
    for painted, _ in pairs:
        assert not painted.ground[SIDE // 2 - 20 : SIDE // 2 + 20, SIDE // 2 - 20 : SIDE // 2 + 20].any()


@pytest.mark.parametrize(("height", "z", "enlarged"), [(1.0, 0.5, 2.0), (0.8, 0.6, 4.0), (1.2, 0.3, 4 / 3)])
def test_a_camera_enlarges_a_slice_about_its_foot(height, z, enlarged):
    """A ray from (0, h) through (d, z) meets the ground at d·h / (h - z)."""
    foot = np.array([100.0, 50.0])
    square = np.array([[10.0, 0], [12, 0], [12, 2], [10, 2]]) + foot
    body = bodies.Body(square, z, lambda at: square, lambda at: np.ones(3))
    shapes = [shape for shape, _ in bodies.seen([body], foot, height, 48.0)]
    assert shapes[0] == pytest.approx(square)
    assert shapes[-1] == pytest.approx(foot + (square - foot) * enlarged)


def test_what_stands_hides_the_ground():
    albedo, free = np.full((SIDE, SIDE, 3), 0.2, np.float32), np.ones((SIDE, SIDE), np.uint8)
    square = np.array([[100.0, 100], [140, 100], [140, 140], [100, 140]])
    bodies.draw(albedo, free, [(square, np.array([0.7, 0.1, 0.1]))])
    assert not free[105:135, 105:135].any() and free.sum() == SIDE * SIDE - (free == 0).sum()
    assert albedo[120, 120] == pytest.approx([0.7, 0.1, 0.1], abs=1e-6)
    assert free[90, 120] == 1 and albedo[90, 120] == pytest.approx([0.2] * 3)


@pytest.mark.parametrize("width", [2.0, 5.0, 9.5])
def test_a_line_covers_its_area(width):
    stencil = canvas.Stencil()
    stencil.line(np.array([[50.0, 60], [350, 260]]), width)
    # OpenCV fills the pixels that the outline touches: half a pixel of the finer sheet on either side.
    assert stencil.coverage().sum() == pytest.approx(np.hypot(300, 200) * (width + 0.5), rel=0.03)


def test_paint_stays_visible():
    """White on white is given another colour rather than a label that nobody can see."""
    floor = np.full((SIDE, SIDE, 3), 0.45, np.float32)
    stencil = canvas.Stencil()
    stencil.line(np.array([[50.0, 240], [430, 240]]), 10)
    coat = stencil.coverage()
    for number in range(20):
        laid = paint.laid_on(_rng(number), floor, coat, np.full(3, 0.46))
        assert laid[coat > 0.99].mean() / 0.45 > 1.02


def test_upright_things_are_drawn_out_away_from_the_camera():
    """What a wall shows changes little along a ray from the camera's foot, and much about it."""
    foot = np.array([30.0, 240.0])
    v, u = np.mgrid[0:SIDE, 0:SIDE].astype(np.float32) + 0.5
    polar = np.arctan2(v - foot[1], u - foot[0]), np.hypot(u - foot[0], v - foot[1])
    outwards, around = [], []
    for number in range(6):
        factor, mirrored = bodies.smear(_rng(number), polar)
        assert factor.min() > 0 and mirrored.min() >= 0
        ray = np.log(factor[240, 330:430])
        arc = np.log(factor[190:290, 380])
        outwards.append(np.abs(np.diff(ray)).mean())
        around.append(np.abs(np.diff(arc)).mean())
    assert np.mean(around) > 2 * np.mean(outwards)
