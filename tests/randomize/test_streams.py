"""Streams: each effect draws alone, so that switching one off leaves every other as it was."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np
import pytest

from pavemark.randomize.domains import Domains
from pavemark.randomize.scene import randomize
from pavemark.randomize.streams import Stage, quantile, seed, stream, weighted
from pavemark.scene import Scene
from scenes import plate

BLUR = ((1.0, 2.0), (1.5, 2.5))
PLATE = plate(car=(1.86, 3.42))
EFFECTS = (
    ("noise", ("noise",)),
    ("curvature", ("curvature",)),
    ("brightness", ("brightness",)),
    ("optics", ("optics",)),
    ("tyres", ("texture", "tyres")),
    ("former", ("texture", "former")),
    ("grain", ("texture", "grain")),
    ("wear", ("texture", "wear")),
    ("chips", ("texture", "chips")),
    ("cracks", ("texture", "cracks")),
    ("dirt", ("texture", "dirt")),
    ("pattern", ("texture", "pattern")),
    ("opacity", ("texture", "fade")),
    ("relief", ("relief",)),
    ("shadows", ("shadows",)),
    ("wet", ("wet",)),
    ("glare", ("glare",)),
    ("aisle", ("aisle",)),
    ("stops", ("stops",)),
)


def changed(record, path: tuple[str, ...], **values):
    """The record with fields of one of its parts changed."""
    if not path:
        return attrs.evolve(record, **values)
    return attrs.evolve(record, **{path[0]: changed(getattr(record, path[0]), path[1:], **values)})


def drawn(domains: Domains, index: int) -> Scene:
    return randomize(PLATE, index, 11, domains, blur=BLUR)


def without(scene: Scene, effect: str) -> Scene:
    """The scene with one effect taken out by hand."""
    if effect == "former":
        return attrs.evolve(scene, markings=tuple(m for m in scene.markings if m.kind != "former"))
    if effect == "aisle":
        return attrs.evolve(scene, markings=tuple(m for m in scene.markings if m.kind not in ("aisle", "floor")))
    if effect == "stops":
        return attrs.evolve(scene, markings=tuple(m for m in scene.markings if m.kind != "stop"))
    if effect in {field.name for field in attrs.fields(Scene)}:
        return attrs.evolve(scene, **{effect: None})
    value = 1.0 if effect == "opacity" else None
    # A former coat and a painted floor have an opacity of their own, and a stop is no paint.
    new = [m for m in scene.markings if m.kind not in ("former", "floor", "stop")]
    plain = {id(m): attrs.evolve(m, paint=attrs.evolve(m.paint, **{effect: value})) for m in new}
    return attrs.evolve(scene, markings=tuple(plain.get(id(m), m) for m in scene.markings))


@pytest.mark.parametrize(("effect", "path"), EFFECTS)
def test_switching_an_effect_off_leaves_all_else(effect, path):
    shown = 0
    for index in range(12):
        on = drawn(changed(Domains(), path, rate=1.0), index)
        off = drawn(changed(Domains(), path, rate=0.0), index)
        assert off == without(on, effect)
        shown += on != off
    # The effect was there to be switched off; parallel slots have no stops.
    assert shown >= (4 if effect == "stops" else 8)


def everything_on() -> Domains:
    domains = changed(Domains(), ("layout",), empty_rate=0.0)
    for _, path in EFFECTS:
        domains = changed(domains, path, rate=1.0)
    return domains


@pytest.mark.parametrize(("one", "other"), [*itertools.combinations(EFFECTS, 2)], ids=lambda effect: effect[0])
def test_switching_two_off_leaves_all_else(one, other):
    for index in range(3):
        off = everything_on()
        for _, path in (one, other):
            off = changed(off, path, rate=0.0)
        assert drawn(off, index) == without(without(drawn(everything_on(), index), one[0]), other[0])


STREAMS = {
    "noise": (Stage.NOISE,),
    "curvature": (Stage.CURVATURE,),
    "brightness": (Stage.BRIGHTNESS,),
    "optics": (Stage.OPTICS,),
    "tyres": (Stage.TYRES,),
    "former": (Stage.FORMER,),
    "relief": (Stage.RELIEF,),
    "shadows": (Stage.SHADOWS,),
    "wet": (Stage.WET,),
    "glare": (Stage.GLARE,),
    "aisle": (Stage.AISLE,),
    "stops": (Stage.STOPS,),
}
TEXTURE = ("grain", "wear", "chips", "cracks", "dirt", "pattern", "opacity")
"""What the texture's streams are for, by number."""


@pytest.mark.parametrize(("effect", "path"), EFFECTS)
def test_an_effect_that_is_off_draws_no_number(effect, path, monkeypatch):
    streams = []

    class Recorded(np.random.PCG64):
        def __init__(self, seeds):
            super().__init__(seeds)
            self.key, self.fresh = seeds.spawn_key, self.state
            streams.append(self)

    def draws(domains):
        streams.clear()
        drawn(domains, 5)
        keys = {each.key[1:] for each in streams if each.state != each.fresh}
        if effect in TEXTURE:
            return {key for key in keys if key[:2] == (Stage.TEXTURE, 1) and key[3] == TEXTURE.index(effect)}
        return {key for key in keys if key[0] in STREAMS[effect]}

    monkeypatch.setattr(np.random, "PCG64", Recorded)
    assert draws(everything_on())
    assert not draws(changed(everything_on(), path, rate=0.0))


