"""Decals at the limits of the frame, of the pixel and of float32: their exact coverage, and what Blender draws."""

import itertools

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import Polygon, box

from hard_cases import STEADY
from pavemark.colour import to_linear
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import MITRE_LIMIT, outline
from pavemark.ground import Frame
from pavemark.scene import REACH, Area, Blend, Curvature, Marking, Paint, Stroke
from scenes import WHITE, painted, rendered

EXACT = 1e-9
"""Share of a pixel: coverage below it counts as none. Rounding is 1e-16 a piece of outline and coordinate in pixels."""

HALF_FLOAT = 2**-11
"""What half floats, of eleven bits, may change in an alpha of at most 1."""

SHARE = 0.005
"""By which the sum of all that is drawn may miss the exact area; half floats take up to a tenth of it."""

EAST = np.array([1.0, 0.0])

FRAME = Frame(96, 80, 20)
"""4.8 m × 4 m at 20 px/m."""


def line(*points, width=0.1, closed=False):
    return Stroke(tuple((float(x), float(y)) for x, y in points), width, closed)


def marking(*parts, paint=WHITE):
    return Marking(
        "slot",
        paint,
        tuple(part for part in parts if isinstance(part, Stroke)),
        tuple(part for part in parts if isinstance(part, Area)),
    )


def rectangle(start, end, width):
    """The area of a stroke, written down by hand."""
    along = np.subtract(end, start) / np.hypot(*np.subtract(end, start))
    across = np.array([-along[1], along[0]]) * width / 2
    return Polygon([start - across, end - across, end + across, start + across])


def ground(frame):
    width, height = frame.size
    return box(-width / 2, -height / 2, width / 2, height / 2)


def seen(shape, frame):
    """Square metres of a shape within the frame."""
    return shapely.intersection(shape, ground(frame)).area


def covered(scene_or_marking, frame, curvature=None):
    return coverage(outline(scene_or_marking, curvature), frame)


# What each case covers, by hand: a shape, of which the frame shows a part.
LONG = ((-60.0, -0.7), (80.0, 0.9))
FAR = ((0.3, -0.4), (8e3, 6e3))
FARTHER = ((-0.9 * REACH, 0.3), (0.9 * REACH, 0.4))
CORNER = (2.4, 2.0)
TEN_DEGREES = [(np.cos(np.radians(angle)) * 1.5 - 1, np.sin(np.radians(angle)) * 1.5) for angle in (-5.0, 5.0)]
CASES = {
    "a twentieth of a pixel wide": (
        line((-1.2, 0.3), (1.7, 0.8), width=0.0025),
        rectangle((-1.2, 0.3), (1.7, 0.8), 0.0025),
    ),
    "a fiftieth of a pixel wide along a pixel border": (
        line((-1.5, 0.25), (1.5, 0.25), width=0.001),
        box(-1.5, 0.2495, 1.5, 0.2505),
    ),
    "smaller than a pixel": (
        line((0.512, 0.513), (0.52, 0.519), width=0.01),
        rectangle((0.512, 0.513), (0.52, 0.519), 0.01),
    ),
    "longer than the frame": (line(*LONG, width=0.3), rectangle(*LONG, 0.3)),
    "wider than the frame": (line((-9, 0), (9, 0.5), width=9.0), rectangle((-9, 0), (9, 0.5), 9.0)),
    "outside it": (line((7, 0), (9, 1)), Polygon()),
    "outside it, around a corner": (line((-2.4, 9), (9, -1.4), width=0.4), Polygon()),
    "touching its border from outside": (line((2.45, -1), (2.45, 1)), Polygon()),
    "on its corner": (line((2.0, 2.0), (2.8, 2.0), width=0.8), box(2.0, 1.6, 2.4, 2.0)),
    "touching its corner with a corner": (Area((CORNER, (3.4, 2.0), (3.4, 3.0), (2.4, 3.0))), Polygon()),
    "cut by its corner": (line((1.4, 3.0), (3.4, 1.0)), rectangle((1.4, 3.0), (3.4, 1.0), 0.1)),
    "reaching 10 km away": (line(*FAR, width=0.2), rectangle(*FAR, 0.2)),
    "reaching 180 km": (line(*FARTHER, width=0.2), rectangle(*FARTHER, 0.2)),
    "an area with a corner 10 km away": (
        Area(((-1.0, -1.0), (1e4, -0.5), (-1.0, 1.0))),
        Polygon([(-1, -1), (1e4, -0.5), (-1, 1)]),
    ),
}
case = pytest.mark.parametrize(("part", "by_hand"), CASES.values(), ids=CASES)


