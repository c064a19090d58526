"""What rays promise, from a table made by hand: every number in it is known."""

import json
import math

import attrs
import numpy as np
import pytest

from pavemark import __version__
from pavemark.calibration import STRENGTH, Calibration, OneRay, Rays, contrast, read, shipped
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.plan import PAINT_EFFECTS, plan
from pavemark.plate import Plate
from pavemark.records import to_json
from pavemark.scene import Blend, Brightness, Chips, Dirt, Grain, Wear
from scenes import WHITE, plate, row

NONE = dict.fromkeys(("grain", "wear", "chips", "cracks", "dirt", "pattern"), 0.0)
TABLE = Calibration(
    versions={"pavemark": __version__, "renderer": "by hand"},
    views=1,
    margin=1.0,
    one_ray=(
        OneRay(20.0, 0.001, **(NONE | {"grain": 0.5, "wear": 0.06, "chips": 0.4})),
        OneRay(60.0, 0.002, **(NONE | {"grain": 0.2, "wear": 0.03, "chips": 0.2})),
    ),
    together=0.8,
    rays=(Rays(16, 0.05), Rays(64, 0.01), Rays(256, 0.004)),
)
ALPHA = Blend("alpha")
LEVELS = math.sqrt((2 * (210 - 96) ** 2 + (205 - 96) ** 2) / 3)
"""Contrast of white paint in its absolute colour on ground of tone 96."""


def painted(scale=60.0, tone=96, **paint):
    ground = plate(Frame(60, 60, scale), tone=tone)
    return row(ground, n=1, paint=attrs.evolve(WHITE, **paint), blend=ALPHA), ground


def fewest(error, scale=60.0, brightness=None, **paint):
    scene, ground = painted(scale, **paint)
    return TABLE.fewest(attrs.evolve(scene, brightness=brightness), ground, error)


def test_contrast_is_the_distance_of_paint_and_ground_in_levels():
    assert contrast(*painted()) == pytest.approx(LEVELS)
    assert contrast(*painted(opacity=0.5)) == pytest.approx(LEVELS / 2)
    # Dirt makes white paint darker than this ground is: 0.1 of its light.
    dark = painted(tone=200, dirt=Dirt(0.5, 0.9, 1.0))
    assert contrast(*dark) > 100 > contrast(*painted(tone=200))


def test_contrast_of_a_ratio_grows_with_the_light_of_the_ground_and_ends_at_white():
    def of(tone, ratio):
        scene, ground = painted(tone=tone, ratio=(ratio,) * 3)
        return contrast(attrs.evolve(scene, blend=Blend()), ground)

    # Of sRGB, levels + 0.055 · 255 are a power of linear light.
    assert of(96, 2.4) == pytest.approx((96 + 14.025) * (2.4 ** (1 / 2.4) - 1))
    assert of(48, 2.4) < of(96, 2.4) < of(192, 2.4)
    assert of(240, 20.0) == 255.0


def test_the_bright_end_of_the_ground_counts_and_what_is_not_ground_does_not():
    image = np.full((60, 60, 3), 40, np.uint8)
    image[:, :10] = 150
    ground = np.ones((60, 60), bool)
    lit = Plate("lit", Frame(60, 60, 60.0), image, ground, ~ground, image)
    scene = attrs.evolve(row(lit, n=1), blend=Blend())
    bright, dark = (plate(Frame(60, 60, 60.0), tone=tone) for tone in (150, 40))
    assert contrast(scene, lit) == pytest.approx(contrast(scene, bright))
    hidden = Plate("hidden", lit.frame, image, image[..., 0] == 40, ~ground, image)
    assert contrast(scene, hidden) == pytest.approx(contrast(scene, dark))
    assert contrast(scene, Plate("none", lit.frame, image, ~ground, ~ground, image)) == 0.0


def test_fresh_paint_needs_one_ray():
    assert fewest(0.002 * LEVELS * 1.01) == 1
    assert fewest(0.002 * LEVELS * 0.99) == 256  # as no number in the table meets it


WEAR = Wear(0.1, 0.02, 0.1, 0.1, 0.1, 1.0)


@pytest.mark.parametrize(("error", "rays"), [(0.031, 1), (0.029, 64), (0.0101, 64), (0.0099, 256)])
def test_the_fewest_rays_that_meet_it(error, rays):
    assert fewest(error * LEVELS, wear=WEAR) == rays


def share(**paint):
    return TABLE.share(painted(**paint)[0], 1)


