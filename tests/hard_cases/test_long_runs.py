"""Long runs: the last image of a large job, and two thousand images in one process."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from commandline import contents, pavemark
from pavemark import records
from pavemark.background.index import index
from pavemark.compose.image import compose
from pavemark.ground import Frame
from pavemark.job.config import read
from pavemark.job.folder import Folder
from pavemark.job.image import make_image
from pavemark.job.order import place
from pavemark.plan import plan
from pavemark.randomize.domains import Domains, preset
from pavemark.randomize.scene import randomize
from scenes import plate

ROOT = Path(__file__).parents[2]
COUNT = 300_000
LAST = COUNT - 1

SCENES, ROUNDS = 100, 20
"""Two thousand images: the same hundred, over and over, so that each hundred can be held against the first."""

GROWTH = 10_000
"""Bytes an image by which memory may grow: a fifteenth of the smallest thing that could be left behind, one marking's
sheet of 96 × 96 pixels of 16 bytes. Allocators and Blender itself take some 1,600."""

SLOWER = 1.5
"""Times as long that the last hundred may take: were a tenth of the time spent on what earlier images left behind, it
would have grown twentyfold, and the whole threefold."""


@pytest.fixture
def large_job(arguments):
    """The small job's arguments with as many images as a large one's."""
    return [
        str(COUNT) if before == "--count" else word for before, word in zip(["", *arguments], arguments, strict=False)
    ]


@pytest.fixture
def alone(large_job, tmp_path):
    """The dataset of the last image alone: the shard that has no other."""
    out = tmp_path / "alone"
    done = pavemark(*large_job, "--shard", f"{LAST}/{COUNT}", "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    assert [path.name for path in (out / "images").iterdir()] == [f"{LAST}.png"]
    return out


def of_the_last(out):
    """Bytes of its files, by name."""
    return {name: data for name, data in contents(out).items() if Path(name).stem == str(LAST)}


def test_image_299_999_of_a_job_is_the_one_that_is_made_alone(alone, large_job, tmp_path):
    wanted = of_the_last(alone)
    assert len(wanted) == 7
    assert json.loads(wanted[f"scenes/{LAST}.json"])["markings"]
    # Every 50,000th, in two processes that are replaced after two images; and every 100,000th, in one.
    for part, options in ((49_999, ("--workers", "2", "--recycle", "2")), (99_999, ("--workers", "1"))):
        out = tmp_path / str(part)
        done = pavemark(*large_job[:-2], *options, "--shard", f"{part}/{part + 1}", "--out", out)
        assert (done.returncode, done.stderr) == (0, "")
        assert len(list((out / "images").iterdir())) == COUNT // (part + 1)
        assert of_the_last(out) == wanted
    # Made second in a folder that holds the others, it is the same again.
    out = tmp_path / "49999"
    (out / f"images/{LAST}.png").unlink()
    assert pavemark(*large_job, "--shard", f"{LAST}/{COUNT}", "--out", out).returncode == 0
    assert of_the_last(out) == wanted


def test_image_299_999_drawn_by_blender_after_others_is_the_one_that_is_made_alone(
    renderer, inputs, large_job, tmp_path
):
    command = [sys.executable, str(ROOT / "render.py"), *large_job[1:], "--shard", f"{LAST}/{COUNT}"]
    out = tmp_path / "alone"
    done = subprocess.run([*command, "--out", str(out)], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    said = dict(zip(large_job[1::2], large_job[2::2], strict=False))
    options = {name.lstrip("-"): value for name, value in said.items() if name != "--workers"}
    job = read(None, options | {"count": COUNT, "seed": int(options["seed"]), "scale": float(options["scale"])})
    found, _ = index(inputs / "images", inputs / "masks")
    folder = Folder.of(tmp_path / "after", job)
    # This process has drawn whatever came before, and now the ten images before the last.
    for number in range(LAST - 10, COUNT):
        entry = found[place(number, len(found), job.seed)]
        make_image(number, entry.image, entry.mask, job, folder, renderer)
    assert of_the_last(folder.out) == of_the_last(out)


def resident():
    """Bytes of memory that this process holds."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_2000_renders_in_a_process_drift_in_neither_pixels_nor_memory_nor_time(renderer):
    domains = records.structure(Domains, preset("default"), "default.toml")
    ground = plate(Frame(96, 96, 12), texture=6)
    drawn = (randomize(ground, number, 7, domains, (), ((0.9, 0.9), (0.9, 0.9))) for number in range(10 * SCENES))
    scenes = [scene for scene in drawn if plan(scene).passes][:SCENES]
    assert len(scenes) == SCENES

    def made(scene):
        todo = plan(scene)
        return compose(scene, todo, ground, renderer.render(scene, ground, todo))

    first, memory, spent = [made(scene) for scene in scenes], [], []
    for _ in range(ROUNDS):
        times = []
        for scene, wanted in zip(scenes, first, strict=True):
            # The process's own time, on all its threads: others on the machine do not count.
            start = time.process_time()
            image = made(scene)
            times.append(time.process_time() - start)
            np.testing.assert_array_equal(image, wanted)
        spent.append(float(np.median(times)))
        memory.append(resident())
    print(f"{spent[0] * 1e3:.1f} ms, then {spent[-1] * 1e3:.1f}; {(memory[-1] - memory[0]) / 1e6:.2f} MB more")
    assert memory[-1] - memory[0] <= GROWTH * SCENES * (ROUNDS - 1)
    assert spent[-1] <= SLOWER * spent[0]
