"""Light that Blender simulates: where shadows fall, what rims of paint send back, what puddles mirror."""

import math

import attrs
import numpy as np
import pytest

from pavemark.geometry.mirror import schlick
from pavemark.ground import Frame
from pavemark.light import Caster, Lamp, Relief, Shadows, Sun, Wet
from pavemark.plan import Pass, plan
from pavemark.scene import Area, Marking, Scene
from scenes import WHITE, painted, plate

pytest.importorskip("bpy", reason="the bpy wheel is not installed")

FRAME = Frame(200, 200, 20)
LEFT = (0.4, 0.4, 0.4)
EYES = ((0.0, 0.0, 1.0),)


def drawn(renderer, scene: Scene, name: str, samples: int | None = None) -> np.ndarray:
    """The layer of one pass, with so many rays a pixel in place of the plan's."""
    todo = plan(scene)
    if samples is not None:
        todo = attrs.evolve(todo, passes=tuple(Pass(made.name, samples) for made in todo.passes))
    return getattr(renderer.render(scene, plate(scene.plate.frame), todo), name)


def scene(**effects) -> Scene:
    return Scene(0, plate(FRAME).ref, **effects)


def at(layer: np.ndarray, x: float, y: float) -> float:
    u, v = FRAME.to_image(np.array([x, y]))
    return layer[int(v), int(u), 0]


def test_a_pole_throws_its_shadow_away_from_the_sun_and_as_long_as_the_sun_is_low(renderer):
    sun = Sun(azimuth=math.radians(160), elevation=math.radians(30), angle=0.0)
    pole = Caster("pole", (-5.5, 1.0), (0.4, 0.4, 4.0))
    seen = drawn(renderer, scene(shadows=Shadows(LEFT, sun=sun, casters=(pole,))), "shadows", 16)
    away = -np.array([np.cos(sun.azimuth), np.sin(sun.azimuth)])
    length = 4.0 / math.tan(sun.elevation)
    for metres in (1.0, 4.0, length - 0.4):
        assert at(seen, *(np.array(pole.foot) + metres * away)) == pytest.approx(0, abs=0.01)
    beside = np.array([-away[1], away[0]])
    for point in (
        np.array(pole.foot) + (length + 0.4) * away,
        np.array(pole.foot) + 4.0 * away + 0.35 * beside,
        np.array(pole.foot) + 4.0 * away - 0.35 * beside,
    ):
        assert at(seen, *point) == pytest.approx(1, abs=0.002)
    # Its area, off the two ends: as wide as the pole.
    assert (1 - seen).sum() / 20**2 == pytest.approx(0.4 * (length - 0.53), abs=0.15)


def test_half_shadows_are_as_wide_as_the_sun_and_grow_with_the_way(renderer):
    sun = Sun(azimuth=0.0, elevation=math.radians(45), angle=0.1)
    # The rim of a roof lies across the light; its shadow's rim is soft over height · angle / sin² of the elevation.
    roof = Caster("roof", (6.0, 0.0), (4.0, 30.0, 3.0))
    seen = drawn(renderer, scene(shadows=Shadows(LEFT, sun=sun, casters=(roof,))), "shadows", 256)[100, :, 0]
    soft = ((seen > 0.02) & (seen < 0.98)).sum() / 20
    # Between 2 % and 98 % of a disc's area lies 0.87 of its width.
    assert soft == pytest.approx(0.87 * 3.0 * 0.1 / 0.5, rel=0.15)


def test_level_ground_sees_a_lamp_whole_and_things_hide_it(renderer):
    lamp = Lamp((-7.0, 0.0, 4.0), 0.05)
    post = Caster("pole", (-5.5, 0.0), (0.3, 0.3, 2.0))
    seen = drawn(renderer, scene(shadows=Shadows(LEFT, lamp=lamp, casters=(post,))), "shadows", 16)
    tip = -7.0 + 1.5 * 4.0 / (4.0 - 2.0)
    assert at(seen, tip - 0.5, 0.0) == pytest.approx(0, abs=0.02)
    # Straight beyond the tip, and all about: the lamp's own fading is evened out.
    for point in ((tip + 0.6, 0.0), (4.9, 4.9), (-4.9, -4.9), (0.0, 1.5)):
        assert at(seen, *point) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("kind", ["tree", "pole", "car", "roof"])
