"""Calibration, with renderers of which the errors are known."""

import csv
import io
import json
import math
from contextlib import contextmanager
from itertools import islice

import attrs
import numpy as np
import pytest

from pavemark.accuracy import calibrate
from pavemark.accuracy.calibrate import FRESH, KINDS, MARGIN, SEVERAL, Measured, off, tabled
from pavemark.accuracy.views import WIDE, ageing, on_edges, views
from pavemark.calibration import Calibration
from pavemark.colour import to_linear
from pavemark.errors import InputError
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.layers import Layers
from pavemark.plan import PAINT_EFFECTS, paint_effects
from pavemark.randomize.domains import Domains
from pavemark.records import structure

FRAME = Frame(96, 96, 22.0)


class Noisy:
    """Exact coverage, and on it an error of a known size: a tenth over the root of the rays, of any sign."""

    version = "noisy 1"

    def render(self, scene, plate, plan):
        frame = scene.plate.frame
        (decals,) = plan.passes
        rng = np.random.default_rng((decals.sampling.seed, decals.samples))
        layer = np.zeros((frame.height, frame.width, 4))
        for marking in scene.markings:
            share = coverage(outline(marking, scene.curvature), frame) * marking.paint.opacity
            alpha = share[..., None]
            paint = np.array(marking.paint.ratio if plan.colour == "ratio" else to_linear(np.array(marking.paint.rgb)))
            layer = layer * (1 - alpha) + np.concatenate([alpha * paint, alpha], -1)
        layer *= 1 + 0.1 / math.sqrt(decals.samples) * rng.choice((-1, 1), layer.shape[:2])[..., None]
        return Layers(layer.astype(np.float32))


def noisy():
    return Noisy()


def nothing():
    raise InputError("Blender", "ModuleNotFoundError: No module named 'bpy': pip install 'pavemark[blender]'")


class Watcher:
    steps = total = 0

    @contextmanager
    def of(self, total):
        self.total = total
        yield

    def step(self, lacking):
        self.steps += 1


@pytest.fixture(scope="module")
def made():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(calibrate, "FRAMES", (FRAME,))
        watcher = Watcher()
        report = calibrate.report(noisy, True, watcher)
    assert watcher.steps == watcher.total
    return report


def test_a_report_of_a_table_and_what_it_was_made_of(made):
    table = structure(Calibration, json.loads(made.files["rays.json"]), "rays.json")
    assert table.versions["renderer"] == "noisy 1" and table.margin == MARGIN
    errors = [row.error for row in table.rays]
    # From 4 to 16 rays the error falls with their root; the reference has too many to be seen.
    assert errors[0] / errors[2] == pytest.approx(2.0, rel=0.1)
    rows = list(csv.DictReader(io.StringIO(made.files["calibration.csv"])))
    assert {row["effects"] for row in rows} == set(KINDS)
    assert all(float(row["error"]) <= float(row["promised"]) for row in rows if row["rays"] != "1")
    assert len({(row["effects"], row["contrast"]) for row in rows}) >= table.views - 2
    assert "--calibration rays.json" in made.told and "The closest call: " in made.told


def test_without_a_renderer_it_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^calibrate: Blender: .*No module named 'bpy': pip install"):
        calibrate.report(nothing, True, Watcher())


def some(effects, count=3, frame=FRAME):
    return list(islice(views(ageing(Domains(), *KINDS[effects]), frame, 5), count))


def test_views_have_edges_and_the_effects_that_were_asked_for():
    for effects, (names, rate) in KINDS.items():
        for scene in some(effects, 2):
            assert on_edges(scene).sum() >= 100
            assert scene.plate.frame == FRAME and scene.noise is scene.brightness is scene.optics is None
            of = {paint_effects(marking.paint) for marking in scene.markings if marking.kind != "former"}
            assert of == {names} if rate == 1.0 else of
    assert some(SEVERAL)[0] == some(SEVERAL)[0] != some(SEVERAL)[1]
    drawn = [paint_effects(marking.paint) for scene in some(SEVERAL, 8) for marking in scene.markings]
    assert {name for effects in drawn for name in effects} == set(PAINT_EFFECTS) != set(drawn[0])


