"""Proof by counting: an effect that is off has no node, datablock, pass, buffer, solver call or random number.

What a scene uses is counted while it is made. Two effects use what each uses alone, and nothing else; and what one of
them draws is the same with the other as without.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter

import attrs
import numpy as np
import pytest

from pavemark import colour
from pavemark.compose import blend, brightness, glare, image, light, noise, optics, poisson
from pavemark.geometry import elastic, outline, sheet
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.light import Caster, Glare, Relief, Shadows, Sun, Tube, Wet
from pavemark.plan import LIGHT, PAINT_EFFECTS, plan
from pavemark.scene import (
    Area,
    Blend,
    Brightness,
    Chips,
    Cracks,
    Curvature,
    Dirt,
    Grain,
    Marking,
    Noise,
    Optics,
    Paint,
    Pattern,
    Scene,
    Tyres,
    Wear,
)
from scenes import plate

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon.stage import Stage  # noqa: E402 - needs bpy

FRAME = Frame(48, 48, 12)
PLATE = plate(FRAME, tone=100, texture=6)
EYES = ((0.0, 0.0, 1.0),)
SUN = Sun(math.pi, 0.6)

PAINTED = {
    "grain": Grain(0.3, 0.4, 1.0),
    "wear": Wear(0.4, 0.1, 0.3, 0.5, 0.4, 2.0),
    "chips": Chips(0.4, 0.2, 3.0),
    "cracks": Cracks(0.5, 0.08, 4.0),
    "dirt": Dirt(0.5, 0.6, 5.0),
    "pattern": Pattern("checks", 0.5, 0.3, 0.7, 6.0),
}
WHOLE = {
    "tyres": Tyres((((-2.0, 0.3), (2.0, 0.3)),), 0.3),
    "curvature": Curvature(150.0, 0.5, 7),
    "optics": Optics(((1.0, 1.4), (0.8, 1.2))),
    "relief": Relief(0.02, 0.02, SUN, 0.3),
    "shadows": Shadows((0.4,) * 3, sun=SUN, casters=(Caster("pole", (-2.5, 0.2), (0.5, 0.5, 2.0)),)),
    "wet": Wet(0.5, 0.5, 0.8, 0.4, (1.0,) * 3, (0.1,) * 3, 0.2, EYES, 8.0),
    "glare": Glare((Tube((0.3, 0.5, 3.0), 1.0, 0.2, 0.0, (30.0,) * 3),), 0.3, 0.05, EYES),
    "brightness": Brightness(0.8),
    "noise": Noise("gaussian", 5.0, 9),
}
EFFECTS = (*PAINTED, *WHOLE)
BOTH = tuple(itertools.combinations(EFFECTS, 2))

TOGETHER = ({"tyres", "wear"}, {"tyres", "dirt"})
"""Tyres do nothing by themselves: they say where wear and dirt are, which then count them."""


def test_every_effect_is_here():
    assert set(PAINTED) == set(PAINT_EFFECTS)
    listed = {field.name for field in attrs.fields(Scene) if field.default is None}
    assert set(WHOLE) == listed - {"blend"}
    assert set(LIGHT) < set(WHOLE)


def scene(*effects: str) -> Scene:
    paint = Paint((210.0,) * 3, (2.2, 2.2, 2.1), **{name: PAINTED[name] for name in effects if name in PAINTED})
    square = Area(((-1.2, -1.0), (1.2, -1.0), (1.2, 1.0), (-1.2, 1.0)))
    whole = {name: WHOLE[name] for name in effects if name in WHOLE}
    return Scene(0, PLATE.ref, (Marking("slot", paint, areas=(square,)),), blend=Blend(), **whole)


REMEMBERED = (outline.outline, elastic.longest_chord, elastic._field, sheet._exposure)
"""What is computed once for several scenes, and has to be computed for each to be counted."""


@attrs.frozen(eq=False)
class Made:
    """What making a scene used, what was drawn, and the picture before it was rounded."""

    used: Counter
    layers: Layers
    image: np.ndarray


class Watched:
    """Makes scenes and counts."""

    def __init__(self, renderer, monkeypatch):
        self.renderer, self.used = renderer, Counter()
        self.made: dict[frozenset, Made] = {}
        self.before = frozenset()
        for module, name in (
            (blend, "apply"),
            (optics, "apply"),
            (brightness, "apply"),
            (noise, "apply"),
            *((light, effect) for effect in LIGHT),
            (light, "gleam"),
            (poisson, "solve"),
            (elastic, "_field"),
            (sheet, "_exposure"),
            (sheet, "_edge_distance"),
        ):
            self._count(monkeypatch, module, name, f"call {module.__name__.split('.')[-1]}.{name}")
        self._count(monkeypatch, np.random, "PCG64", "random numbers")
        monkeypatch.setattr(image, "quantise", lambda levels: levels)
        rendered, keep, clear = renderer._rendered, Stage.keep, Stage.clear

        def counted(*arguments):
            self.used["pass"] += 1
            return rendered(*arguments)

        def kept(stage, data):
            self.used[f"datablock {type(data).__name__}"] += 1
            return keep(stage, data)

        def cleared(stage):
            # Before it is torn down: every node of every tree that the stage's materials reach.
            trees = [material.node_tree for material in bpy.data.materials]
            for tree in trees:
                for node in tree.nodes:
                    label = node.node_tree.name if node.bl_idname == "ShaderNodeGroup" else node.bl_idname
                    self.used[f"node {label}"] += 1
            clear(stage)

        monkeypatch.setattr(renderer, "_rendered", counted)
        monkeypatch.setattr(Stage, "keep", kept)
        monkeypatch.setattr(Stage, "clear", cleared)

    def _count(self, monkeypatch, module, name, label):
        whole = getattr(module, name)

        def counting(*arguments, **named):
            self.used[label] += 1
            return whole(*arguments, **named)

        monkeypatch.setattr(module, name, counting)

    def __call__(self, *effects: str) -> Made:
        key = frozenset(effects)
        if key not in self.made:
            for remembered in REMEMBERED:
                remembered.cache_clear()
            self.used.clear()
            asked = scene(*effects)
            todo = plan(asked)
            layers = self.renderer.render(asked, PLATE, todo)
            buffers = [field.name for field in attrs.fields(Layers) if getattr(layers, field.name) is not None]
            picture = image.compose(asked, todo, PLATE, layers)
            self.used.update(f"buffer {name}" for name in buffers)
            self.made[key] = Made(Counter(self.used), layers, picture)
        return self.made[key]


@pytest.fixture(scope="module")
def made(renderer):
    with pytest.MonkeyPatch.context() as monkeypatch:
        yield Watched(renderer, monkeypatch)


MARKS = {
    **{name: {f"node Pavemark {name}"} for name in ("grain", "wear", "chips", "cracks", "dirt")},
    "pattern": {"node Pavemark checks pattern"},
    "curvature": {"call elastic._field"},
    "optics": {"call optics.apply"},
    "relief": {"buffer relief", "call light.relief"},
    "shadows": {"buffer shadows", "call light.shadows"},
    "wet": {"buffer wet", "call light.wet", "node ShaderNodeTexNoise"},
    "glare": {"call light.glare", "call light.gleam"},
    "brightness": {"call brightness.apply"},
    "noise": {"call noise.apply"},
}
"""What an effect uses that no other does."""


@pytest.mark.parametrize("effect", EFFECTS)
def test_an_effect_uses_something_of_its_own(made, effect):
    own = made(effect).used - made().used
    assert MARKS.get(effect, set()) <= own.keys()
    assert own or effect == "tyres"
    others = {mark for other, marks in MARKS.items() if other != effect for mark in marks}
    assert not others & own.keys()


@pytest.mark.parametrize("pair", BOTH, ids="+".join)
def test_two_effects_use_what_each_uses_alone(made, pair):
    one, other = (made(effect).used - made().used for effect in pair)
    wanted = made().used + one + other
    used = made(*pair).used
    if set(pair) in TOGETHER:
        assert used - wanted == Counter({"call sheet._exposure": 1})
    else:
        assert used == wanted


@pytest.mark.parametrize("pair", BOTH, ids="+".join)
def test_switching_one_off_changes_no_pixel_of_the_other(made, pair):
    both = made(*pair).layers
    for effect, other in (pair, pair[::-1]):
        alone, without = made(effect).layers, made(other).layers
        if effect in ("relief", "shadows", "wet"):
            if other == "curvature" and effect == "relief":
                continue  # Relief is that of the bent outline.
            np.testing.assert_array_equal(getattr(both, effect), getattr(alone, effect))
        elif effect in PAINTED and other in PAINTED:
            # Half floats hold 11 bits, and two are multiplied and one divided here.
            product = both.decals[..., 3] * made().layers.decals[..., 3]
            assert product == pytest.approx(alone.decals[..., 3] * without.decals[..., 3], abs=4 * 2**-11)
        elif effect in PAINTED and other == "curvature":
            # Where the bent outline covers as much, the paint is the same; but for the wear of its rim.
            inside = (without.decals[..., 3] == 1) & (made().layers.decals[..., 3] == 1)
            inside[: FRAME.height // 4], inside[-FRAME.height // 4 :] = False, False
            if effect != "wear":
                np.testing.assert_array_equal(both.decals[inside], alone.decals[inside])
        elif effect in PAINTED and (other != "tyres" or effect not in ("wear", "dirt")):
            np.testing.assert_array_equal(both.decals, alone.decals)


@pytest.mark.parametrize("other", [effect for effect in EFFECTS if effect != "noise"])
def test_noise_is_the_same_noise_whatever_else_is_on(made, other):
    # Both are added up in float32, at levels up to 255.
    with_other = made("noise", other).image - made(other).image
    np.testing.assert_allclose(with_other, made("noise").image - made().image, atol=1e-4)


@pytest.mark.parametrize("other", [effect for effect in EFFECTS if effect not in ("brightness", "noise")])
def test_brightness_is_the_same_factor_whatever_else_is_on(made, other):
    np.testing.assert_allclose(made("brightness", other).image, 0.8 * made(other).image, rtol=1e-5)


@pytest.mark.parametrize("other", [e for e in EFFECTS if e not in ("brightness", "noise", "glare")])
def test_glare_adds_the_same_light_whatever_lies_below(made, other):
    def linear(*effects):
        return colour.to_linear(made(*effects).image.astype(np.float64))

    added = linear("glare", other) - linear(other)
    np.testing.assert_allclose(added, glare.gleam(FRAME, WHOLE["glare"], PLATE.ground), atol=2e-4)


def test_a_scene_that_calls_for_nothing_is_its_plate_and_needs_no_renderer(made):
    empty = Scene(0, PLATE.ref)
    todo = plan(empty)
    assert todo.passes == () and todo.steps == ()
    made.used.clear()
    np.testing.assert_array_equal(image.compose(empty, todo, PLATE, None), PLATE.image)
    assert not made.used


def test_glare_brightness_and_noise_alone_need_no_renderer():
    for effects in itertools.combinations(("glare", "brightness", "noise", "optics"), 2):
        assert plan(Scene(0, PLATE.ref, **{name: WHOLE[name] for name in effects})).passes == ()
