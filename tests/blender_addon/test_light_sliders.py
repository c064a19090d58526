"""Sliders of the effects of light: they show what the scene has, and change that and nothing else."""

import math

import attrs
import numpy as np
import pytest

from pavemark.records import to_json

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import document, edits, panel  # noqa: E402 - needs bpy
from blender_addon.effects import suns  # noqa: E402
from pavemark.light import Caster, Glare, Lamp, Relief, Shadows, Sun, Tube  # noqa: E402

SUN = Sun(azimuth=0.7, elevation=0.6, angle=0.01)
CASTERS = (
    Caster("pole", (6.1, 0.3), (0.2, 0.2, 5.1), 0.4, 3),
    Caster("tree", (-6.3, 1.7), (3.1, 3.3, 5.7), 1.1, 2_000_000_001),
)
EYES = ((0.0, 0.0, 1.2),)
TUBES = tuple(Tube((x, 0.1, 2.9), 1.3, 0.15, 0.1, (21.0, 20.0, 19.3)) for x in (-3.3, 0.1, 3.7))


def give(target, **effects):
    """A scene with effects, shown in the panel."""
    document.put(target, attrs.evolve(document.current(target), **effects))
    return document.current(target)


def there(target):
    """The labels of the subpanels that are there."""
    context = type("Context", (), {"scene": target})
    kinds = (panel.effects.PAVEMARK_PT_sun, panel.effects.PAVEMARK_PT_lamp)
    kinds += (panel.effects.PAVEMARK_PT_casters, panel.effects.PAVEMARK_PT_tubes)
    return [kind.bl_label for kind in kinds if kind.poll(context)]


def test_only_what_the_scene_has_is_there(drawn):
    assert there(drawn) == []
    give(drawn, shadows=Shadows((0.3, 0.3, 0.3), sun=SUN, casters=CASTERS))
    assert there(drawn) == ["Sun", "Casters"]
    give(drawn, shadows=Shadows((0.3, 0.3, 0.3), lamp=Lamp((1.0, 2.0, 4.0), 0.1)), glare=Glare(TUBES, 0.2, 0.04, EYES))
    assert there(drawn) == ["Lamp", "Tubes"]
    drawn.pavemark.shadows.use = drawn.pavemark.glare.use = False
    assert there(drawn) == []
    drawn.pavemark.document = ""
    assert there(drawn) == []


def test_sliders_show_what_the_scene_has(drawn):
    give(drawn, shadows=Shadows((0.3, 0.4, 0.5), sun=SUN, casters=CASTERS), glare=Glare(TUBES, 0.2, 0.04, EYES))
    told = drawn.pavemark
    assert tuple(told.shadows.left) == pytest.approx((0.3, 0.4, 0.5))
    assert (told.sun.azimuth, told.sun.elevation, told.sun.angle) == pytest.approx((0.7, 0.6, 0.01))
    assert [caster.kind for caster in told.casters] == ["pole", "tree"]
    assert tuple(told.casters[1].size) == pytest.approx((3.1, 3.3, 5.7))
    assert told.casters[1].seed == 2_000_000_001
    assert (told.tubes.height, told.tubes.length) == pytest.approx((2.9, 1.3))
    give(drawn, shadows=Shadows((0.3, 0.4, 0.5), lamp=Lamp((1.0, -2.0, 4.0), 0.1), casters=CASTERS[:1]))
    assert tuple(told.lamp.place) == pytest.approx((1.0, -2.0, 4.0)) and len(told.casters) == 1


def test_an_image_has_one_sun(drawn):
    before = give(
        drawn,
        shadows=Shadows((0.3, 0.3, 0.3), sun=SUN, casters=CASTERS),
        relief=Relief(0.004, 0.006, SUN, 0.3),
    )
    drawn.pavemark.sun.elevation = 1.0
    now = document.current(drawn)
    assert set(suns(now)) == {"shadows", "relief"}
    assert set(suns(now).values()) == {attrs.evolve(SUN, elevation=1.0)}
    assert attrs.evolve(now.shadows, sun=SUN) == before.shadows
    drawn.pavemark.relief.use = False
    drawn.pavemark.relief.use = True
    assert document.current(drawn).relief.sun == attrs.evolve(SUN, elevation=1.0), "the one that is there"


def test_the_sun_can_stand_at_the_end_of_its_slider(drawn):
    give(drawn, shadows=Shadows((0.3, 0.3, 0.3), sun=SUN, casters=CASTERS))
    drawn.pavemark.sun.elevation = 7.0
    assert drawn.pavemark.trouble == ""
    assert document.current(drawn).shadows.sun.elevation == math.pi / 2


