"""Blending on small plates whose right answer is known."""

import attrs
import cv2
import numpy as np
import pytest

from pavemark.colour import LINEAR, LUMINANCE, quantise, to_display, to_linear, within_gamut
from pavemark.compose import blend
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Blend

METHODS = ("reflectance", "normal", "mixed", "alpha")
SIZE = 80
RATIO = (2.2, 2.1, 1.9)
RGB = (225, 220, 190)


def plate(image, ground=None):
    image = np.broadcast_to(np.asarray(image, np.uint8), (SIZE, SIZE, 3)).copy()
    ground = np.ones((SIZE, SIZE), bool) if ground is None else ground
    return Plate("p", Frame(SIZE, SIZE), image, ground, np.zeros((SIZE, SIZE), bool), image)


def line(width=6, method="reflectance", colour=None, opacity=1.0):
    """An upright line in the middle, from border to border."""
    alpha = np.zeros((SIZE, SIZE, 1))
    alpha[:, SIZE // 2 - width // 2 :][:, :width] = opacity
    if colour is None:
        colour = RATIO if method == "reflectance" else LINEAR[list(RGB)]
    return Layers(np.concatenate([alpha * np.asarray(colour), alpha], -1).astype(np.float32))


def blended(on, layers, **settings):
    return quantise(blend.apply(on, layers, Blend(**settings)))


def painted(layers):
    return layers.decals[..., 3] > 0.99


def cross():
    """Lines that touch all borders and a corner, half opaque in places."""
    alpha = np.zeros((SIZE, SIZE), np.float32)
    cv2.line(alpha, (0, 30), (79, 50), 1.0, 5)
    cv2.line(alpha, (40, 0), (30, 79), 0.6, 4)
    alpha[:6, :6] = 1
    return alpha


def textured(seed=0):
    rng = np.random.default_rng(seed)
    return np.clip(110 + rng.normal(0, 14, (SIZE, SIZE, 1)) + rng.normal(0, 3, (SIZE, SIZE, 3)), 0, 255)


@pytest.mark.parametrize("tone", [20, 60, 96, 140, 200])
@pytest.mark.parametrize("width", [6, 3])
@pytest.mark.parametrize("method", METHODS)
def test_colour_is_what_the_scene_asked_for_on_a_flat_plate(method, width, tone):
    layers = line(width, method)
    image = blended(plate(tone), layers, method=method)
    asked = RGB
    if method == "reflectance":
        asked = to_display(within_gamut(LINEAR[tone] * np.array([RATIO]), 1.0))[0]
    assert np.abs(image[painted(layers)] - np.asarray(asked)).max() <= 3


@pytest.mark.parametrize("method", METHODS)
def test_the_middle_of_a_10_cm_line_keeps_its_colour_through_the_edge_blur(method):
    layers = line(6, method)
    image = blended(plate(96), layers, method=method, edge_blur=True)
    asked = to_display(LINEAR[96] * np.array(RATIO)) if method == "reflectance" else RGB
    middle = image[:, SIZE // 2 - 1 : SIZE // 2 + 1]
    assert np.abs(middle - np.asarray(asked)).max() <= 3
    sharp = blended(plate(96), layers, method=method)
    beside = SIZE // 2 - 4
    assert (image[:, beside] > sharp[:, beside]).all()


@pytest.mark.parametrize("edge_blur", [False, True])
@pytest.mark.parametrize("margin", [1, 2, 8])
@pytest.mark.parametrize("method", METHODS)
def test_pixels_outside_the_domain_are_the_plate_s(method, margin, edge_blur):
    on = plate(textured())
    alpha = cross()[..., None]
    layers = Layers(np.concatenate([alpha * 1.7 if method == "reflectance" else alpha * 0.8] * 3 + [alpha], -1))
    image = blended(on, layers, method=method, margin=margin, edge_blur=edge_blur)
    reach = margin + 2 * edge_blur
    near = cv2.dilate((alpha[..., 0] > 0).astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1))) > 0
    assert near.mean() < 0.9
    np.testing.assert_array_equal(image[~near], on.image[~near])
    assert (image[near] != on.image[near]).mean() > 0.2


@pytest.mark.parametrize("method", METHODS)
def test_what_is_not_ground_is_never_touched_and_does_not_bleed(method):
    ground = np.ones((SIZE, SIZE), bool)
    ground[30:50, 36:70] = False
    image = np.full((SIZE, SIZE, 3), 96)
    image[~ground] = 0
    on = plate(image, ground)
    layers = line(6, method)
    whole = blended(plate(96), layers, method=method)
    cut = blended(on, layers, method=method)
    np.testing.assert_array_equal(cut[~ground], on.image[~ground])
    # Paint beside the cut is the paint of an uncut line: the car's black stays out of it. Cloning additionally knows
    # a darker mean ground, which cancels at the boundary all the same.
    assert np.abs(cut[ground].astype(int) - whole[ground]).max() <= 3


