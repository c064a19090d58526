"""Brightness, noise and bytes where they reach black, white and full saturation."""

import ast
import colorsys
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hard_cases import STEADY
from pavemark.background.contracts import CONTRACTS
from pavemark.background.inpainting import METHODS
from pavemark.background.inpainting.crops import filled_in_crops
from pavemark.cameras import sensor
from pavemark.colour import LINEAR, quantise, to_display, within_gamut
from pavemark.compose import brightness, noise
from pavemark.compose.image import compose
from pavemark.ground import Frame
from pavemark.labels import masks
from pavemark.labels.truth import truth
from pavemark.layers import Layers
from pavemark.plan import plan
from pavemark.scene import Blend, Brightness, Noise, Optics
from pavemark.training.gaps import taken
from scenes import plate, row

FLOAT32 = 255 * 2**-23
"""The step of float32 at 255: three roundings on the way to a level stay below it twice over."""

MANY = (1000, 1000)
"""10⁶ pixels."""

SIGMAS = 5.0
"""Standard errors by which a mean may be off: one set of draws in 1.7 million is, these are always the same."""

PACKAGE = Path(__file__).parents[2] / "pipeline" / "pavemark"

PURE = [
    pytest.param((0, 0, 0), id="black"),
    pytest.param((255, 255, 255), id="white"),
    pytest.param((255, 0, 0), id="red"),
    pytest.param((0, 255, 0), id="green"),
    pytest.param((0, 0, 255), id="blue"),
    pytest.param((255, 255, 0), id="yellow"),
    pytest.param((255, 1, 0), id="all but red"),
    pytest.param((1, 0, 0), id="all but black"),
    pytest.param((254, 255, 255), id="all but white"),
]


def brightened(colour, factor):
    return brightness.apply(np.array([[colour]], np.float32), Brightness(factor))[0, 0]


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 1.5, 10.0])
@pytest.mark.parametrize("colour", PURE)
def test_brightness_scales_v_to_white_at_most_and_leaves_hue_and_saturation(colour, factor):
    hue, saturation, value = colorsys.rgb_to_hsv(*colour)
    wanted = colorsys.hsv_to_rgb(hue, saturation, min(value * factor, 255))
    np.testing.assert_allclose(brightened(colour, factor), wanted, rtol=0, atol=2 * FLOAT32)


@pytest.mark.parametrize("colour", PURE)
def test_brightness_of_one_is_the_exact_identity_and_of_nought_is_black(colour):
    np.testing.assert_array_equal(brightened(colour, 1.0), colour)
    np.testing.assert_array_equal(brightened(colour, 0.0), 0)


@settings(STEADY, max_examples=200)
@given(st.tuples(*[st.integers(0, 255)] * 3), st.floats(0, 10), st.floats(0, 10))
def test_brightness_is_monotonous_and_keeps_the_order_of_channels(colour, one, other):
    less, more = (brightened(colour, factor) for factor in sorted((one, other)))
    assert (less <= more + 2 * FLOAT32).all()
    assert more.min() >= 0 and more.max() <= 255 + 2 * FLOAT32
    order = np.argsort(colour, kind="stable")
    assert (np.diff(more[order]) >= 0).all()


def added(kind, amount, shape=(*MANY, 1), tone=128, seed=3):
    image = np.full(shape, tone, np.float32)
    return noise.apply(image, Noise(kind, amount, seed)).astype(np.float64) - tone


@pytest.mark.parametrize("amount", [0.5, 1.0, 8.0, 128.0])
@pytest.mark.parametrize(("kind", "kurtosis"), [("gaussian", 3), ("laplacian", 6)])
def test_mean_and_variance_of_noise_are_those_of_theory_at_1e6_samples(kind, kurtosis, amount):
    drawn = added(kind, amount)
    # Standard errors: σ/√N of the mean, σ²·√((κ - 1)/N) of the variance, κ the law's kurtosis. float32 adds 1e-5.
    assert abs(drawn.mean()) < SIGMAS * amount / np.sqrt(drawn.size)
    assert abs(drawn.var() / amount**2 - 1) < SIGMAS * np.sqrt((kurtosis - 1) / drawn.size)


@pytest.mark.parametrize("kind", ["gaussian", "laplacian"])
def test_channels_and_neighbours_are_drawn_apart(kind):
    drawn = added(kind, 6.0, (*MANY, 3))
    pairs = [(drawn[..., 0], drawn[..., 1]), (drawn[..., 1], drawn[..., 2]), (drawn[1:], drawn[:-1])]
    for one, other in [*pairs, (drawn[:, 1:], drawn[:, :-1])]:
        # Products of independent numbers of deviation σ have deviation σ².
        assert abs((one * other).mean()) < SIGMAS * 36 / np.sqrt(one.size)