def test_one_caster_is_changed_and_by_one_field(drawn):
    before = give(drawn, shadows=Shadows((0.3, 0.3, 0.3), sun=SUN, casters=CASTERS))
    drawn.pavemark.casters[1].foot = (5.5, -4.25)
    drawn.pavemark.casters[0].kind = "roof"
    assert drawn.pavemark.trouble == ""
    pole, tree = document.current(drawn).shadows.casters
    assert pole == attrs.evolve(CASTERS[0], kind="roof")
    assert tree == attrs.evolve(CASTERS[1], foot=(5.5, -4.25))
    assert attrs.evolve(document.current(drawn), shadows=before.shadows) == before


def test_a_lamp_that_would_touch_the_ground_is_told_and_the_slider_goes_back(drawn):
    before = give(drawn, shadows=Shadows((0.3, 0.3, 0.3), lamp=Lamp((1.0, 2.0, 1.5), 0.1), casters=CASTERS))
    drawn.pavemark.lamp.radius = 1.75
    assert "more than the radius" in drawn.pavemark.trouble
    assert document.current(drawn) == before
    assert drawn.pavemark.lamp.radius == pytest.approx(0.1)
    drawn.pavemark.lamp.place = (1.0, 2.0, 6.0)
    assert drawn.pavemark.trouble == ""
    assert document.current(drawn).shadows.lamp == Lamp((1.0, 2.0, 6.0), 0.1)


def test_a_caster_that_is_refused_leaves_all_as_they_were(drawn, monkeypatch):
    before = give(drawn, shadows=Shadows((0.3, 0.3, 0.3), sun=SUN, casters=CASTERS))

    def refuse(*_, **__):
        raise ValueError("no such caster is allowed")

    monkeypatch.setattr(edits.fields, "value", refuse)
    drawn.pavemark.casters[0].turn = 2.0
    monkeypatch.undo()
    assert drawn.pavemark.trouble == "no such caster is allowed"
    assert document.current(drawn) == before
    assert drawn.pavemark.casters[0].turn == pytest.approx(0.4)


def test_tubes_are_alike_and_keep_their_places(drawn):
    give(drawn, glare=Glare(TUBES, 0.2, 0.04, EYES))
    drawn.pavemark.tubes.height = 4.0
    drawn.pavemark.tubes.radiance = (30.0, 31.0, 32.0)
    drawn.pavemark.tubes.width = 0.25
    tubes = document.current(drawn).glare.tubes
    assert [tube.place for tube in tubes] == [(*tube.place[:2], 4.0) for tube in TUBES]
    assert {(tube.radiance, tube.width, tube.length) for tube in tubes} == {((30.0, 31.0, 32.0), 0.25, 1.3)}


def test_colours_of_wet_ground(drawn):
    drawn.pavemark.wet.use = True
    before = document.current(drawn).wet
    drawn.pavemark.wet.sky = (0.5, 0.75, 1.0)
    drawn.pavemark.wet.skyline = 0.25
    assert document.current(drawn).wet == attrs.evolve(before, sky=(0.5, 0.75, 1.0), skyline=0.25)


def test_sliders_of_what_is_not_there_change_nothing(drawn):
    before = to_json(document.current(drawn))
    told = drawn.pavemark
    told.sun.azimuth, told.lamp.radius, told.tubes.height = 1.0, 0.5, 5.0
    assert (to_json(document.current(drawn)), told.trouble) == (before, "")
    told.document = ""
    told.sun.azimuth, told.lamp.radius, told.tubes.height = 1.5, 0.6, 6.0
    assert (told.document, told.trouble) == ("", "")


def test_the_picture_follows_the_sun(drawn):
    """The shadow of a pole lies elsewhere: pixels of the render tell."""
    frame = document.current(drawn).plate.frame
    pole = Caster("pole", (frame.size[0] / 2 + 0.5, 0.0), (0.4, 0.4, 6.0))
    give(drawn, shadows=Shadows((0.2, 0.2, 0.2), sun=Sun(0.0, 0.7, 0.01), casters=(pole,)))
    bpy.ops.pavemark.render()
    first = rendered()
    drawn.pavemark.sun.azimuth = 0.3
    bpy.ops.pavemark.render()
    assert np.abs(rendered() - first).max() > 0.05


def rendered():
    from blender_addon import shot  # noqa: PLC0415 - needs bpy

    image = bpy.data.images[shot.IMAGE]
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values
