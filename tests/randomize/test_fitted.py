"""What is drawn against the real slots it was fitted to."""

from __future__ import annotations

import json
import math
from pathlib import Path

import attrs
import numpy as np
import pytest
from scipy.stats import ks_2samp

from pavemark.randomize import layout, shape
from pavemark.randomize.domains import Domains
from pavemark.randomize.fitted import fitted
from pavemark.randomize.palette import palette
from pavemark.randomize.scene import randomize
from pavemark.randomize.streams import Stage, stream
from scenes import plate

DATA = Path(__file__).parents[2] / "../shared/data/layout/ps2_train_slots.jsonl"
real_data = pytest.mark.skipif(not DATA.exists(), reason="the real layout is not here")


def real() -> dict[str, np.ndarray]:
    """Entrance length in metres and angle in degrees (N, 2) of each kind's real slots."""
    found: dict[str, list] = {"perpendicular": [], "parallel": [], "slanted": []}
    for line in DATA.read_text().splitlines():
        for slot in json.loads(line)["slots"]:
            du, dv = np.subtract(slot["p2"], slot["p1"])
            length = math.hypot(du, dv) / 60
            # Image axes turn clockwise: anticlockwise in the world is the negative.
            angle = math.degrees(-(slot["depth_angle"] - math.atan2(dv, du))) % 360
            kind = "slanted" if slot["type"] != 1 else "parallel" if length > 3.5 else "perpendicular"
            found[kind].append((length, angle))
    return {kind: np.array(values) for kind, values in found.items()}


@real_data
@pytest.mark.parametrize("kind", ["perpendicular", "parallel", "slanted"])
def test_drawn_slots_follow_the_real_ones(kind):
    weights = dict.fromkeys(("perpendicular", "parallel", "slanted"), 0.0) | {kind: 1.0}
    ranges = shape.Ranges(free_slant=0.0, depth=(1.0, 1.0), **weights)
    drawn = [shape.sample(stream(0, k, Stage.SHAPE), ranges, fitted()) for k in range(5000)]
    lengths, angles = real()[kind].T
    # 5,000 against thousands: chance alone gives 0.03; slanted ones are 316, and their families are drawn by rows.
    allowed = 0.12 if kind == "slanted" else 0.03
    assert ks_2samp([s.entrance for s in drawn], lengths).statistic < allowed
    turned = np.round([math.degrees(s.angle) for s in drawn], 1)
    assert ks_2samp(turned, np.round(angles, 1)).statistic < allowed


@real_data
def test_entrances_in_scenes_follow_the_real_ones():
    domains = Domains(
        layout=layout.Ranges(empty_rate=0.0, both_sides=0.0),
        shape=shape.Ranges(perpendicular=1.0, parallel=0.0, slanted=0.0),
    )
    on = plate(car=(1.86, 3.42))
    lengths = [math.dist(*slot.corners[:2]) for k in range(400) for slot in randomize(on, k, 1, domains).slots]
    # Slots of a row are alike: 400 independent values, 0.07 by chance; neighbours' variation widens the rest a little.
    assert ks_2samp(lengths, real()["perpendicular"][:, 0]).statistic < 0.1


@real_data
def test_entrance_lines_lie_where_real_ones_do():
    """Distance from the car of rows beside it, in a frame like the real ones."""
    domains = Domains(
        layout=layout.Ranges(empty_rate=0.0, both_sides=0.0, offset=(0.0, 0.0)),
        shape=shape.Ranges(perpendicular=0.0, parallel=1.0, slanted=0.0),
    )
    on = plate(car=(1.86, 3.42))
    drawn, seen = [], []
    for k in range(350):
        for slot in randomize(on, k, 1, domains).slots[:1]:
            drawn.append(_distance(*np.array(slot.corners[:2])))
    for line in DATA.read_text().splitlines():
        for slot in json.loads(line)["slots"]:
            ends = (np.array([slot["p1"], slot["p2"]]) - 300) / 60 * (1, -1)
            if slot["type"] == 1 and math.dist(*ends) > 3.5:
                seen.append(_distance(*ends))
    assert ks_2samp(drawn, seen).statistic < 0.1


def _distance(p1: np.ndarray, p2: np.ndarray) -> float:
    e = (p2 - p1) / np.linalg.norm(p2 - p1)
    return float(p1 @ (-e[1], e[0]))


def test_the_fit_is_sound():
    of = fitted()
    families = (of.perpendicular, of.parallel, of.acute, of.obtuse)
    assert abs(sum(family.rows for family in families) - 1) < 0.001
    for family in families:
        for table in (family.entrance, family.angle, family.turn, family.clearance):
            assert list(table) == sorted(table)
        assert abs(sum(family.count) - 1) < 0.01
    assert 2.3 < np.median(of.perpendicular.entrance) < 2.8
    assert 5.5 < np.median(of.parallel.entrance) < 6.5


def test_the_palette_is_sound():
    assert palette().white and palette().yellow
    for shade in palette().yellow:
        assert shade.rgb[2] < shade.rgb[1] and shade.ratio[2] < shade.ratio[0]
    for shade in palette().white:
        assert max(shade.ratio) < 1.4 * min(shade.ratio)
    assert all(min(shade.weight, *attrs.astuple(shade)[0]) > 0 for shade in (*palette().white, *palette().yellow))
