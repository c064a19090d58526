"""What a smooth floor mirrors of lamps, against facets thrown at random."""

import attrs
import numpy as np
import pytest

from pavemark.compose.glare import gleam
from pavemark.ground import Frame
from pavemark.light import Glare, Tube

FRAME = Frame(40, 40, 4)
EYE = (0.0, -1.0, 0.9)
TUBES = (
    Tube((2.0, 1.0, 3.0), 1.5, 0.15, 0.7, (10.0, 10.0, 10.0)),
    Tube((-3.0, 2.0, 3.5), 1.2, 0.6, 0.1, (10.0, 10.0, 10.0)),
)
WHOLE = np.ones((40, 40), bool)


def thrown(point, roughness, reflectance, tubes, count=200_000):
    """Radiance that floor at a point (2,) sends to EYE, by facets drawn from GGX's density of slopes."""
    rng = np.random.default_rng(1)
    here = np.array([*point, 0.0])
    eye = np.array(EYE) - here
    eye /= np.linalg.norm(eye)
    u = rng.random(count)
    slope, turn = roughness**2 * np.sqrt(u / (1 - u)), 2 * np.pi * rng.random(count)
    facet = np.stack([-slope * np.cos(turn), -slope * np.sin(turn), np.ones(count)], -1)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    cosine = facet @ eye
    ray = 2 * cosine[:, None] * facet - eye
    up = (ray[:, 2] > 1e-6) & (cosine > 0)
    share = reflectance + (1 - reflectance) * (1 - np.clip(cosine, 0, 1)) ** 5
    seen = 0.0
    for tube in tubes:
        met = here[:2] + ray[:, :2] * (tube.place[2] / np.where(up, ray[:, 2], 1.0))[:, None] - tube.place[:2]
        c, s = np.cos(tube.turn), np.sin(tube.turn)
        hit = up & (np.abs(met @ (c, s)) < tube.length / 2) & (np.abs(met @ (-s, c)) < tube.width / 2)
        seen += tube.radiance[0] * (hit * share * cosine / (eye[2] * facet[:, 2])).mean()
    return seen


@pytest.mark.parametrize("roughness", [0.2, 0.3, 0.45, 0.7])
def test_closed_form_agrees_with_facets_thrown_at_random(roughness):
    made = gleam(FRAME, Glare(TUBES, roughness, 0.05, (EYE,)), WHOLE)[..., 0]
    points = FRAME.pixel_centres()
    brightest = np.unravel_index(made.argmax(), made.shape)
    for row, column in (brightest, (18, 22), (15, 25), (12, 14), (19, 16), (22, 24)):
        wanted = thrown(points[row, column], roughness, 0.05, TUBES)
        # 3 % for curved strips that are taken as straight, and the noise of so many facets where few of them hit.
        assert made[row, column] == pytest.approx(wanted, rel=0.03, abs=3e-4)


def test_the_gleam_lies_where_a_mirror_shows_the_lamp():
    lamp = Tube((2.0, 1.0, 3.0), 0.1, 0.1, 0.0, (10.0,) * 3)
    made = gleam(Frame(400, 400, 40), Glare((lamp,), 0.05, 0.05, (EYE,)), np.ones((400, 400), bool))[..., 0]
    row, column = np.unravel_index(made.argmax(), made.shape)
    mirror = np.array(EYE[:2]) + (np.array(lamp.place[:2]) - EYE[:2]) * 0.9 / (0.9 + 3.0)
    assert Frame(400, 400, 40).pixel_centres()[row, column] == pytest.approx(mirror, abs=0.05)


def test_a_wide_panel_is_the_sum_of_its_strips():
    panel = Tube((1.0, 0.5, 3.0), 1.0, 1.0, 0.4, (5.0,) * 3)
    beside = np.array([-np.sin(0.4), np.cos(0.4)])
    strips = tuple(
        attrs.evolve(panel, width=0.25, place=(*(np.array((1.0, 0.5)) + off * beside).tolist(), 3.0))
        for off in (-0.375, -0.125, 0.125, 0.375)
    )
    whole, parts = (gleam(FRAME, Glare(tubes, 0.3, 0.05, (EYE,)), WHOLE) for tubes in ((panel,), strips))
    np.testing.assert_allclose(whole, parts, rtol=1e-4, atol=1e-6)


def test_no_floor_no_gleam_and_no_lamp_no_gleam():
    floor = WHOLE.copy()
    floor[:, :20] = False
    made = gleam(FRAME, Glare(TUBES, 0.3, 0.05, (EYE,)), floor)
    assert (made[:, :20] == 0).all() and (made[:, 20:] > 0).all()
    assert (gleam(FRAME, Glare((), 0.3, 0.05, (EYE,)), WHOLE) == 0).all()


def test_far_and_low_lamps_stay_finite():
    tubes = (
        Tube((900.0, 900.0, 0.01), 40.0, 9.0, 1.0, (1000.0,) * 3),
        Tube((0.0, -1.0, 0.9), 1.0, 0.1, 0.0, (1.0,) * 3),
    )
    for roughness in (0.01, 1.0):
        assert np.isfinite(gleam(FRAME, Glare(tubes, roughness, 1.0, (EYE, (0.1, -1.0, 0.9))), WHOLE)).all()