def test_effects_count_by_their_strength():
    assert share(grain=Grain(0.02, 0.3, 1.0)) == pytest.approx(math.hypot(0.002, 0.2 * 0.3))
    assert share(chips=Chips(0.02, 0.04, 1.0)) == pytest.approx(math.hypot(0.002, 0.2 * 0.2))
    assert share(wear=attrs.evolve(WEAR, size=0.025)) == pytest.approx(math.hypot(0.002, 0.03 * 2))


def test_several_effects_count_by_a_share_of_their_sum_but_not_less_than_the_strongest():
    even = share(wear=attrs.evolve(WEAR, size=0.05625), chips=Chips(0.02, 0.04, 1.0))  # 0.04 and 0.04
    assert even == pytest.approx(math.hypot(0.002, 0.8 * math.hypot(0.04, 0.04)))
    uneven = share(wear=attrs.evolve(WEAR, size=0.05625), chips=Chips(0.02, 0.0001, 1.0))  # 0.04 and 0.002
    assert uneven == pytest.approx(math.hypot(0.002, 0.04))


def test_the_worst_marking_counts():
    scene, _ = painted()
    worn = attrs.evolve(scene.markings[0], paint=attrs.evolve(WHITE, wear=WEAR))
    both = attrs.evolve(scene, markings=(worn, *scene.markings))
    assert TABLE.share(both, 1) == share(wear=WEAR)


def test_between_two_scales_the_worse_one_counts_and_beyond_them_rays_find_the_edges():
    assert fewest(0.051 * LEVELS, 60.0, wear=WEAR) == 1
    assert fewest(0.051 * LEVELS, 59.0, wear=WEAR) == 16
    assert fewest(0.051 * LEVELS, 61.0) == fewest(0.051 * LEVELS, 19.0) == 16


def test_brightness_scales_errors_too():
    assert fewest(0.0025 * LEVELS, brightness=Brightness(1.5)) == 256
    assert fewest(0.0011 * LEVELS, brightness=Brightness(0.5)) == 1


def test_a_scene_without_paint_needs_nothing():
    ground = plate(Frame(60, 60, 60.0))
    assert TABLE.fewest(row(ground, n=0), ground, 1.0) == 1


def test_the_plan_has_the_rays_of_the_scene():
    scene, _ = painted()
    assert plan(scene).passes[0].samples == 1 and not plan(scene).passes[0].hard
    many = plan(attrs.evolve(scene, rays=64)).passes[0]
    assert many.samples == 64 and many.hard


def test_every_effect_of_paint_has_a_strength_and_a_column():
    assert tuple(STRENGTH) == PAINT_EFFECTS
    assert {field.name for field in attrs.fields(OneRay)} == {"scale", "edge", *PAINT_EFFECTS}


def test_the_shipped_table_is_of_this_version_and_promises_a_level_of_any_scene():
    table = shipped()
    assert table.versions["pavemark"] == __version__
    assert table.least <= 1.0
    assert table.one_ray[0].scale <= 20 and table.one_ray[-1].scale >= 60


def test_fresh_paint_needs_one_ray_by_the_shipped_table_too():
    scene, ground = painted(scale=30.0)
    assert shipped().fewest(scene, ground, 1.0) == 1


def _broken(change):
    told = json.loads(to_json(TABLE))
    change(told)
    return json.dumps(told)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "not a JSON file"),
        ("[]", "is not a table of fields"),
        (_broken(lambda t: t["versions"].update(pavemark="0.0.9")), "was measured with pavemark 0.0.9, this is "),
        (_broken(lambda t: t["versions"].pop("pavemark")), "was measured with pavemark an unknown version"),
        (_broken(lambda t: t.pop("rays")), "field rays is missing"),
        (_broken(lambda t: t.update(rays=[])), "rays: rows that ascend are allowed, at least one"),
        (_broken(lambda t: t["rays"].reverse()), "rays: rows that ascend are allowed"),
        (_broken(lambda t: t["rays"][1].update(error=0.05)), "rays: errors that descend are allowed"),
        (_broken(lambda t: t["rays"][0].update(error=-1)), "error = -1.0: allowed 0 to 10"),
        (_broken(lambda t: t["one_ray"].reverse()), "one_ray: rows that ascend are allowed"),
        (_broken(lambda t: t["one_ray"][0].pop("wear")), "field wear is missing"),
    ],
)
def test_a_broken_table_is_refused_in_one_line(tmp_path, text, told):
    path = tmp_path / "rays.json"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read(path)
    assert str(refused.value).startswith(f"{path}: ") and told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_table_is_read_as_it_was_written(tmp_path):
    (tmp_path / "rays.json").write_text(to_json(TABLE))
    assert read(tmp_path / "rays.json") == TABLE
    assert read(tmp_path / "rays.json").sha256 == TABLE.sha256 != attrs.evolve(TABLE, views=2).sha256
