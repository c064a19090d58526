"""`pavemark render`: the main job."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from pavemark.cli.words import Folder, Part, faults_kept, led, told
from pavemark.job.config import read
from pavemark.job.journal import Shard
from pavemark.job.progress import shown
from pavemark.job.run import PATIENCE, RECYCLE, Machine, run
from pavemark.system import cores


@click.command("render")
@click.argument("job_file", metavar="[JOB.toml]", required=False, type=click.Path(path_type=Path))
@click.option("--images", metavar="DIR", type=Folder(), help="Folder of real AVM images.")
@click.option("--masks", metavar="DIR", type=Folder(), help="Folder of their marking masks: PNGs of the same names.")
@click.option("--plates", metavar="DIR", type=Folder(), help="In their place: a folder that pavemark plates made.")
@click.option("--out", metavar="DIR", required=True, type=Folder(path_type=Path), help="Where the dataset goes.")
@click.option("--count", type=int, help="Images to make.  [200]")
@click.option("--seed", type=int, help="Everything random follows from it.  [0]")
@click.option("--preset", metavar="NAME", help="default or paper.")
@click.option("--scale", type=float, metavar="PX/M", help="Pixels per metre of the images.  [60]")
@click.option("--metres-per-pixel", type=float, metavar="M", help="The same, the other way round.")
@click.option("--inpainter", metavar="NAME", help="What fills the ground where markings were.")
@click.option("--segmenter", metavar="NAME", help="What finds the markings where there are no masks.")
@click.option("--max-error", type=float, metavar="E", help="Most 8-bit levels that edges of markings may be off.")
@click.option(
    "--calibration", metavar="FILE", type=click.Path(), help="What --max-error goes by.  [ships with pavemark]"
)
@click.option("--set", "settings", metavar="FIELD=VALUE", multiple=True, help="Any other line of a job file.")
@click.option("--workers", type=click.IntRange(1, 1024), default=cores, show_default="all cores", help="Processes.")
@click.option("--shard", type=Part(), default="0/1", help="Make part K of N only, counted from 0.")
@click.option("--recycle", type=click.IntRange(1), default=RECYCLE, help="Images a process.", hidden=True)
@click.option(
    "--patience", type=click.FloatRange(1.0), default=PATIENCE, help="Seconds an image may take.", hidden=True
)
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
@led
@click.pass_obj
def render(
    command: Sequence[str],
    job_file: Path | None,
    out: Path,
    settings: tuple[str, ...],
    workers: int,
    shard: Shard,
    recycle: int,
    patience: float,
    quiet: bool,
    every: float,
    **options,
) -> int:
    """Make labelled synthetic images from real ones."""
    job = read(job_file, told(settings, options))
    out = out.absolute()
    with faults_kept(out):
        return run(job, out, shard, Machine(tuple(command), workers, recycle, patience), shown(quiet, every=every))