@case
def test_coverage_sums_to_the_exact_area(part, by_hand):
    share = covered(marking(part), FRAME)
    assert share.min() >= 0 and share.max() <= 1
    area = seen(by_hand, FRAME)
    if area == 0:
        assert not share.any()
    # Green's theorem: exact but for the rounding of coordinates, 1e-11 m at 1e5 m, along the edges seen, 10 m at most.
    assert share.sum() / FRAME.scale**2 == pytest.approx(area, rel=1e-9, abs=1e-9)


@case
def test_blender_draws_the_exact_area(part, by_hand, renderer):
    alpha = rendered(renderer, painted(FRAME, marking(part)))[..., 3]
    assert np.abs(alpha - covered(marking(part), FRAME)).max() <= HALF_FLOAT
    if seen(by_hand, FRAME) == 0:
        assert not alpha.any()
    assert alpha.sum() / FRAME.scale**2 == pytest.approx(seen(by_hand, FRAME), rel=SHARE)


@settings(STEADY, max_examples=120)
@given(
    st.lists(st.tuples(st.floats(-6, 6), st.floats(-6, 6)), min_size=2, max_size=5),
    st.floats(-3, 1).map(lambda power: 10**power),
    st.booleans(),
    st.tuples(st.integers(8, 40), st.integers(8, 40), st.floats(1, 20)),
)
def test_any_stroke_in_any_frame_sums_to_its_area(points, width, closed, size):
    frame = Frame(*size)
    shape = outline(marking(line(*points, width=width, closed=closed)), None)
    share = coverage(shape, frame)
    assert share.min() >= 0 and share.max() <= 1
    # Pixels of less than EXACT are left out, and those of nearly all filled up.
    assert share.sum() == pytest.approx(seen(shape, frame) * frame.scale**2, abs=share.size * EXACT)


@settings(STEADY, max_examples=60)
@given(
    st.lists(st.tuples(st.floats(-6, 6), st.floats(-6, 6)), min_size=2, max_size=5),
    st.floats(0.01, 1),
    st.integers(2, 7),
)
def test_a_pixel_covers_what_its_parts_cover(points, width, times):
    shape = outline(marking(line(*points, width=width)), None)
    coarse, fine = Frame(24, 16, 4.0), Frame(24 * times, 16 * times, 4.0 * times)
    parts = coverage(shape, fine).reshape(16, times, 24, times).mean((1, 3))
    # Area is additive: frames of any size agree.
    np.testing.assert_allclose(coverage(shape, coarse), parts, rtol=0, atol=2 * EXACT)


@pytest.mark.parametrize("shift", [(-2.8, 0), (2.8, 0), (0, -2.5), (0, 2.5), (2.8, 2.5), (-1e4, 1e4)], ids=str)
def test_a_shape_outside_the_frame_covers_nothing(shift):
    assert not coverage(affinity.translate(box(-0.3, -0.4, 0.3, 0.4), *shift), FRAME).any()


@pytest.mark.parametrize("corner", list(itertools.product((-1, 1), repeat=2)), ids=str)
def test_a_square_on_any_corner_is_covered_by_a_quarter(corner, renderer):
    at = np.array(corner) * FRAME.size / 2
    square = marking(line(at - 0.4 * EAST, at + 0.4 * EAST, width=0.8))
    # Its quarter is 8 × 8 pixels in that corner, covered whole.
    wanted = np.zeros((FRAME.height, FRAME.width))
    rows, columns = (np.s_[-8:] if corner[1] < 0 else np.s_[:8]), (np.s_[:8] if corner[0] < 0 else np.s_[-8:])
    wanted[rows, columns] = 1
    np.testing.assert_array_equal(covered(square, FRAME), wanted)
    np.testing.assert_array_equal(rendered(renderer, painted(FRAME, square))[..., 3], wanted)


V = line(TEN_DEGREES[0], (-1.0, 0.0), TEN_DEGREES[1], width=0.12)
"""A corner of 10°: of paint, the outer edges would meet 11 half widths beyond it."""

LEGS = shapely.union_all([rectangle(TEN_DEGREES[0], (-1, 0), 0.12), rectangle((-1, 0), TEN_DEGREES[1], 0.12)])