def test_effects_are_drawn_wider_than_by_default():
    default = Domains().texture
    for name in PAINT_EFFECTS:
        wide, usual = attrs.asdict(getattr(WIDE, name)), attrs.asdict(getattr(default, name))
        for field, span in usual.items():
            if field not in ("rate", "kinds"):
                assert wide[field][0] <= span[0] and wide[field][1] >= span[1]


def test_the_worst_of_each_counts_with_the_margin():
    fresh, grained = some(FRESH), some("grain")
    measured = [Measured(FRESH, scene, 1, 100.0, error) for scene, error in zip(fresh, (0.3, 0.2, 0.4), strict=True)]
    measured += [
        Measured("grain", scene, 1, 50.0, error) for scene, error in zip(grained, (1.0, 2.0, 1.5), strict=True)
    ]
    for name in set(PAINT_EFFECTS) - {"grain"}:
        measured += [Measured(name, some(name, 1)[0], 1, 10.0, 0.02)]
    several = some(SEVERAL, 1)[0]
    measured += [Measured(SEVERAL, several, rays, 10.0, e) for rays, e in ((16, 0.5), (64, 0.1), (16, 0.7), (1, 0.0))]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(calibrate, "FRAMES", (FRAME,))
        table = tabled(measured, "by hand")
    (one,) = table.one_ray
    assert one.edge == pytest.approx(MARGIN * 0.004)
    wanted = max(
        math.sqrt((error / 50) ** 2 - 0.002**2) / max(marking.paint.grain.contrast for marking in scene.markings)
        for scene, error in zip(grained, (1.0, 2.0, 1.5), strict=True)
    )
    assert one.grain == pytest.approx(MARGIN * wanted, rel=5e-3)
    assert one.dirt == 0.0  # no worse than fresh paint
    assert table.together == 0.0  # several were nothing
    assert [(row.number, row.error) for row in table.rays] == [
        (16, pytest.approx(MARGIN * 0.07, rel=5e-3)),
        (64, pytest.approx(MARGIN * 0.01, rel=5e-3)),
    ]


def test_off_is_the_root_mean_square_over_edges():
    truth = np.zeros((2, 2, 3))
    image = truth + np.array([[[3.0, 4.0, 0.0]], [[9.0, 9.0, 9.0]]])
    edge = np.array([[True, True], [False, False]])
    assert off(image, truth, edge) == pytest.approx(math.sqrt(25 / 3))


def test_several_effects_come_to_the_share_of_the_worst_view():
    mixed = [scene for scene in some(SEVERAL, 6) if all(len(paint_effects(m.paint)) > 1 for m in scene.markings)]
    measured = [Measured(FRESH, some(FRESH, 1)[0], 1, 10.0, 0.0)]
    measured += [Measured(name, some(name, 1)[0], 1, 10.0, 0.2) for name in PAINT_EFFECTS]
    measured += [Measured(SEVERAL, scene, 1, 10.0, 0.0) for scene in mixed]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(calibrate, "FRAMES", (FRAME,))
        none = tabled([*measured, Measured(SEVERAL, mixed[0], 16, 10.0, 1.0)], "by hand")
        whole = attrs.evolve(none, together=1.0)
        error = 0.9 * 10.0 * whole.share(mixed[0], 1) / MARGIN
        some_of_it = tabled(
            [*measured, Measured(SEVERAL, mixed[0], 16, 10.0, 1.0), Measured(SEVERAL, mixed[0], 1, 10.0, error)],
            "by hand",
        )
    assert none.together == 0.0 and none.share(mixed[0], 1) < whole.share(mixed[0], 1)
    assert some_of_it.together == pytest.approx(0.9, abs=2e-3)
    assert 10.0 * some_of_it.share(mixed[0], 1) == pytest.approx(MARGIN * error, rel=2e-3)