def test_a_sun_is_drawn_only_where_it_is_asked_for_and_is_one_for_all():
    both = everything_on()
    both = changed(changed(both, ("shadows",), lamp=0.0), ("relief",), rate=1.0)
    scenes = [drawn(both, index) for index in range(8)]
    lit = [scene for scene in scenes if scene.shadows and scene.relief]
    assert len(lit) >= 5
    assert all(scene.shadows.sun == scene.relief.sun for scene in lit)
    alone = [drawn(changed(both, ("relief",), rate=0.0), index).shadows for index in range(8)]
    assert alone == [scene.shadows for scene in scenes]


def test_shadows_are_cast_by_what_stands_outside_the_frame():
    for lamp, least in ((0.0, 16), (1.0, 12)):
        domains = changed(everything_on(), ("shadows",), lamp=lamp)
        cast = [drawn(domains, index).shadows for index in range(20)]
        assert sum(each is not None for each in cast) >= least
        for caster in (caster for each in cast if each for caster in each.casters):
            # The nearest corner of its box, whichever way it is turned.
            half = [abs(math.cos(caster.turn)), abs(math.sin(caster.turn))]
            reach = [
                half[0] * caster.size[0] + half[1] * caster.size[1],
                half[1] * caster.size[0] + half[0] * caster.size[1],
            ]
            if caster.kind in ("tree", "pole"):
                reach = [max(caster.size[:2])] * 2
            outside = [abs(at) - side / 2 > 5.0 for at, side in zip(caster.foot, reach, strict=True)]
            assert any(outside), caster


def test_what_gleams_is_seen_from_the_car_in_the_picture():
    domains = everything_on()
    scene = drawn(domains, 3)
    assert scene.wet.eyes == scene.glare.eyes and len(scene.wet.eyes) == 4
    for x, y, z in scene.wet.eyes:
        assert 0.5 < z < 1.2
        assert PLATE.frame.contains(PLATE.frame.to_image(np.array([x, y])))
        # Just outside the car's box.
        assert 0 < max(abs(x) - 0.93, abs(y) - 1.71) < 0.25


@pytest.mark.parametrize(
    ("path", "values", "parts"),
    [
        (("colour",), {"spread": 3.0, "ratio_spread": 0.0}, ("slots", "tyres", "curvature", "noise", "brightness")),
        (("texture",), {"age": (0.9, 1.0)}, ("slots", "tyres", "curvature", "noise", "brightness")),
        (("shape",), {"line": (0.3, 0.3)}, ("slots", "tyres", "curvature", "noise", "brightness", "optics")),
        (("layout",), {"offset": (0.5, 0.5)}, ("curvature", "noise", "brightness", "optics")),
        (
            ("noise",),
            {"rate": 1.0, "level": (2.0, 2.5), "share": (0.1, 0.2)},
            ("slots", "markings", "curvature", "brightness"),
        ),
    ],
)
def test_changing_a_range_moves_no_other_domain(path, values, parts):
    for index in range(12):
        before = drawn(changed(Domains(), ("layout",), empty_rate=0.0), index)
        after = drawn(changed(changed(Domains(), ("layout",), empty_rate=0.0), path, **values), index)
        assert before != after
        for part in parts:
            assert getattr(before, part) == getattr(after, part), part


def test_symbols_leave_slots_and_their_paint():
    for index in range(10):
        on = drawn(changed(Domains(), ("layout",), symbol_rate=1.0), index)
        off = drawn(changed(Domains(), ("layout",), symbol_rate=0.0), index)
        assert off == attrs.evolve(on, markings=tuple(m for m in on.markings if m.kind != "symbol"))


def test_the_order_of_images_does_not_matter():
    forwards = [drawn(Domains(), index) for index in range(6)]
    backwards = [drawn(Domains(), index) for index in reversed(range(6))]
    assert forwards == backwards[::-1]
    assert len({scene.markings for scene in forwards}) == 6


def test_streams_differ_by_seed_index_stage_and_child():
    keys = [(7, 1, Stage.NOISE), (8, 1, Stage.NOISE), (7, 2, Stage.NOISE), (7, 1, Stage.COLOUR), (7, 1, Stage.NOISE, 0)]
    assert len({stream(*key).random() for key in keys}) == len(keys)


def test_stage_numbers_are_never_given_away_again():
    assert [stage.name for stage in sorted(Stage)][:4] == ["LAYOUT", "SHAPE", "COLOUR", "TEXTURE"]
    assert len(set(Stage)) == 18
    # The first draw of a known stream: it changes when the way seeds are made does.
    assert stream(7, 3, Stage.NOISE).integers(2**32) == 3763936583


def test_draws():
    rng = stream(1, 2, Stage.LAYOUT)
    words = [weighted(rng, {"never": 0.0, "seldom": 1.0, "often": 9.0, "none": 0.0}) for _ in range(2000)]
    assert 120 < words.count("seldom") < 290
    assert words.count("seldom") + words.count("often") == 2000
    values = [quantile(rng, (1.0, 2.0, 10.0)) for _ in range(2000)]
    assert 900 < sum(value < 2.0 for value in values) < 1100
    assert all(1.0 <= value <= 10.0 for value in values)
    assert all(0 <= seed(rng) < 2**63 for _ in range(100))


def test_the_sun_stands_where_it_is_asked_for():
    domains = changed(everything_on(), ("sun",), azimuth=(80.0, 100.0), elevation=(30.0, 30.0))
    for index in range(5):
        relief = drawn(domains, index).relief
        assert math.radians(80) <= relief.sun.azimuth <= math.radians(100)
        assert relief.sun.elevation == math.radians(30)