def test_an_acute_join_is_cut_off():
    shape = outline(marking(V), None)
    # Both legs are painted, whole.
    assert shapely.intersection(shape, LEGS).area == pytest.approx(LEGS.area, rel=1e-9)
    # What is added lies behind the corner, no further than the limit allows.
    assert 0 < -1 - shape.bounds[0] <= MITRE_LIMIT * 0.06 * (1 + 1e-9)
    assert shape.area - LEGS.area <= MITRE_LIMIT * 0.06 * 0.12


def test_a_join_of_30_degrees_is_not():
    ends = [(np.cos(np.radians(a)) - 1, np.sin(np.radians(a))) for a in (-15, 15)]
    shape = outline(marking(line(ends[0], (-1, 0), ends[1], width=0.12)), None)
    # The edges meet w/2 / sin 15° beyond the corner, 3.9 half widths: within the limit.
    assert -1 - shape.bounds[0] == pytest.approx(0.06 / np.sin(np.radians(15)), rel=1e-9)


@pytest.mark.parametrize("curvature", [None, Curvature(200.0, 0.3, 4)], ids=["straight", "bent"])
def test_an_acute_join_is_drawn_as_it_is(curvature, renderer):
    shape = outline(marking(V), curvature)
    share = coverage(shape, FRAME)
    assert share.sum() / FRAME.scale**2 == pytest.approx(shape.area, rel=1e-9)
    alpha = rendered(renderer, painted(FRAME, marking(V), curvature=curvature))[..., 3]
    assert np.abs(alpha - share).max() <= HALF_FLOAT
    assert alpha.sum() / FRAME.scale**2 == pytest.approx(shape.area, rel=SHARE)


STACK = [line((-1.8, -0.6), (1.8, 0.7), width=0.5)]
CROSSING = [line((-1.8, 0.3 * k - 0.6), (1.8, 0.6 - 0.3 * k), width=0.4) for k in range(5)]


@pytest.mark.parametrize("strokes", [STACK * 5, CROSSING], ids=["coincident", "overlapping"])
def test_five_strokes_of_one_marking_are_one_coat(strokes, renderer):
    union = shapely.union_all([rectangle(*stroke.path, stroke.width) for stroke in strokes])
    share = covered(marking(*strokes), FRAME)
    assert share.max() == 1
    assert share.sum() / FRAME.scale**2 == pytest.approx(union.area, rel=1e-9)
    alpha = rendered(renderer, painted(FRAME, marking(*strokes)))[..., 3]
    assert np.abs(alpha - share).max() <= HALF_FLOAT


@settings(STEADY, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.floats(-17, -7))
def test_strokes_that_all_but_coincide_are_one(seed, power):
    rng = np.random.default_rng(seed)
    start, end = rng.uniform(-2, 2, (2, 2))
    strokes = []
    for _ in range(5):
        ends = [start, end] + 10.0**power * rng.normal(size=2)
        strokes.append(line(*(ends if rng.random() < 0.5 else ends[::-1])))
    shape = outline(marking(*strokes), None)
    assert shape.is_valid
    # Five rectangles moved by a few times 10**power: so much is added along the outline.
    length = np.hypot(*(end - start))
    assert shape.area == pytest.approx(0.1 * length, abs=1e-12 + 20 * 10.0**power * (length + 0.1))


def coats(*tones, method="normal", strokes=STACK):
    """Coats of grey, one above the other."""
    return [marking(*strokes, paint=Paint((t, t, t), (t / 100, t / 100, t / 100))) for t in tones]


