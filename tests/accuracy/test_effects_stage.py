"""What effects cost: every one is measured, and one that takes long is told of as long."""

import csv
import io
import time
from contextlib import contextmanager

import attrs
import numpy as np
import pytest

from pavemark.accuracy.effects import EFFECTS, report, scene
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plan import LIGHT, PAINT_EFFECTS
from pavemark.scene import Scene

SPENT = 0.03


class Slow:
    """Draws nothing, and takes SPENT seconds for shadows."""

    version = "slow 1"

    def render(self, scene, plate, plan):
        shape = plate.ground.shape
        names = {made.name for made in plan.passes}
        if "shadows" in names:
            until = time.process_time() + SPENT
            while time.process_time() < until:
                pass
        blank = {"decals": np.zeros((*shape, 4)), "relief": np.ones((*shape, 1)), "shadows": np.ones((*shape, 1))}
        blank["wet"] = np.zeros((*shape, 4))
        return Layers(**{name: blank[name].astype(np.float32) for name in names})


def slow():
    return Slow()


def nothing():
    raise InputError("Blender", "no module named 'bpy'")


class Watcher:
    @contextmanager
    def of(self, total):
        yield

    def step(self, lacking):
        pass

    def tell(self, line):
        raise AssertionError(line)


def test_every_effect_of_a_scene_is_measured():
    listed = {field.name for field in attrs.fields(Scene) if field.default is None} - {"blend"}
    assert set(EFFECTS) == listed | set(PAINT_EFFECTS)
    assert set(LIGHT) < set(EFFECTS)
    with_one = scene(Frame(32, 32, 3), ("noise", "grain"))
    assert with_one.noise and with_one.markings[0].paint.grain
    assert not (with_one.brightness or with_one.markings[0].paint.wear)


def test_an_effect_that_takes_long_is_told_of_as_long():
    made = report(slow, True, Watcher())
    rows = {row["effect"]: row for row in csv.DictReader(io.StringIO(made.files["effects.csv"]))}
    assert list(rows) == list(EFFECTS)
    for which in ("alone", "last"):
        assert float(rows["shadows"][which]) == pytest.approx(SPENT, abs=0.02)
        assert abs(float(rows["grain"][which])) < 0.01
    assert made.files["effects.svg"].startswith("<?xml") and ">shadows<" in made.files["effects.svg"]
    assert "| shadows |" in made.told


def test_without_a_renderer_the_stage_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^effects: Blender: no module named 'bpy'"):
        report(nothing, True, Watcher())
