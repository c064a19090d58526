"""`pavemark select`: which images of a dataset a detector should learn from."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark.cli.words import LAST_SEED, Folder, Number
from pavemark.errors import InputError
from pavemark.job.progress import shown
from pavemark.select.choice import LIKE_REAL, STRATEGIES, Wanted
from pavemark.select.material import WAYS

LEARNABLE = "learnable"

SOME_LACK = 1

MOST = 10**9
"""Images that can be asked for."""


@click.command()
@click.argument("dataset", metavar="DATASET", type=Folder(path_type=Path))
@click.option("--scores", metavar="SCORES", required=True, type=Folder(path_type=Path), help="From pavemark score.")
@click.option("--keep", metavar="N", required=True, type=click.IntRange(1, MOST), help="Images to keep.")
@click.option("--strategy", type=click.Choice(STRATEGIES), default="cfds", show_default=True, help="Which come first.")
@click.option("--out", metavar="DIR", required=True, type=Folder(path_type=Path), help="Where the selection goes.")
@click.option("--materialize", type=click.Choice(WAYS), help="Put the images and labels there as well.")
@click.option(
    "--seed", type=click.IntRange(0, LAST_SEED), default=0, show_default=True, help="For random and coverage."
)
@click.option("--quantiles", type=click.IntRange(1), default=4, show_default=True, help="Of the loss, for coverage.")
@click.option("--scores-learner", metavar="SCORES", type=Folder(path_type=Path), help="Of who learns, for learnable.")
@click.option(
    "--learnable",
    metavar="Q",
    type=Number(0, 1, min_open=True),
    default=0.75,
    show_default=True,
    help="For learnable: beyond this quantile of the loss under --scores nothing can be learned.",
)
@click.option("--scores-real", metavar="SCORES", type=Folder(path_type=Path), help="Of real images, for like-real.")
@click.option("--cap-per-plate", metavar="K", type=click.IntRange(1), help="Most images of one plate.")
@click.option("--drop-hardest", metavar="SHARE", type=Number(0, 1), default=0.0, help="Of most loss: never.")
@click.option(
    "--near-duplicates",
    metavar="DISTANCE",
    type=Number(0, 2, min_open=True),
    help="Of images nearer than this, 1 - cosine of their embeddings, keep the first.",
)
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
def select(
    dataset: Path,
    scores: Path,
    out: Path,
    materialize: str | None,
    scores_learner: Path | None,
    scores_real: Path | None,
    quiet: bool,
    **asked,
) -> int:
    """Keep the images of a dataset that help a detector most.

    \b
    cfds       close to far, as in the paper: least loss first
    ehds       whole domains, the easiest first
    random     any, by --seed
    coverage   evenly over how hard they are, domains and plates
    learnable  much loss under --scores-learner, little under --scores
    like-real  for each image of --scores-real one that looks most like it
    """
    # Blender's Python, which renders through this command line, has no pyarrow.
    from pavemark.select import selection  # noqa: PLC0415
    from pavemark.select.report import NAME  # noqa: PLC0415

    if (asked["strategy"] == LEARNABLE) != (scores_learner is not None):
        raise InputError("--scores-learner", f"goes with --strategy {LEARNABLE}, and it needs it")
    if (asked["strategy"] == LIKE_REAL) != (scores_real is not None):
        raise InputError("--scores-real", f"goes with --strategy {LIKE_REAL}, and it needs it")
    progress = shown(quiet)
    with progress.of(asked["keep"]):
        came = selection.select(
            dataset,
            scores,
            out,
            Wanted(**asked),
            scores_learner,
            scores_real,
            materialize,
            lambda: progress.step(lacking=False),
            progress.tell,
        )
    lack = f"; {came.left_out} left out" if came.left_out else ""
    progress.end(f"{came.kept} of {came.images} images kept in {out}{lack}; to be looked at: {out / NAME}")
    return SOME_LACK if came.left_out else 0
