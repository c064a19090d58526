"""`pavemark score`: how far a detector is from the truth of each image of a dataset."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark.cli.words import File, Folder, Number, Part, faults_kept, led
from pavemark.detect.learned import opened
from pavemark.job.journal import Shard
from pavemark.job.progress import shown
from pavemark.system import cores

SOME_LACK = 1


@click.command()
@click.argument("dataset", metavar="DATASET", type=Folder(path_type=Path))
@click.option("--model", metavar="FILE", required=True, type=File(path_type=Path), help="A detector, ONNX.")
@click.option("--out", metavar="SCORES", required=True, type=Folder(path_type=Path), help="Where the scores go.")
@click.option("--workers", type=click.IntRange(1, 1024), default=cores, show_default="all cores", help="Threads.")
@click.option("--shard", type=Part(), default="0/1", help="Score part K of N only, counted from 0.")
@click.option("--height", type=Number(0.1), metavar="M", help="Metres a picture is high, if no label says.")
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
@led
def score(
    dataset: Path,
    model: Path,
    out: Path,
    workers: int,
    shard: Shard,
    height: float | None,
    quiet: bool,
    every: float,
) -> int:
    """Score the images of a dataset by the point loss of a detector, Eq. 2 of the paper.

    Scores are kept in Parquet files of 1,024 images; the same command again scores what lacks. Detectors come from
    pavemark train detector.
    """
    # Blender's Python, which renders through this command line, has no pyarrow.
    from pavemark.select import scoring  # noqa: PLC0415

    progress = shown(quiet, every=every)
    with faults_kept(out):
        part = shard.part, shard.parts
        came = scoring.score(dataset, lambda: opened(model), out, progress, workers, part, height)
    whose = f"part {shard.part}/{shard.parts}: " if shard.parts > 1 else ""
    lack = f"; {came.lacking} cannot be scored" if came.lacking else ""
    progress.end(f"{whose}{came.images - came.lacking} of {came.images} images scored in {out}, {came.made} now{lack}")
    return SOME_LACK if came.lacking else 0
