"""The render stage, with a renderer of which the error is known: it throws hard-edged darts."""

import csv
import io
from contextlib import contextmanager

import numpy as np
import pytest
import shapely

from pavemark.accuracy import edges, marked
from pavemark.accuracy.edges import FRESH, LIT, WORN, exact, fresh, picture
from pavemark.accuracy.render import COVERAGE, EEVEE, EEVEE_ONCE, HARD, RAYS_ALONE, _without_gpu, report, settings
from pavemark.accuracy.work_precision import power
from pavemark.colour import to_linear
from pavemark.errors import InputError
from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.layers import Layers


class Darts:
    """So many points a pixel, at random: the share of them that hits paint has the error of chance, ∝ points^-1/2."""

    version = "darts 1"

    def render(self, scene, plate, plan):
        print("what a renderer prints is not to be heard")
        frame = scene.plate.frame
        (made,) = plan.passes
        rng = np.random.default_rng(made.sampling.seed)
        if made.name == "shadows":
            share = np.broadcast_to(np.linspace(0, 1, frame.width), (frame.height, frame.width))
            hits = rng.binomial(made.samples, share) / made.samples
            return Layers(shadows=hits[..., None].astype(np.float32))
        shape = outline(scene.markings[0], scene.curvature)
        share = coverage(shape, frame)
        if made.hard:
            shapely.prepare(shape)
            row, column = np.nonzero((share > 0) & (share < 1))
            corner = np.stack([column, row], -1)[:, None]
            thrown = frame.to_world(corner + rng.random((len(row), made.samples, 2)))
            share[row, column] = shapely.contains_xy(shape, thrown[..., 0], thrown[..., 1]).mean(1)
        colour = to_linear(np.array(scene.markings[0].paint.rgb))
        return Layers(np.concatenate([share[..., None] * colour, share[..., None]], -1).astype(np.float32))


def darts():
    return Darts()


def nothing():
    raise InputError("Blender", "ModuleNotFoundError: No module named 'bpy': pip install 'pavemark[blender]'")


class Watcher:
    def __init__(self):
        self.lines = []

    @contextmanager
    def of(self, total):
        yield

    def step(self, lacking):
        pass

    def tell(self, line):
        self.lines.append(line)


@pytest.fixture(scope="module")
def made():
    return report(darts, True, Watcher())


def test_more_rays_are_more_exact_by_their_root_and_coverage_beats_them_all(made):
    rows = [row for row in csv.DictReader(io.StringIO(made.files["render.csv"])) if row["problem"] == FRESH]
    rays = [row for row in rows if row["family"] == HARD]
    errors, numbers = ([float(row[name]) for row in rays] for name in ("error", "samples"))
    assert numbers == [1, 4, 16, 64]
    # Display levels are no linear measure: the exponent is that of chance, not to the digit.
    assert power(errors, numbers) == pytest.approx(-0.5, abs=0.1)
    (best,) = (row for row in rows if row["family"] == COVERAGE)
    assert float(best["error"]) < 0.01 * min(errors)
    assert (best["ships"], best["pareto"]) == ("True", "True")
    assert [float(row["ssim"]) for row in rays] == sorted(float(row["ssim"]) for row in rays)


def test_half_shadows_are_found_by_chance(made):
    rows = [row for row in csv.DictReader(io.StringIO(made.files["render.csv"])) if row["problem"] == LIT]
    rays = [row for row in rows if row["family"] == RAYS_ALONE]
    errors, numbers = ([float(row[name]) for row in rays] for name in ("error", "samples"))
    assert numbers == [1, 4, 8, 16]
    assert power(errors, numbers) == pytest.approx(-0.5, abs=0.1)
    assert [row["samples"] for row in rows if row["ships"] == "True"] == ["8"]


def test_the_report_says_what_was_measured_and_what_was_not(made):
    assert "darts 1" in made.told
    assert "Start-up, apart:" in made.told
    assert "Exponents of the error by rays and by time, fitted, fresh paint: hard-edged -0." in made.told
    assert "EEVEE: not run: it is left out when there is little time." in made.told
    assert "Lit against unlit: shadows with 8 rays a pixel take" in made.told
    assert f"**{WORN[0].upper()}{WORN[1:]}.**" in made.told


def test_without_a_renderer_the_stage_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^render: Blender: .*No module named 'bpy': pip install"):
        report(nothing, True, Watcher())


def test_an_engine_that_does_not_draw_is_told_of():
    def once():
        raise InputError("render", "its process died with code -11:\nis there enough memory?")

    assert _without_gpu(once, False) == [
        "EEVEE: not run: render: its process died with code -11: is there enough memory?."
    ]
    assert _without_gpu(lambda: 0, False) == []
    assert EEVEE_ONCE.sampling.engine == "eevee"


def test_what_is_asked_of_the_renderer():
    every, few = settings(False), settings(True)
    assert [one.samples for (family, _), one in every.items() if family == HARD] == [1, 4, 16, 64, 256]
    assert all(one.sampling.hard or one.samples > 1 for (family, _), one in every.items() if family != COVERAGE)
    assert {one.sampling.filter for one in every.values()} == {"box", "gaussian", "blackman-harris"}
    assert {one.sampling.denoise for one in every.values()} == {False, True}
    assert EEVEE in {family for family, _ in every} and EEVEE not in {family for family, _ in few}
    assert all(one.sampling.seed == 0 for one in every.values())


def test_the_exact_share_is_that_of_the_boundary_integral():
    frame = Frame(90, 70, 20)
    shown = edges.scene(FRESH, frame)
    share = exact(shown)
    assert np.abs(share - coverage(outline(shown.markings[0], shown.curvature), frame)).max() < 1e-9
    assert edges.edges(share).sum() > 100


def test_a_picture_of_decals_over_ground():
    decals = np.zeros((1, 2, 4), np.float32)
    decals[0, 1] = (*to_linear(np.array(marked.FRESH.rgb)), 1.0)
    assert np.allclose(picture(decals), [[[marked.TONE] * 3, marked.FRESH.rgb]], atol=1e-3)
    assert np.allclose(fresh(np.array([[0.0, 1.0]])), [[[marked.TONE] * 3, marked.FRESH.rgb]], atol=1e-9)
    told = edges.errors(picture(decals) + 2.0, picture(decals), np.ones((1, 2), bool))
    assert told["error"] == pytest.approx(2.0)
