import cv2
import numpy as np
import OpenImageIO as oiio
import pytest

from pavemark.accuracy.measures import flip, psnr, ssim, step, texture

RNG = np.random.default_rng(8)
TRUTH = np.clip(cv2.GaussianBlur(RNG.normal(120, 40, (60, 70, 3)), (0, 0), 0.7), 0, 255).astype(np.uint8)
HOLE = np.zeros((60, 70), bool)
HOLE[20:44, 15:50] = True
HOLE[44:48, 30:35] = True
EVERYWHERE = np.ones_like(HOLE)
needs_flip = pytest.mark.skipif(not hasattr(oiio.ImageBufAlgo, "FLIP_diff"), reason="this OpenImageIO has no FLIP")


def filled(values) -> np.ndarray:
    """The truth with other values in the hole."""
    fill = TRUTH.copy()
    fill[HOLE] = np.clip(values, 0, 255)[HOLE] if np.ndim(values) == 3 else values
    return fill


def test_the_truth_itself_is_perfect():
    assert psnr(TRUTH, TRUTH, HOLE) == float("inf")
    assert ssim(TRUTH, TRUTH, HOLE) == 1.0
    assert texture(TRUTH, TRUTH, HOLE) == 1.0
    assert step(TRUTH, TRUTH, HOLE, EVERYWHERE) == 0.0


@pytest.mark.parametrize("shift", [1, 8, 40])
def test_a_constant_shift_has_the_psnr_of_its_formula(shift):
    assert psnr(filled(TRUTH.astype(int) + shift), TRUTH, HOLE) == pytest.approx(20 * np.log10(255 / shift), abs=1e-12)


def test_psnr_is_of_the_hole_and_all_its_channels():
    fill = TRUTH.copy()
    fill[~HOLE] = 0
    fill[..., 1] = np.where(HOLE, fill[..., 1] + 6, 0)
    assert psnr(fill, TRUTH, HOLE) == pytest.approx(10 * np.log10(3 * 255**2 / 36), abs=1e-12)


def windowed_ssim(x, y):
    """SSIM of one pair of windows, written out."""
    x, y = x.astype(float).ravel(), y.astype(float).ravel()
    c1, c2 = 6.5025, 58.5225
    covariance = np.cov(x, y, ddof=1)
    return ((2 * x.mean() * y.mean() + c1) * (2 * covariance[0, 1] + c2)) / (
        (x.mean() ** 2 + y.mean() ** 2 + c1) * (covariance[0, 0] + covariance[1, 1] + c2)
    )


def test_ssim_is_that_of_windows_of_seven_pixels():
    fill = filled(RNG.integers(0, 255, TRUTH.shape))
    wanted = [
        windowed_ssim(fill[v - 3 : v + 4, u - 3 : u + 4, c], TRUTH[v - 3 : v + 4, u - 3 : u + 4, c])
        for v, u in np.argwhere(HOLE)
        for c in range(3)
    ]
    assert ssim(fill, TRUTH, HOLE) == pytest.approx(np.mean(wanted), abs=1e-9)


def test_ssim_leaves_out_windows_that_reach_beyond_the_picture():
    hole = np.zeros((20, 20), bool)
    hole[:3] = True
    truth = RNG.integers(0, 255, (20, 20, 3)).astype(np.uint8)
    assert np.isnan(ssim(truth, truth, hole))
    hole[3, 10] = True
    fill = truth.copy()
    fill[3, 10] = 0
    wanted = np.mean([windowed_ssim(fill[:7, 7:14, c], truth[:7, 7:14, c]) for c in range(3)])
    assert ssim(fill, truth, hole) == pytest.approx(wanted, abs=1e-9)


