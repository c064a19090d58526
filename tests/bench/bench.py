"""`make bench`: images a second, by stage and on all cores, beside a plain-OpenCV composite of the same scenes.

The images are made by the real workers of a run, with every effect in every image.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import attrs
import click
import cv2
from opencv_composite import composite

from pavemark.background.index import Entry, index
from pavemark.background.plates import make_plate
from pavemark.cli import WORKER
from pavemark.job.config import Job, read
from pavemark.job.crew import Crew, Task
from pavemark.job.folder import Folder
from pavemark.job.order import place
from pavemark.plan import plan
from pavemark.records import from_json
from pavemark.scene import Scene

WANTED = 0.25
"""Seconds an image of 600×600 may take one worker, with everything on."""

EVERY = {"rate": 1.0}
EVERYTHING = {
    "layout": {"empty_rate": 0.0, "symbol_rate": 1.0},
    "texture": {
        name: EVERY for name in ("grain", "wear", "chips", "cracks", "dirt", "pattern", "fade", "former", "tyres")
    },
    "noise": EVERY,
    "curvature": EVERY,
    "brightness": EVERY,
    "optics": EVERY,
}

DEMO = Path(__file__).parents[2] / "assets/demo/job.toml"


class Bench:
    """A job whose images are made by workers, and watched."""

    def __init__(self, job: Job, out: Path) -> None:
        self.job = job
        self.out = out
        self.entries, _ = index(Path(job.images), job.masks and Path(job.masks))

    def entry(self, number: int) -> Entry:
        return self.entries[place(number, len(self.entries), self.job.seed)]

    def make(self, numbers: range, workers: int) -> Iterator[tuple[dict[str, Any], float, int]]:
        """Yields the manifest's row of each image, when it was there, and the resident bytes of a worker."""
        setup = {"job": attrs.asdict(self.job), "out": str(self.out), "patience": 900.0}
        tasks = (Task(n, str(self.entry(n).image), self.entry(n).mask and str(self.entry(n).mask)) for n in numbers)
        with Crew(WORKER, setup, workers, recycle=len(numbers) + 1) as crew:
            for answer in crew.work(tasks):
                if answer.say == "done":
                    yield answer.message["row"], time.perf_counter(), _resident(crew._workers[0].pid)
                elif answer.say != "ready":
                    raise click.ClickException(f"image {answer.task.index}: {answer.message['what']}")

    def scenes(self, numbers: range) -> Iterator[tuple[Scene, Entry]]:
        folder = Folder.of(self.out, self.job)
        for number in numbers:
            yield from_json(Scene, folder.paths(number)["scene"]), self.entry(number)


def _resident(pid: int) -> int:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _opencv(bench: Bench, numbers: range) -> list[float]:
    job, seconds = bench.job, []
    cv2.setNumThreads(1)
    for scene, entry in bench.scenes(numbers):
        plate = make_plate(entry.image, entry.mask, job.pixels_per_metre, job.mask, job.inpainter)
        if plan(scene).passes:
            start = time.perf_counter()
            composite(scene, plate)
            seconds.append(time.perf_counter() - start)
    return seconds


@click.command()
@click.argument("job_file", metavar="[JOB.toml]", default=DEMO, type=click.Path(path_type=Path))
@click.option("--count", default=100, show_default=True, type=click.IntRange(20), help="Images.")
@click.option("--memory", is_flag=True, help="Go on to ten times as many with one worker: does its memory grow?")
def main(job_file: Path, count: int, memory: bool) -> None:
    """Measure how fast images are made; the job file says of which, the demo images unless told."""
    job = read(job_file, EVERYTHING)
    cores = len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder:
        os.environ["PAVEMARK_CACHE"] = f"{folder}/cache"
        bench = Bench(job, Path(folder) / "out")
        inputs = len(bench.entries)
        count = max(count, 2 * inputs)
        load = os.getloadavg()[0]
        print(f"{platform.machine()}, {cores} cores (load {load:.1f}), Python {platform.python_version()}", flush=True)

        one, resident = [], []
        for row, _, now in bench.make(range(10 * count if memory else count), 1):
            one.append(row["timings"])
            resident.append(now)
        # A plate is made when its image comes for the first time, and read from the cache ever after.
        again = one[inputs:]
        print(f"{count} images, everything on, 1 worker of 1 thread, median seconds by stage:")
        for stage in again[0]:
            print(f"  {stage:8} {median(row[stage] for row in again):7.3f}")
        whole = median(sum(row.values()) for row in again)
        print(f"  {'all':8} {whole:7.3f}   {1 / whole:.2f} images/s; wanted at 600×600: at most {WANTED} s")
        print(f"  a plate, the first time its image comes: {median(row['plate'] for row in one[:inputs]):.2f} s")

        times = [when for _, when, _ in bench.make(range(count), cores)]
        warm = max(cores, count // 10)
        rate = (len(times) - 1 - warm) / (times[-1] - times[warm])
        print(f"{cores} workers of 1 thread: {rate:.2f} images/s, {rate * whole:.2f}× one")

        plain = median(_opencv(bench, range(count)))
        ours = median(row.get("render", 0.0) + row["compose"] for row in again)
        print(f"The same scenes in plain OpenCV {cv2.__version__}, 1 thread: {plain:.3f} s; ours: {ours:.3f} s")
        # What is resident at a moment swings by 20 MB with the image in flight: the median of the last of each part.
        first, last = (median(resident[end - count // 2 : end]) / 2**20 for end in (count, len(resident)))
        print(f"Memory of the worker up to image {count}: {first:.0f} MB", end="")
        if memory:
            print(f", up to {10 * count}: {last:.0f} MB ({last / first - 1:+.1%}; wanted: at most +10 %)", end="")
        print()


if __name__ == "__main__":
    sys.exit(main())