@pytest.mark.parametrize("share", [0.0, 0.0005, 0.01, 0.3, 1.0])
def test_salt_and_pepper_hit_their_share_half_white_half_black(share):
    image = np.full((*MANY, 3), 128, np.float32)
    found = noise.apply(image, Noise("salt-and-pepper", share, 3))
    white, black = ((found == level).all(-1).mean() for level in (255, 0))
    # A binomial's standard error; its draws are multiples of 2⁻²⁴.
    error = SIGMAS * np.sqrt(share / 2 * (1 - share / 2) / found[..., 0].size) + 2**-24
    assert abs(white - share / 2) <= error and abs(black - share / 2) <= error
    # Whole pixels, and nothing between.
    assert (found == 128).all(-1).mean() == pytest.approx(1 - white - black, abs=1e-12)


def test_salt_and_pepper_on_more_than_all_pixels_is_refused():
    with pytest.raises(ValueError, match="0 to 1 for salt-and-pepper"):
        Noise("salt-and-pepper", 1.5, 0)


@pytest.mark.parametrize("amount", [1.0, 4.0])
def test_bytes_have_the_noise_s_mean_and_its_variance_plus_a_twelfth(amount):
    image = quantise(128 + added("gaussian", amount)).astype(np.float64)
    n = image.size
    # Sheppard: rounding adds the variance of an even spread over a level, and nothing to the mean; what is left out is
    # of the order exp(-2π²σ²), 3e-9 at σ = 1.
    variance = amount**2 + 1 / 12
    assert abs(image.mean() - 128) < SIGMAS * np.sqrt(variance / n)
    assert abs(image.var() / variance - 1) < SIGMAS * np.sqrt(2 / n)


@pytest.mark.parametrize(("kind", "mean"), [("gaussian", 1 / np.sqrt(2 * np.pi)), ("laplacian", 1 / np.sqrt(8))])
@pytest.mark.parametrize("tone", [0, 255])
def test_noise_on_black_and_white_is_cut_off_and_does_not_wrap(kind, mean, tone):
    sigma = 10.0
    levels = quantise(tone + added(kind, sigma, tone=tone)).astype(np.float64)
    # The half that leaves the range is cut off. The other half has the mean E|x|/2: σ/√(2π), or σ/√8 for Laplace; its
    # deviation is below σ, and rounding near the cut adds up to 1/24 level. One wrapped pixel in 1,000 would add 0.25.
    away = np.abs(levels - tone)
    assert abs(away.mean() - sigma * mean) < SIGMAS * sigma / np.sqrt(levels.size) + 1 / 24
    # Beyond 14 deviations there is nothing in 10⁶ draws: e^(-14·√2) is 2.5e-9.
    assert away.max() < 14 * sigma
    # Half are cut off, and those that round to the tone itself.
    assert (away == 0).mean() > 0.5


def test_rounding_has_no_bias_on_any_level():
    rng = np.random.default_rng(0)
    values = rng.uniform(0, 255, 1_000_000)
    # The error is spread evenly over ±1/2: deviation 1/√12.
    assert abs((quantise(values) - values).mean()) < SIGMAS / np.sqrt(12 * values.size)


def test_rounding_has_no_bias_on_halves():
    halves = np.arange(255) + 0.5
    # To even: up and down in turn, so that all but one cancel. Upwards always, the mean would be a half.
    assert abs((quantise(halves) - halves).sum()) <= 0.5
    assert abs((quantise(halves.astype(np.float32)) - halves).sum()) <= 0.5


def test_rounding_leaves_whole_levels_as_they_are():
    levels = np.arange(256)
    for kind in (np.float32, np.float64, np.uint8, np.int64):
        np.testing.assert_array_equal(quantise(levels.astype(kind)), levels)


@settings(STEADY, max_examples=300)
@given(arrays(np.float64, 20, elements=st.floats(-1e300, 1e300)))
def test_bytes_never_wrap(values):
    ordered = np.sort(values)
    levels = quantise(ordered)
    assert levels.dtype == np.uint8
    assert (np.diff(levels.astype(int)) >= 0).all()
    assert (np.abs(levels - np.clip(ordered, 0, 255)) <= 0.5).all()


def test_bytes_of_infinities_are_black_and_white():
    np.testing.assert_array_equal(quantise(np.array([-np.inf, -0.5, 255.5, np.inf])), [0, 0, 255, 255])