def uniform_flip(a, b):
    """LDR-FLIP of two uniform pictures, from the paper: no filter and no edge has a part in it."""
    to_xyz = np.array(
        [
            [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
            [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
            [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
        ]
    )

    def hunt(linear):
        x = to_xyz @ linear / to_xyz.sum(1)
        f = np.where(x > (6 / 29) ** 3, np.cbrt(x), x * (29 / 6) ** 2 / 3 + 4 / 29)
        lightness = 116 * f[1] - 16
        return np.array([lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])])

    def distance(p, q):
        return (abs(p[0] - q[0]) + np.hypot(*(p - q)[1:])) ** 0.7

    most = distance(hunt(np.array([0.0, 1, 0])), hunt(np.array([0, 0, 1.0])))
    error, bend = distance(hunt(a), hunt(b)), 0.4 * most
    return 0.95 * error / bend if error < bend else 0.95 + 0.05 * (error - bend) / (most - bend)


@needs_flip
@pytest.mark.parametrize(("a", "b"), [((128, 128, 128), (153, 153, 153)), ((51, 76, 102), (102, 76, 51))])
def test_flip_sees_linear_light(a, b):
    first, second = (np.full((40, 40, 3), colour, np.uint8) for colour in (a, b))

    def linear(colour):
        share = np.array(colour) / 255
        return ((share + 0.055) / 1.055) ** 2.4

    assert flip(first, second, np.ones((40, 40), bool)) == pytest.approx(uniform_flip(linear(a), linear(b)), abs=5e-4)


@needs_flip
def test_flip_is_of_the_hole():
    assert flip(TRUTH, TRUTH, HOLE) == 0.0
    near, far = (flip(filled(TRUTH.astype(int) + shift), TRUTH, HOLE) for shift in (4, 40))
    assert 0 < near < far < 1
    far_off = np.zeros_like(HOLE)
    far_off[:5] = True
    assert flip(filled(TRUTH.astype(int) + 40), TRUTH, far_off) == 0.0
    assert flip(filled(TRUTH.astype(int) + 40), TRUTH, EVERYWHERE) < far


def test_a_blur_lacks_texture_and_noise_has_too_much():
    blurred = texture(filled(cv2.GaussianBlur(TRUTH, (0, 0), 2.0)), TRUTH, HOLE)
    rough = texture(filled(TRUTH + RNG.normal(0, 60, TRUTH.shape)), TRUTH, HOLE)
    assert blurred < 0.5
    assert rough > 1.3
    # Psnr alone would have it the other way about.
    other = filled(np.roll(TRUTH, 17, axis=1))
    assert 0.9 < texture(other, TRUTH, HOLE) < 1.1
    assert psnr(other, TRUTH, HOLE) < psnr(filled(cv2.GaussianBlur(TRUTH, (0, 0), 2.0)), TRUTH, HOLE)


def test_texture_of_half_the_contrast_is_half():
    wave = np.zeros((60, 70))
    wave[:] = 40 * np.sin(np.arange(70) * np.pi / 2 + 0.3)
    truth, half = ((120 + share * wave)[..., None].repeat(3, 2).astype(np.uint8) for share in (1, 0.5))
    inner = np.zeros_like(HOLE)
    inner[20:40, 20:40] = True
    assert texture(half, truth, inner) == pytest.approx(0.5, abs=0.02)
    assert np.isnan(texture(truth, np.full_like(truth, 90), inner))


def test_a_seam_is_as_high_as_it_was_made():
    flat = np.full((60, 70, 3), 100, np.uint8)
    fill = flat.copy()
    fill[HOLE] = 112
    assert step(fill, flat, HOLE, EVERYWHERE) == pytest.approx(12, abs=1e-6)
    assert step(flat, flat, HOLE, EVERYWHERE) == 0.0


def test_a_slope_that_runs_on_is_no_seam_and_one_that_breaks_off_is():
    slope = np.zeros((60, 70, 3), np.uint8) + (2 * np.arange(70)[:, None] + 20).astype(np.uint8)
    level = slope.copy()
    level[HOLE] = slope[HOLE].mean()
    assert step(slope, slope, HOLE, EVERYWHERE) == 0.0
    assert step(level, slope, HOLE, EVERYWHERE) > 10


def test_the_rim_beside_what_is_kept_out_does_not_count():
    flat = np.full((60, 70, 3), 100, np.uint8)
    fill, beside = flat.copy(), EVERYWHERE.copy()
    beside[:, 50:] = False
    fill[HOLE] = 100
    fill[:, 45:50][HOLE[:, 45:50]] = 200
    beside[:20] = beside[44:] = False
    assert step(fill, flat, HOLE, beside) == pytest.approx(0, abs=1e-6)
    assert np.isnan(step(fill, flat, HOLE, np.zeros_like(HOLE)))