@pytest.mark.parametrize("texture", [0.0, 0.4, 1.0])
def test_paint_follows_a_shadow(texture):
    shadow = np.full((SIZE, SIZE, 3), 150)
    shadow[SIZE // 2 :] = 70
    layers = line(6)
    image = blended(plate(shadow), layers, ground_texture=texture)
    ratio = to_linear(image)[painted(layers)] / to_linear(shadow.astype(np.uint8))[painted(layers)]
    ratio = ratio.reshape(SIZE, 6, 3)
    for side in (slice(0, 30), slice(50, 80)):
        assert np.abs(np.median(ratio[side], (0, 1)) / RATIO - 1).max() < 0.05


@pytest.mark.parametrize("texture", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("kind", ["grain", "courses", "slope"])
def test_paint_keeps_its_ratio_on_textured_ground(kind, texture):
    v, u = np.mgrid[:SIZE, :SIZE]
    image = {
        "grain": textured(),
        "courses": np.where((v % 8 < 2)[..., None], 60, 120) * np.ones(3),
        "slope": (60 + u + 0.5 * v)[..., None] * np.ones(3),
    }[kind]
    on = plate(np.rint(image))
    layers = line(6, colour=(1.8, 1.8, 1.8))
    found, ground = (to_linear(i)[painted(layers)] for i in (blended(on, layers, ground_texture=texture), on.image))
    assert np.abs(found.mean(0) / ground.mean(0) / 1.8 - 1).max() < 0.05
    if kind != "courses":
        # Where joints are as dark as these, no one pixel's ratio is the paint's.
        assert np.abs(np.median(found / ground, 0) / 1.8 - 1).max() < 0.05


def test_ground_texture_is_the_share_that_shows():
    on, layers = plate(textured()), line(10, colour=(1.5, 1.5, 1.5))
    inner = np.zeros((SIZE, SIZE), bool)
    inner[:, 37:43] = True

    def contrast(image):
        return np.log(to_linear(image)[inner]).std()

    whole = contrast(on.image)
    shares = [contrast(blended(on, layers, ground_texture=texture)) / whole for texture in (0.0, 0.4, 1.0)]
    assert shares[0] < 0.2
    assert 0.35 < shares[1] < 0.5
    assert abs(shares[2] - 1) < 0.03


def test_full_ground_texture_multiplies_the_light():
    on, layers = plate(textured()), line(6, colour=(1.5, 1.5, 1.5), opacity=0.5)
    image = blended(on, layers, ground_texture=1.0)
    ratio = 1 + 0.5 * (layers.decals[..., 3:] > 0) * 0.5
    # One rounding apart: both sides round the same number, reached on different ways.
    assert np.abs(image - to_display(to_linear(on.image) * ratio)).max() <= 0.51


def test_paint_taken_to_black_by_dirt_stays_finite():
    result = blend.apply(plate(96), line(6, colour=(0, 0, 0)), Blend())
    assert np.isfinite(result).all()
    assert result[40, 40].max() < 10


def test_white_on_a_green_floor_is_white_and_as_bright_as_asked():
    image = blended(plate((40, 120, 70)), line(6, colour=(2.0, 2.0, 2.0)))
    found, ground = LINEAR[image[40, 40]], LINEAR[[40, 120, 70]]
    assert found @ LUMINANCE == pytest.approx(2 * ground @ LUMINANCE, rel=0.05)
    assert np.abs(np.log(found / (found @ LUMINANCE))).max() < np.log(1.3) + 0.02
    assert np.abs(np.log(ground / (ground @ LUMINANCE))).max() > np.log(6)


def test_coloured_light_colours_the_paint():
    ground = LINEAR[[130, 120, 108]]
    image = blended(plate((130, 120, 108)), line(6, colour=(2.0, 2.0, 2.0)))
    assert LINEAR[image[40, 40]] / ground == pytest.approx([2.0] * 3, rel=0.03)


def test_too_much_light_keeps_its_hue():
    image = blended(plate((200, 190, 180)), line(6, colour=(3.0, 3.0, 3.0)))
    found, ground = LINEAR[image[40, 40]], LINEAR[[200, 190, 180]]
    assert image[40, 40, 0] == 255
    assert np.abs(found / found[0] - ground / ground[0]).max() < 0.01


def test_mixed_gradients_show_the_stronger_texture():
    on, layers = plate(textured()), line(10, "mixed")
    inner = (slice(None), slice(37, 43))
    contrast = {m: np.diff(blended(on, layers, method=m)[inner].mean(2), axis=0).std() for m in ("normal", "mixed")}
    assert contrast["mixed"] > 2 * contrast["normal"]


def test_a_marking_too_faint_to_show_changes_nothing():
    on = plate(textured())
    layers = line(6, opacity=0.001)
    for method in METHODS:
        np.testing.assert_array_equal(blended(on, layers, method=method), on.image)


def test_a_marking_as_the_ground_changes_nothing():
    on = plate(96)
    np.testing.assert_array_equal(blended(on, line(6, colour=(1, 1, 1))), on.image)


def test_blending_leaves_its_input_alone_and_repeats_to_the_bit():
    on, layers = plate(textured()), line(6)
    before = on.image.copy(), layers.decals.copy()
    settings = Blend(edge_blur=True)
    first, second = (blend.apply(on, layers, attrs.evolve(settings)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(on.image, before[0])
    np.testing.assert_array_equal(layers.decals, before[1])
