"""What a scene is expected to cost: what it lists, in proportion to its pixels, and nothing else."""

import json

import attrs
import pytest

from pavemark import costs
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.light import Glare
from pavemark.plan import LIGHT, PAINT_EFFECTS
from pavemark.scene import Brightness, Dirt, Noise, Scene
from scenes import WHITE, plate, row

TABLE = costs.Costs({}, 100 * 100, 0.5, 0.1, {"dirt": 0.02, "noise": 0.003, "glare": 0.2, "brightness": -0.001})
FRAME = Frame(200, 100, 20)


def test_a_scene_costs_what_it_lists():
    ground = plate(FRAME)
    assert TABLE.expected(Scene(0, ground.ref)) == 0
    assert TABLE.expected(row(ground, n=1)) == pytest.approx(2 * 0.5)
    dirty = attrs.evolve(WHITE, dirt=Dirt(0.2, 0.5, 1.0))
    assert TABLE.expected(row(ground, n=1, paint=dirty)) == pytest.approx(2 * 0.52)
    many = attrs.evolve(row(ground, n=1), rays=5, noise=Noise("gaussian", 1.0, 1), brightness=Brightness(1.1))
    assert TABLE.expected(many) == pytest.approx(2 * (0.5 + 4 * 0.1 + 0.003))


def test_light_alone_costs_no_markings():
    glare = Glare((), 0.3, 0.05, ((0.0, 0.0, 1.0),))
    assert TABLE.expected(Scene(0, plate(FRAME).ref, glare=glare)) == pytest.approx(2 * 0.2)


def test_the_table_that_ships_knows_every_effect():
    listed = {field.name for field in attrs.fields(Scene) if field.default is None} - {"blend"}
    assert costs.shipped().effects.keys() == listed | set(PAINT_EFFECTS)
    assert all(costs.shipped().effects[name] > 0.01 for name in LIGHT)
    assert 0 < costs.shipped().ray < costs.shipped().plain < 1


def test_a_broken_table_is_one_clear_line(tmp_path):
    path = tmp_path / "costs.json"
    path.write_text(json.dumps({"versions": {}, "pixels": 0, "plain": 1, "ray": 1, "effects": {}}))
    with pytest.raises(InputError, match=r"pixels = 0: allowed 1 to"):
        costs.read(path)