def test_every_caster_shades_about_what_its_box_would(renderer, kind):
    size = {"tree": (3, 3, 5), "pole": (0.3, 0.3, 5), "car": (4.5, 1.8, 1.5), "roof": (6, 5, 2.5)}[kind]
    sun = Sun(azimuth=math.pi, elevation=math.radians(25), angle=0.0)
    foot = (-5.0 - size[0] / 2 - 0.2, 0.3)
    caster = Caster(kind, foot, tuple(map(float, size)), seed=3)
    seen = drawn(renderer, scene(shadows=Shadows(LEFT, sun=sun, casters=(caster,))), "shadows", 4)
    dark = seen[..., 0] < 0.5
    rows, columns = np.nonzero(dark)
    width = (rows.max() - rows.min() + 1) / 20
    reach = (columns.max() + 1) / 20 - 5
    assert dark.sum() > 40
    # A tree's boughs may stand out of its box.
    assert width <= size[1] * (1.45 if kind == "tree" else 1.02) + 0.1
    assert reach == pytest.approx(min(5.0, foot[0] + size[0] / 2 + size[2] / math.tan(sun.elevation)), abs=1.6)


def test_a_tree_lets_some_light_through_and_grows_from_its_seed(renderer):
    sun = Sun(azimuth=math.pi, elevation=math.radians(40))
    trees = [Caster("tree", (-7.5, 0.0), (5.0, 5.0, 8.0), seed=seed) for seed in (1, 1, 2)]
    one, again, other = (
        drawn(renderer, scene(shadows=Shadows(LEFT, sun=sun, casters=(tree,))), "shadows") for tree in trees
    )
    np.testing.assert_array_equal(one, again)
    assert (one != other).any()
    crown = one[80:120, 40:90, 0]
    assert 0.02 < (crown > 0.5).mean() < 0.6


def test_things_whose_shadows_miss_the_frame_cost_no_render_and_change_nothing(renderer, monkeypatch):
    monkeypatch.setattr(renderer, "_rendered", lambda *_: pytest.fail("rendered"))
    sun = Sun(azimuth=0.0, elevation=0.5)
    far = Caster("pole", (-9.0, 0.0), (0.2, 0.2, 5.0))
    for casters in ((), (far,)):
        assert (drawn(renderer, scene(shadows=Shadows(LEFT, sun=sun, casters=casters)), "shadows") == 1).all()


def raised(relief: Relief, height: float = 0.3) -> Scene:
    """A square of paint, 4 m a side, in a frame of 200 pixels a metre about its right and left rims."""
    square = Area(((-0.2, -2.0), (0.2, -2.0), (0.2, 2.0), (-0.2, 2.0)))
    return attrs.evolve(painted(Frame(160, 16, 200), Marking("slot", WHITE, areas=(square,))), relief=relief)


def test_rims_of_raised_paint_send_back_what_the_law_of_cosines_says(renderer):
    sun = Sun(azimuth=0.0, elevation=math.radians(35), angle=0.0)
    relief = Relief(0.02, 0.02, sun, 0.0)
    light = drawn(renderer, raised(relief), "relief", 256)[8, :, 0]
    metres = (np.arange(160) + 0.5) / 200 - 0.4
    assert light[np.abs(metres) < 0.15] == pytest.approx(1, abs=0.005)
    assert light[metres > 0.22] == pytest.approx(1, abs=0.005)
    # A slope of 45° towards the sun: cos(10°) over sin(35°), on as much ground as the bevel is wide.
    facing = (light[metres > 0.15] - 1).sum() / 200
    assert facing == pytest.approx(0.02 * (math.cos(math.radians(10)) / math.sin(sun.elevation) - 1), rel=0.02)
    # The other slope is steeper than the sun: from its upper edge on, all lies in the shadow of that edge.
    hidden = (1 - light[metres < -0.15]).sum() / 200
    assert hidden == pytest.approx(0.02 / math.tan(sun.elevation), rel=0.02)


def test_a_slope_that_the_sun_still_reaches_is_only_darker(renderer):
    sun = Sun(azimuth=0.0, elevation=math.radians(70), angle=0.0)
    light = drawn(renderer, raised(Relief(0.02, 0.02, sun, 0.0)), "relief", 256)[8, :, 0]
    metres = (np.arange(160) + 0.5) / 200 - 0.4
    lost = (1 - light[metres < -0.15]).sum() / 200
    assert lost == pytest.approx(0.02 * (1 - math.cos(math.radians(65)) / math.sin(sun.elevation)), rel=0.03)


