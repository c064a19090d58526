"""What one sample with analytic coverage is worth: edges, ends and joins against many hard-edged samples."""

import time

import attrs
import numpy as np
import pytest
import shapely

from pavemark.geometry.coverage import coverage
from pavemark.geometry.outline import outline
from pavemark.ground import Frame
from pavemark.plan import Pass, Sampling, plan
from pavemark.scene import Curvature, Marking, Scene, Stroke
from scenes import WHITE, plate, rendered, row


def lines(count: int, curvature: Curvature | None, frame: Frame | None = None) -> Scene:
    rng = np.random.default_rng(7)
    strokes = []
    for _ in range(count):
        start, turn, length = rng.uniform(-4, 4, 2), rng.uniform(0, 2 * np.pi), rng.uniform(1, 6)
        end = start + length * np.array((np.cos(turn), np.sin(turn)))
        strokes.append(Stroke((tuple(start), tuple(end)), rng.uniform(0.08, 0.2)))
    scene = row(plate(frame), n=0, curvature=curvature)
    return attrs.evolve(scene, markings=(Marking("slot", WHITE, tuple(strokes)),))


def alpha(renderer, scene: Scene, samples: int = 1, **sampling) -> np.ndarray:
    planned = attrs.evolve(plan(scene), passes=(Pass("decals", samples, Sampling(**sampling)),))
    return renderer.render(scene, plate(scene.plate.frame), planned).decals[..., 3]


def test_one_sample_meets_many_hard_edged_ones(renderer):
    frame = Frame(200, 200, 20)
    scene = lines(12, Curvature(150, 0.4, 1), frame)
    once, reference = rendered(renderer, scene)[..., 3], rendered(renderer, scene, 1024)[..., 3]
    edge = (reference > 0.002) & (reference < 0.998)
    error = 255 * (once - reference)
    assert edge.sum() > 800
    # 1,024 samples are themselves off by up to 255·0.5/√1024 = 4 levels on single pixels, about 0.5 RMSE.
    assert np.sqrt((error[edge] ** 2).mean()) < 1.0
    assert np.abs(error[~edge]).max() < 1.0


def test_a_hard_edged_ray_meets_paint_or_does_not(renderer):
    scene = lines(6, None, Frame(100, 100, 10))
    share = coverage(outline(scene.markings[0], None), scene.plate.frame)
    hard = alpha(renderer, scene, hard=True)
    assert set(np.unique(hard)) == {0.0, 1.0}
    assert (hard[share == 1] == 1).all() and (hard[share == 0] == 0).all()
    assert not np.isin(alpha(renderer, scene), (0.0, 1.0)).all()


def test_what_a_plan_says_of_rays_reaches_blender(renderer):
    scene = lines(6, None, Frame(100, 100, 10))
    share = coverage(outline(scene.markings[0], None), scene.plate.frame)
    edge = (share > 0) & (share < 1)
    made = {
        "box": alpha(renderer, scene, 16),
        "again": alpha(renderer, scene, 16),
        "seed": alpha(renderer, scene, 16, seed=1),
        "wide": alpha(renderer, scene, 16, filter="gaussian", width=3.0),
        "adaptive": alpha(renderer, scene, 64, threshold=0.5),
        "many": alpha(renderer, scene, 64),
    }
    assert np.array_equal(made["box"], made["again"])
    assert not np.array_equal(made["box"], made["seed"])
    error = {name: np.sqrt(((one - share)[edge] ** 2).mean()) for name, one in made.items()}
    assert error["seed"] < 1.5 * error["box"]
    assert error["wide"] > 2 * error["box"]
    assert error["adaptive"] > 1.2 * error["many"]


def test_denoising_softens_what_was_sharp(renderer):
    scene = lines(6, None, Frame(100, 100, 10))
    sharp, soft = (
        renderer.render(
            scene,
            plate(scene.plate.frame),
            attrs.evolve(plan(scene), passes=(Pass("decals", 4, Sampling(denoise=denoise)),)),
        ).decals[..., :3]
        for denoise in (False, True)
    )
    assert not np.allclose(sharp, soft, atol=0.02)


@pytest.mark.slow
def test_one_sample_is_near_1024_at_a_tenth_of_the_time_of_64(renderer):
    scene = lines(12, Curvature(150, 0.4, 1))
    rendered(renderer, scene)[..., 3]
    times = {1: [], 64: []}
    for _ in range(3):
        for samples, spent in times.items():
            start = time.perf_counter()
            rendered(renderer, scene, samples)[..., 3]
            spent.append(time.perf_counter() - start)
    once, reference = rendered(renderer, scene)[..., 3], rendered(renderer, scene, 1024)[..., 3]
    edge = (reference > 0.002) & (reference < 0.998)
    error = 255 * np.sqrt(((once - reference)[edge] ** 2).mean())
    ratio = np.median(times[1]) / np.median(times[64])
    print(f"edge error {error:.2f}/255 over {edge.sum()} pixels; time {ratio:.3f} of 64 samples'")
    assert error <= 3
    assert ratio <= 0.1


def test_alpha_sums_to_the_exact_area(renderer):
    scene = lines(5, None)
    inside = shapely.intersection(outline(scene.markings[0], None), shapely.box(-5, -5, 5, 5))
    # Half floats keep 11 bits.
    assert rendered(renderer, scene)[..., 3].sum() / 60**2 == pytest.approx(inside.area, rel=5e-4)


@pytest.mark.parametrize("size", [(600, 600), (97, 301), (448, 720), (1000, 1000)])
def test_alpha_is_the_coverage_wherever_the_paint_lies(renderer, size):
    """Only a window is rendered; it lands on its own pixels."""
    frame, rng = Frame(*size, 60), np.random.default_rng(size[0])
    for _ in range(8):
        middle = rng.uniform(-0.5, 0.5, 2) * frame.size
        stroke = Stroke((tuple(middle), tuple(middle + rng.uniform(-0.6, 0.6, 2))), 0.1)
        scene = attrs.evolve(lines(1, None, frame), markings=(Marking("slot", WHITE, (stroke,)),))
        share = coverage(outline(scene.markings[0], None), frame)
        assert np.abs(rendered(renderer, scene)[..., 3] - share).max() <= 2**-11  # half floats
