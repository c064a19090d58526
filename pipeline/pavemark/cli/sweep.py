"""`pavemark sweep`: how many images of a selection a detector should learn from."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark import files
from pavemark.cli.select import LEARNABLE, STRATEGIES
from pavemark.cli.words import LAST_SEED, Folder, Number
from pavemark.job.folder import spare
from pavemark.select.choice import LIKE_REAL
from pavemark.system import cores

ORDERS = tuple(strategy for strategy in STRATEGIES if strategy not in (LEARNABLE, LIKE_REAL))
"""Strategies that need no scores but those of one detector."""


@click.command()
@click.argument("dataset", metavar="DATASET", type=Folder(path_type=Path))
@click.option("--scores", metavar="SCORES", required=True, type=Folder(path_type=Path), help="From pavemark score.")
@click.option("--test", metavar="DATASET", required=True, type=Folder(path_type=Path), help="What figures are of.")
@click.option(
    "--validation", metavar="DATASET", required=True, type=Folder(path_type=Path), help="Chooses the confidence."
)
@click.option("--keep", metavar="N", multiple=True, required=True, type=click.IntRange(1), help="Images; several.")
@click.option("--seeds", metavar="K", type=click.IntRange(1, 1000), default=3, show_default=True, help="0 to K - 1.")
@click.option("--strategy", type=click.Choice(ORDERS), default="cfds", show_default=True, help="Which come first.")
@click.option(
    "--seed", type=click.IntRange(0, LAST_SEED), default=0, show_default=True, help="For random and coverage."
)
@click.option("--steps", type=click.IntRange(1, 10**7), default=1500, show_default=True, help="Steps of training.")
@click.option("--batch", type=click.IntRange(2, 4096), default=32, show_default=True, help="Images in a step.")
@click.option(
    "--height",
    metavar="M",
    type=Number(0, min_open=True),
    help="Metres down a picture of --test and --validation, where a list lacks it.",
)
@click.option(
    "--scale",
    metavar="PX/M",
    type=Number(1, 1000),
    show_default="the first image's, up to 30",
    help="Pixels per metre that the detectors look at.",
)
@click.option("--workers", type=click.IntRange(1, 1024), default=cores, show_default="all cores", help="Processes.")
@click.option("--out", metavar="DIR", required=True, type=Folder(path_type=Path), help="Where all of it is kept.")
def sweep(
    dataset: Path,
    scores: Path,
    test: Path,
    validation: Path,
    keep: tuple[int, ...],
    steps: int,
    batch: int,
    workers: int,
    out: Path,
    **asked,
) -> int:
    """Train detectors on the first N images of a selection, for several N, and find the N that is best.

    A detector for each --keep and seed, judged by marking points; the table says which N are as good as the best
    within the noise of the seeds. Needs torch: pip install 'pavemark[train]'. The same command again goes on where it
    was stopped; what is there already is not made again. Hours on a CPU.
    """
    # Blender's Python, which renders through this command line, has no pyarrow.
    from pavemark.study import quantity  # noqa: PLC0415
    from pavemark.study.design import Training  # noqa: PLC0415
    from pavemark.study.sweep import Sweep  # noqa: PLC0415
    from pavemark.study.sweep import sweep as swept  # noqa: PLC0415

    spare(out, (), map(str, (dataset, scores, test, validation)), "")
    wanted = Sweep(dataset, scores, test, validation, keep, training=Training(steps=steps, batch=batch), **asked)
    files.writable(out)
    faults = 0

    def left_out(line: str) -> None:
        nonlocal faults
        faults += 1
        click.echo(line, err=True)

    trials = swept(wanted, out.absolute(), workers, click.echo, left_out)
    written = quantity.write(wanted, trials, out.absolute())
    click.echo(f"\n{written}\n{out / 'sweep.md'}")
    if not any(trial.figures["validation"]["f1"] for trial in trials):
        click.echo(f"{validation}: no point found there is right: no confidence is better than another", err=True)
    return int(bool(faults))