def test_coats_that_lie_on_each_other_do_not_shade_each_other(renderer):
    relief = Relief(0.02, 0.02, Sun(azimuth=0.0, elevation=0.6, angle=0.01), 0.0)
    one = raised(relief)
    once, twice = (drawn(renderer, attrs.evolve(one, markings=one.markings * n), "relief", 16) for n in (1, 2))
    np.testing.assert_allclose(twice, once, atol=0.01)


def test_puddles_mirror_the_sky_as_steeply_as_they_are_seen(renderer):
    ground = Wet(0.97, 1.0, 1.0, 0.5, (0.8, 0.9, 1.0), (0.1,) * 3, 0.0, EYES, 3.0)
    layer = drawn(renderer, scene(wet=ground), "wet")
    pool = layer[..., 3] > 0.999
    away = np.linalg.norm(FRAME.pixel_centres(), axis=-1)
    wanted = schlick(1 / np.hypot(away, 1.0), 0.02)
    # Near the horizon the sky gives way to what stands around; above 15° there is none of it.
    clear = pool & (away < 1 / math.tan(math.radians(15)))
    full = np.isclose(layer[..., 1], 0.9 * wanted, rtol=0.01)
    assert full[clear].mean() > 0.9
    assert layer[clear & full][:, 0] == pytest.approx(layer[clear & full][:, 1] * 0.8 / 0.9, rel=5e-3)


def test_things_around_hide_the_sky_at_grazing_angles(renderer):
    ground = Wet(0.97, 1.0, 1.0, 0.5, (1.0,) * 3, (0.0,) * 3, 0.3, EYES, 3.0)
    layer = drawn(renderer, scene(wet=ground), "wet")
    away = np.linalg.norm(FRAME.pixel_centres(), axis=-1)
    wet = layer[..., 3] > 0.999
    assert (layer[wet & (away > 6.5)][:, 1] < 0.01).all()
    assert (layer[wet & (away < 0.5)][:, 1] > 0.005).all()


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_so_much_of_the_ground_is_wet(renderer, share):
    shares = []
    for seed in range(6):
        ground = Wet(share, 0.3, 0.4, 0.5, (1.0,) * 3, (0.1,) * 3, 0.2, EYES, 100.0 * seed)
        shares.append(drawn(renderer, scene(wet=ground), "wet")[..., 3].mean())
    # Patches of 0.4 m on 10 m: 600 of them, so a share is off by a fiftieth or so, and the noise's evenness by as much.
    assert np.mean(shares) == pytest.approx(share, abs=0.04)


def test_no_share_no_puddles(renderer, monkeypatch):
    monkeypatch.setattr(renderer, "_rendered", lambda *_: pytest.fail("rendered"))
    ground = Wet(0.0, 0.3, 0.4, 0.5, (1.0,) * 3, (0.1,) * 3, 0.2, EYES, 1.0)
    assert (drawn(renderer, scene(wet=ground), "wet") == 0).all()


def test_nothing_of_light_is_left_behind(renderer):
    import bpy  # noqa: PLC0415 - needs the wheel

    kinds = ("objects", "meshes", "curves", "materials", "images", "cameras", "collections", "lights", "worlds")
    ground = Wet(0.5, 0.3, 0.4, 0.5, (1.0,) * 3, (0.1,) * 3, 0.2, EYES, 1.0)
    pole = Caster("pole", (-5.5, 1.0), (0.4, 0.4, 4.0))
    whole = attrs.evolve(
        raised(Relief(0.02, 0.02, Sun(0.0, 0.6), 0.0)),
        wet=ground,
        shadows=Shadows(LEFT, sun=Sun(math.pi, 0.5), casters=(pole,)),
    )
    before = {kind: len(getattr(bpy.data, kind)) for kind in kinds}
    layers = renderer.render(whole, plate(whole.plate.frame), plan(whole))
    assert all(getattr(layers, name) is not None for name in ("decals", "relief", "shadows", "wet"))
    assert {kind: len(getattr(bpy.data, kind)) for kind in kinds} == before
