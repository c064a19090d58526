"""Streams: each effect draws alone, so that switching one off leaves every other as it was."""

from __future__ import annotations

import attrs
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
    if effect in ("noise", "curvature", "brightness", "optics", "tyres"):
        return attrs.evolve(scene, **{effect: None})
    value = 1.0 if effect == "opacity" else None
    new = [m for m in scene.markings if m.kind != "former"]
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
    assert shown >= 8  # the effect was there to be switched off


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
    assert len(set(Stage)) == 16
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