@settings(STEADY, max_examples=200)
@given(arrays(np.float64, (5, 3), elements=st.floats(-10, 1e6)))
def test_light_beyond_white_keeps_its_hue(colours):
    found = within_gamut(colours, 1.0)
    assert found.min() >= 0 and found.max() <= 1 + 1e-15
    lit = np.maximum(colours, 0)
    # A colour and what is left of it are multiples of each other.
    assert np.abs(np.cross(found, lit)).max() <= 1e-12 * max(1.0, lit.max())
    assert (quantise(to_display(found)) <= 255).all()


EXTREMES = {
    "white made brighter": (255, {"brightness": Brightness(10.0)}, (255, 255)),
    "black made brighter": (0, {"brightness": Brightness(10.0)}, (0, 0)),
    "white in noise": (255, {"noise": Noise("gaussian", 8.0, 1)}, (200, 255)),
    "black in noise": (0, {"noise": Noise("laplacian", 8.0, 1)}, (0, 120)),
    "white brighter in noise": (255, {"brightness": Brightness(1.5), "noise": Noise("gaussian", 8.0, 1)}, (200, 255)),
    "white made dark": (255, {"brightness": Brightness(0.0)}, (0, 0)),
}


@pytest.mark.parametrize(("tone", "effects", "within"), EXTREMES.values(), ids=EXTREMES)
def test_images_of_black_and_white_do_not_wrap(tone, effects, within):
    on = plate(Frame(60, 50), tone)
    scene = attrs.evolve(row(on, n=0), **effects)
    image = compose(scene, plan(scene), on, None)
    # 50·60·3 draws stay within 7 deviations of a normal law, and 15 of Laplace's.
    assert within[0] <= image.min() and image.max() <= within[1]


@pytest.mark.parametrize("method", ["reflectance", "normal", "mixed", "alpha"])
@pytest.mark.parametrize("tone", [0, 255])
def test_white_paint_with_every_step_does_not_wrap(method, tone):
    frame = Frame(60, 50)
    on = plate(frame, tone)
    colour = 100.0 if method == "reflectance" else 1.0
    decals = np.zeros((50, 60, 4), np.float32)
    decals[20:26] = (colour, colour, colour, 1)
    effects = {"optics": Optics(((1.0,),)), "brightness": Brightness(1.5), "noise": Noise("gaussian", 3.0, 1)}
    scene = attrs.evolve(row(on, n=1), blend=Blend(method), **effects)
    image = compose(scene, plan(scene), on, Layers(decals))
    middle = image[22:24].astype(int)
    if tone == 255 or method != "reflectance":
        # White stays white but for the noise: 360 draws stay within five deviations.
        assert middle.min() >= 255 - 15
    else:
        # A hundred times as bright as a black byte, which says half a level: 100·LINEAR[1]/2, less that half.
        asked = 1.5 * to_display(99 * LINEAR[1] / 2)
        assert np.abs(middle.mean() - asked) < 3


def test_a_camera_in_the_dark_and_in_glare_does_not_wrap():
    camera = attrs.evolve(sensor.sample(np.random.default_rng(0), 1.0, 0.2), quality=100)
    used = np.ones((64, 64), bool)
    dark, dim, lit, glare = (
        sensor.develop(np.full((64, 64, 3), light, np.float32), used, camera).astype(int)
        for light in (0.0, 1e-12, 1.0, 1e9)
    )
    # Below 0.0031 sRGB is a line of slope 13: read noise of 0.003 is 10 levels, five deviations of it, sharpened, 100.
    assert max(dark.max(), dim.max()) <= 100
    # Exposure is automatic: a billion times the light is the same picture, but for float32.
    assert np.abs(glare - lit).max() <= 2
    # An edge from nothing to a thousand times the exposure, sharpened: no dark pixel amid the light, nor the reverse.
    half = np.zeros((64, 64, 3), np.float32)
    half[:, 32:] = 1
    glaring = attrs.evolve(camera, target=500.0, shot=0.0, read=0.0, chroma=0.0, vignette=0.0)
    image = sensor.develop(half, used, glaring)
    assert image[:, 36:].min() >= 250
    assert image[:, :28].max() <= 5


@pytest.mark.parametrize("tone", [0, 255])
def test_training_pictures_of_black_and_white_do_not_wrap(tone):
    image = np.full((64, 64, 3), tone, np.uint8)
    for seed in range(60):
        found = taken(np.random.default_rng(seed), image).astype(int)
        if tone == 0:
            # Black times any gain is black. Noise of at most 5 levels, a sixth of it blurred by JPEG.
            assert found.max() <= 40
        else:
            # One light for all, whatever its gain: nothing but noise and JPEG tells pixels apart.
            assert np.ptp(found.reshape(-1, 3), axis=0).max() <= 80


