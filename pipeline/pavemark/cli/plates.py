"""`pavemark plates`: clean backgrounds, to be looked at and mended before images are made of them."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark.cli.words import Folder, faults_kept, led, told
from pavemark.job.config import read_inputs
from pavemark.job.plates import WORKER, make
from pavemark.job.progress import shown
from pavemark.job.run import PATIENCE, RECYCLE, Machine
from pavemark.system import cores


@click.command()
@click.argument("images", metavar="IMAGES", type=Folder())
@click.option("--masks", metavar="DIR", type=Folder(), help="Folder of their marking masks: PNGs of the same names.")
@click.option("--out", metavar="PLATES", required=True, type=Folder(path_type=Path), help="Where the plates go.")
@click.option("--scale", type=float, metavar="PX/M", help="Pixels per metre of the images.  [60]")
@click.option("--metres-per-pixel", type=float, metavar="M", help="The same, the other way round.")
@click.option("--inpainter", metavar="NAME", help="What fills the ground where markings were.")
@click.option("--segmenter", metavar="NAME", help="What finds the markings where there are no masks.")
@click.option(
    "--set", "settings", metavar="FIELD=VALUE", multiple=True, help="A line of a job file, as 'mask.ground = [0]'."
)
@click.option("--workers", type=click.IntRange(1, 1024), default=cores, show_default="all cores", help="Processes.")
@click.option("--recycle", type=click.IntRange(1), default=RECYCLE, help="Plates a process.", hidden=True)
@click.option("--patience", type=click.FloatRange(1.0), default=PATIENCE, help="Seconds a plate may take.", hidden=True)
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
@led
def plates(
    out: Path,
    settings: tuple[str, ...],
    workers: int,
    recycle: int,
    patience: float,
    quiet: bool,
    every: float,
    **options,
) -> int:
    """Take the markings off images, and draw a contact sheet of what came of it."""
    inputs = read_inputs(told(settings, options))
    out = out.absolute()
    with faults_kept(out):
        return make(inputs, out, Machine(WORKER, workers, recycle, patience), shown(quiet, "plates", every))
