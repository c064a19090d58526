"""The elastic field where it would fold, where it does nothing, and in frames of any size."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, Polygon

from hard_cases import EPS, STEADY
from pavemark.geometry import elastic
from pavemark.geometry.coverage import coverage
from pavemark.geometry.elastic import PERIOD, STEEPEST, displace, jacobian
from pavemark.geometry.outline import SAGITTA, bend, outline
from pavemark.ground import Frame
from pavemark.scene import Area, Curvature, Marking, Stroke
from scenes import WHITE, row

FOLDING = [
    pytest.param(Curvature(200.0, 0.02, 1), id="alpha 200, sigma 2 cm"),
    pytest.param(Curvature(200.0, 0.05, 2), id="alpha 200, sigma 5 cm"),
    pytest.param(Curvature(200.0, 0.1, 3), id="alpha 200, sigma 10 cm"),
    pytest.param(Curvature(1000.0, 0.02, 4), id="alpha 1000, sigma 2 cm"),
    pytest.param(Curvature(1000.0, 0.3, 5), id="alpha 1000, sigma 30 cm"),
]

FLATTEST = (1 - STEEPEST / math.sqrt(2)) ** 2
"""Least determinant of I + G for a G of Frobenius norm STEEPEST: both of its singular values are STEEPEST/√2 and both
shrink the plane."""

APART = 2 * SAGITTA / (1 - STEEPEST)
"""Metres: what is so far apart is brought no nearer than 2·SAGITTA, and chords stray by SAGITTA: they cannot meet."""

curvatures = st.builds(
    Curvature, st.floats(0, 1000), st.floats(0.02, 5).map(lambda x: round(x, 3)), st.integers(0, 2**32)
)


def everywhere(curvature, fineness=6):
    """Points of a whole period of the field, so many along each cell of it."""
    spacing = math.sqrt(3) * curvature.sigma
    along = (np.arange(PERIOD * fineness) + 0.5) / fineness * spacing
    return np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)


def steepness(curvature, points):
    return np.sqrt(((jacobian(curvature, points) - np.eye(2)) ** 2).sum((-1, -2)))


@pytest.fixture
def unlimited(monkeypatch):
    """The field as the classical recipe leaves it."""
    monkeypatch.setattr(elastic, "STEEPEST", math.inf)
    elastic._field.cache_clear()
    yield
    elastic._field.cache_clear()


@pytest.mark.parametrize("curvature", FOLDING)
def test_the_recipe_alone_folds_and_the_sign_of_the_jacobian_tells(curvature, unlimited):
    determinant = np.linalg.det(jacobian(curvature, everywhere(curvature, 2)))
    assert determinant.min() < 0
    # Where a map turns over, two points come to lie on one: outlines there cross themselves.
    assert steepness(curvature, everywhere(curvature, 2)).max() > 1


@pytest.mark.parametrize("curvature", FOLDING)
def test_folds_are_limited_away(curvature):
    points = everywhere(curvature)
    # Rounding of sixteen products.
    assert steepness(curvature, points).max() <= STEEPEST + 64 * EPS
    assert np.linalg.det(jacobian(curvature, points)).min() >= FLATTEST - 64 * EPS
    # Limited to the bound, not flattened beyond need: control points are at most half as large again as the field.
    assert steepness(curvature, points).max() > 0.6 * STEEPEST


@settings(STEADY, max_examples=60)
@given(curvatures, st.integers(0, 2**32 - 1))
def test_no_field_that_is_allowed_folds(curvature, seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-100, 100, (2000, 2))
    assert steepness(curvature, points).max() <= STEEPEST + 64 * EPS
    assert np.linalg.det(jacobian(curvature, points)).min() >= FLATTEST - 64 * EPS
    # One to one, near and far: the displacement's difference is at most STEEPEST times the distance.
    others = points + rng.normal(size=points.shape) * 10.0 ** rng.uniform(-5, 1, (2000, 1))
    before = np.hypot(*(points - others).T)
    after = np.hypot(*(displace(curvature, points) - displace(curvature, others)).T)
    # Coordinates of 100 m are rounded to 1.4e-14 m, four times on the way.
    assert (after >= (1 - STEEPEST) * before - 1e-13).all()


@settings(STEADY, max_examples=60)
@given(curvatures, st.integers(0, 2**32 - 1), st.integers(3, 14), st.floats(0.05, 4.0))
def test_rings_never_cross_themselves(curvature, seed, corners, radius):
    rng = np.random.default_rng(seed)
    turn = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * 2 * np.pi / corners
    ring = Polygon(radius * rng.uniform(0.4, 1, (corners, 1)) * np.stack([np.cos(turn), np.sin(turn)], -1))
    (bent,) = bend([ring], curvature)
    assert bent.exterior.is_simple and bent.exterior.is_ccw
    assert bent.is_valid
    # Area changes by the determinant, (1 ± STEEPEST)² at most; chords cut off a little of it.
    slack = SAGITTA * bent.length
    assert (1 - STEEPEST) ** 2 * ring.area - slack <= bent.area <= (1 + STEEPEST) ** 2 * ring.area + slack


@pytest.mark.parametrize("curvature", FOLDING)
def test_a_gap_of_a_few_millimetres_stays_open(curvature):
    slit = APART * 1.01
    comb = Polygon([(-2, -1), (2, -1), (2, 1), (slit, 1), (slit, -0.9), (0, -0.9), (0, 1), (-2, 1)])
    (bent,) = bend([comb], curvature)
    assert bent.is_valid and len(bent.interiors) == 0
    left, right = LineString(comb.exterior.coords[5:7]), LineString(comb.exterior.coords[3:5])
    assert shapely.distance(*bend([left, right], curvature)) > 0


@pytest.mark.parametrize("curvature", FOLDING)
@pytest.mark.parametrize("kind", ["closed", "half-closed", "open", "corner"])
def test_outlines_of_rows_keep_their_parts_and_holes(kind, curvature):
    marking = row(n=3, outline=kind).markings[0]
    straight, bent = outline(marking, None), outline(marking, curvature)
    assert bent.is_valid
    # A map without folds changes no connection; strokes of 10 cm keep their width, and lie metres apart.
    assert len(bent.geoms) == len(straight.geoms)
    assert sum(len(part.interiors) for part in bent.geoms) == sum(len(part.interiors) for part in straight.geoms)


@settings(STEADY, max_examples=40)
@given(curvatures, st.integers(0, 2**32 - 1), st.floats(0.001, 2.0), st.booleans())
def test_outlines_are_valid_whatever_is_bent(curvature, seed, width, closed):
    rng = np.random.default_rng(seed)
    path = tuple(map(tuple, rng.uniform(-2, 2, (rng.integers(2, 9), 2)).tolist()))
    ring = tuple(map(tuple, rng.uniform(-2, 2, (rng.integers(3, 9), 2)).tolist()))
    got = outline(Marking("slot", WHITE, (Stroke(path, width, closed),), (Area(ring),)), curvature)
    assert got.is_valid
    assert all(ring.is_simple for part in got.geoms for ring in (part.exterior, *part.interiors))


@pytest.mark.parametrize("curvature", [*FOLDING, pytest.param(Curvature(200.0, 0.3, 8), id="alpha 200, sigma 30 cm")])
def test_chords_stay_with_what_they_stand_for(curvature):
    (bent,) = bend([LineString([(-3, -1.7), (3, 1.1)])], curvature)
    fine = np.linspace((-3, -1.7), (3, 1.1), 20001)
    # h²/8 times the second derivative, whose bound chose h. Half a pixel before that, where sigma was 2 cm.
    assert bent.distance(shapely.points(displace(curvature, fine))).max() <= SAGITTA


def test_no_field_is_the_exact_identity():
    at = np.random.default_rng(0).uniform(-40, 40, (50, 2))
    np.testing.assert_array_equal(displace(None, at), at)
    np.testing.assert_array_equal(jacobian(None, at), np.broadcast_to(np.eye(2), (50, 2, 2)))


@pytest.mark.parametrize("sigma", [0.02, 0.4, 5.0])
def test_a_zero_field_is_the_exact_identity(sigma):
    zero = Curvature(0.0, sigma, 11)
    at = np.random.default_rng(0).uniform(-40, 40, (50, 2))
    np.testing.assert_array_equal(displace(zero, at), at)
    np.testing.assert_array_equal(jacobian(zero, at), np.broadcast_to(np.eye(2), (50, 2, 2)))
    marking = row(n=2).markings[0]
    # The points between which it bends nothing are rounded: 1e-15 m over 30 m of outline.
    assert outline(marking, zero).symmetric_difference(outline(marking, None)).area < 1e-12


BENT = Curvature(200.0, 0.3, 6)
LINES = row(n=2, start=(-2.0, 2.0), curvature=BENT).markings[0]


def test_the_field_does_not_know_the_frame():
    small, large = Frame(300, 240, 60), Frame(600, 900, 60)
    part = coverage(outline(LINES, BENT), large)[330:570, 150:450]
    # Pixels of both frames lie on the same ground, whose numbers differ in the last digit.
    np.testing.assert_allclose(part, coverage(outline(LINES, BENT), small), rtol=0, atol=1e-9)


@pytest.mark.parametrize("times", [2, 5])
def test_the_field_does_not_know_the_scale(times):
    coarse, fine = Frame(200, 160, 20), Frame(200 * times, 160 * times, 20 * times)
    blocks = coverage(outline(LINES, BENT), fine).reshape(160, times, 200, times).mean((1, 3))
    # Area adds up exactly: a pixel's share is the mean of its parts'.
    np.testing.assert_allclose(blocks, coverage(outline(LINES, BENT), coarse), rtol=0, atol=1e-9)


@pytest.mark.parametrize("away", [1, -3, 50])
def test_far_off_the_field_repeats(away):
    step = away * PERIOD * math.sqrt(3) * BENT.sigma
    at = np.random.default_rng(1).uniform(-5, 5, (200, 2))
    here, there = displace(BENT, at) - at, displace(BENT, at + step) - (at + step)
    # At 1.7 km numbers are 2e-13 m apart, and slopes are below 1.
    np.testing.assert_allclose(there, here, rtol=0, atol=1e-12)