def test_training_pictures_of_the_segmenter_do_not_wrap():
    segmenter = pytest.importorskip("pavemark.training.segmenter", reason="torch is not installed")
    view = np.zeros((480, 480, 4), np.uint8)
    view[..., :3] = 255 * (np.indices((480, 480)) // 40).sum(0)[..., None] % 510
    for seed in range(20):
        image, bits = segmenter.augmented(view, np.random.default_rng(seed))
        assert np.isfinite(image).all() and image.min() >= 0 and image.max() <= 1
        assert set(np.unique(bits)) == {0}


@pytest.mark.parametrize("level", [-50.0, 0.0, 254.6, 255.0, 255.49, 300.0])
def test_fills_of_crops_do_not_wrap(level):
    image = np.full((200, 300, 3), 128, np.uint8)
    hole = np.zeros((200, 300), bool)
    hole[90:100] = True
    found = filled_in_crops(image, hole, 192, lambda image, hole: np.full(image.shape, level, np.float32))
    # Weights add up to one only to rounding: 255.0000001 must not be 0.
    np.testing.assert_array_equal(found[hole], round(min(max(level, 0.0), 255.0)))
    np.testing.assert_array_equal(found[~hole], 128)


class Overdriven:
    """A network whose output leaves the range on both sides."""

    def run(self, feeds, shape):
        ramp = np.linspace(-3, 4, int(np.prod(shape)), dtype=np.float32).reshape(shape)
        return ramp if feeds["image"].dtype == np.float32 else (255 * np.clip(ramp, 0, 1)).astype(np.uint8)


@pytest.mark.parametrize("name", CONTRACTS)
def test_networks_that_leave_the_range_do_not_wrap(name):
    contract = CONTRACTS[name]
    image, hole = np.full((64, 64, 3), 255, np.uint8), np.zeros((64, 64), bool)
    hole[10:20] = True
    found = contract.fill(Overdriven(), contract.white or 1.0, image, hole)
    assert found.min() >= 0 and found.max() <= 255


@pytest.mark.parametrize("tone", [0, 255])
@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_holes_in_black_and_in_white_are_filled_with_the_same(method, tone):
    image = np.full((100, 110, 3), tone, np.uint8)
    hole = np.zeros((100, 110), bool)
    hole[40:46] = True
    image[hole] = 128
    found = method.fill(image, hole, np.zeros_like(hole)).astype(int)
    # FSR sums waves and converts colours: it may be off by a few levels, but not by way of the other end.
    assert np.abs(found - tone).max() <= 4


@pytest.mark.parametrize("count", [255, 256])
def test_slot_numbers_beyond_a_byte_do_not_wrap(count):
    scene = row(plate(Frame(600, 60, 60)), n=count, entrance=0.03, depth=0.5, start=(-5.0, -0.3), heading=0.0)
    found = masks.slots(truth(scene, np.ones((60, 600), bool)))
    # Slots of 1.8 pixels: each has a pixel that it covers by half.
    assert set(np.unique(found)) == set(range(count + 1))
    assert found.dtype == (np.uint8 if count == 255 else np.uint16)


def casts(tree):
    """Lines on which a number that was computed becomes a byte without rounding and clipping: a wrap-around to come."""
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "astype"):
            continue
        if not node.args or ast.unparse(node.args[0]) not in ("np.uint8", "'uint8'"):
            continue
        given = node.func.value
        arithmetic = isinstance(given, ast.BinOp) and not isinstance(given.op, ast.Mod | ast.BitAnd | ast.BitOr)
        rounded = isinstance(given, ast.Call) and ast.unparse(given.func) in ("np.rint", "np.clip", "np.round")
        if arithmetic or rounded:
            yield node.lineno


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_levels_become_bytes_in_one_place(path):
    """In `colour.quantise`, which the tests above hold to what it promises."""
    allowed = 1 if path == PACKAGE / "colour.py" else 0
    assert len(list(casts(ast.parse(path.read_text())))) == allowed


@pytest.mark.parametrize(
    "line", ["(x * 255).astype(np.uint8)", "np.rint(x).astype(np.uint8)", "(a + b).astype('uint8')"]
)
def test_the_rule_finds_what_it_forbids(line):
    assert list(casts(ast.parse(line)))