@pytest.mark.parametrize("frame", [FRAME, Frame(600, 500, 60)], ids=["20 px/m", "60 px/m"])
def test_of_five_coincident_markings_the_last_is_seen(renderer, frame):
    tones = (40.0, 80.0, 120.0, 160.0, 200.0)
    middle = (frame.height // 2, frame.width // 2)
    once = covered(coats(1)[0], frame)
    for order in (tones, tones[::-1]):
        drawn = rendered(renderer, painted(frame, *coats(*order), blend=Blend(method="normal")))
        assert drawn[middle][0] == pytest.approx(to_linear(np.array(order[-1])), rel=2 * HALF_FLOAT)
        # On an edge every coat covers its share of what is left: 1 - (1 - a)⁵. Each of the five is a product more.
        assert np.abs(drawn[..., 3] - (1 - (1 - once) ** 5)).max() <= 2 * HALF_FLOAT


def test_of_five_overlapping_markings_the_upper_one_is_seen_everywhere(renderer):
    tones = (40.0, 80.0, 120.0, 160.0, 200.0)
    layers = [coats(tone, strokes=[stroke])[0] for stroke, tone in zip(CROSSING, tones, strict=True)]
    drawn = rendered(renderer, painted(FRAME, *layers, blend=Blend(method="normal")))
    wanted = np.zeros((FRAME.height, FRAME.width, 2))
    for layer, tone in zip(layers, tones, strict=True):
        share = covered(layer, FRAME)[..., None]
        wanted = wanted * (1 - share) + share * (float(to_linear(np.array(tone))), 1)
    assert np.abs(drawn[..., [0, 3]] - wanted).max() <= 2 * HALF_FLOAT


def test_decals_do_not_flicker(renderer):
    scene = painted(FRAME, *coats(40, 200, 90))
    first = rendered(renderer, scene)
    assert all(np.array_equal(first, rendered(renderer, scene)) for _ in range(3))


@pytest.mark.parametrize("size", [(16384, 16), (16, 16384)], ids=str)
def test_five_coats_8_km_from_the_origin(renderer, size):
    """The farthest that a frame reaches: 16,384 pixels of a metre. Numbers of float32 there are 0.5 mm apart."""
    frame = Frame(*size, 1.0)
    end = np.array(frame.size) / 2 - 3
    start = end - np.where(np.array(size) > 100, 40, 5)
    stroke = line(start, end, width=0.7)
    share = covered(marking(stroke), frame)
    assert share.sum() == pytest.approx(seen(rectangle(start, end, 0.7), frame), rel=1e-9)
    drawn = rendered(renderer, painted(frame, *coats(40, 80, 120, 160, 200, strokes=[stroke]), blend=Blend("normal")))
    # Pixels are rectangles of their own: a ray through a centre is half a pixel, 1,000 numbers, from every edge.
    assert np.abs(drawn[..., 3] - (1 - (1 - share) ** 5)).max() <= 2 * HALF_FLOAT
    colour, left = 0.0, 1 - share
    for tone in (40, 80, 120, 160, 200):
        colour = colour * left + share * float(to_linear(np.array(tone)))
    assert np.abs(drawn[..., 0] - colour).max() <= 2 * HALF_FLOAT


@pytest.mark.parametrize("reach", [1e4, 0.9 * REACH], ids=["10 km", "90 km"])
def test_hard_edges_of_lines_that_go_on_for_kilometres(renderer, reach):
    """Many samples see the outline itself, in float32: what they see must not depend on where it ends."""
    slope = np.array([1.0, 0.21])
    near, far = (marking(line(-x * slope + (0, 0.1), x * slope + (0, 0.1), width=0.2)) for x in (4.0, reach))
    wanted, got = (rendered(renderer, painted(FRAME, each), samples=64)[..., 3] for each in (near, far))
    # The same rays on edges that are as good as the same: one ray in 64 may fall on the other side.
    assert np.abs(got - wanted).max() <= 1 / 64 + HALF_FLOAT
    assert (got != wanted).mean() < 0.001


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(Frame(8, 8, 1.0), id="8 px"),
        pytest.param(Frame(16, 16, 1.6), id="16 px"),
        pytest.param(Frame(16, 16, 60), id="16 px at 60 px/m"),
        pytest.param(Frame(96, 300, 1 / 0.044), id="96 × 300 px"),
        pytest.param(Frame(448, 720, 60), id="448 × 720 px"),
        pytest.param(Frame(4096, 4096, 409.6), id="4,096 px", marks=pytest.mark.slow),
    ],
)
def test_frames(renderer, frame):
    width, height = frame.size
    ends = [(-0.7 * width, -0.2 * height), (0.3 * width, 0.45 * height)]
    lines = marking(line(*ends, width=max(0.001, 0.013 * width)), line((0, -height), (0.1 * width, height), width=0.1))
    share = covered(lines, frame)
    by_hand = shapely.union_all([rectangle(*map(np.array, stroke.path), stroke.width) for stroke in lines.strokes])
    assert share.sum() / frame.scale**2 == pytest.approx(seen(by_hand, frame), rel=1e-9)
    alpha = rendered(renderer, painted(frame, lines))[..., 3]
    assert alpha.shape == (frame.height, frame.width)
    assert np.abs(alpha - share).max() <= HALF_FLOAT
    assert alpha.sum() / frame.scale**2 == pytest.approx(seen(by_hand, frame), rel=SHARE)
