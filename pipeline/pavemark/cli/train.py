"""`pavemark train`: detectors of your own, and the networks that ship with Pavemark anew."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from pavemark import files
from pavemark.background import cache
from pavemark.cli.words import LAST_SEED, File, Folder, Number
from pavemark.detect.example import Example
from pavemark.detect.reading import examples, hold_labelled
from pavemark.errors import InputError
from pavemark.system import cores, replace
from pavemark.training.pool import drawn

VIEWS = 4000
"""Pictures to draw: the same for both networks, so that they are drawn once."""

STEPS = {"segmenter": 13000, "inpainter": 5000}

EVERY = 100
"""Steps between two lines where there is no terminal."""

DETECTORS = ("dmpr", "gcn", "deepps")
"""Families of detectors that can be trained."""

DETECTOR_STEPS = 6000

FINEST = 30.0
"""Pixels per metre that a detector looks at unless told otherwise, where its images have more: at twice as many it
takes four times as long."""


def _model(context: click.Context, option: click.Parameter, out: Path) -> Path:
    """The model that is to be written."""
    if out.suffix != ".onnx":
        raise InputError("--out", f"{out}: a file ending in .onnx is allowed")
    if out.exists():
        raise InputError(out, "is there already: it would be overwritten; another --out is allowed")
    return out


OUT = click.option(
    "--out",
    metavar="FILE",
    required=True,
    type=click.Path(path_type=Path),
    callback=_model,
    help="The model, ONNX.",
)
SEED = click.option(
    "--seed", type=click.IntRange(0, LAST_SEED), default=0, show_default=True, help="All else follows from it."
)
THREADS = click.option(
    "--threads", type=click.IntRange(1), default=cores, show_default="all cores", help="Of the training."
)


@click.group()
def train() -> None:
    """Train a detector on labelled images, or the networks that ship anew.

    Needs torch: pip install 'pavemark[train]'. The same command again goes on where it was stopped.
    """


def _drawn_for(network: str) -> click.Command:
    """The command that trains a network on pictures that are drawn for it."""

    @click.command(network, help=f"Train the {network}, on pictures that are drawn for it. Hours on a CPU.")
    @OUT
    @click.option(
        "--views", type=click.IntRange(100, 10**6), default=VIEWS, show_default=True, help="Pictures to draw."
    )
    @click.option(
        "--steps", type=click.IntRange(1), default=STEPS[network], show_default=True, help="Steps of training."
    )
    @SEED
    @THREADS
    @click.option("--workers", type=click.IntRange(1), default=cores, show_default="all cores", help="Of the drawing.")
    @click.option(
        "--pool", "kept", metavar="DIR", type=Folder(path_type=Path), help="Where the views are kept, 0.9 MB each."
    )
    def command(out: Path, views: int, steps: int, seed: int, threads: int, workers: int, kept: Path | None) -> None:
        trained = _trained(network)
        folder = cache.folder() / "views" if kept is None else kept
        for written in (out.parent, folder):
            files.writable(written)
        with _shown("views", views) as tell:
            pool = drawn(folder, views, seed, workers, lambda done: tell(done, {}))
        with _shown("steps", steps) as tell:
            trained.train(pool, out, steps, seed, threads, tell)
        click.echo(f"{out}  {out.stat().st_size / 1e6:.1f} MB")

    return command


for _network in STEPS:
    train.add_command(_drawn_for(_network))


@train.command()
@click.option("--family", type=click.Choice(DETECTORS), default="dmpr", show_default=True, help="How pairs are found.")
@click.option(
    "--data",
    "datasets",
    metavar="DATASET",
    multiple=True,
    required=True,
    type=Folder(path_type=Path),
    help="Labelled images: a dataset, a selection of one, or a folder with labels.jsonl. May be given several times.",
)
@click.option(
    "--share",
    "shares",
    type=Number(0, 10**9, min_open=True),
    multiple=True,
    show_default="as many as it has images",
    help="How much is learnt from each --data, in their order.",
)
@OUT
@click.option("--steps", type=click.IntRange(1), default=DETECTOR_STEPS, show_default=True, help="Steps of training.")
@click.option("--batch", type=click.IntRange(2), default=16, show_default=True, help="Images in a step.")
@SEED
@THREADS
@click.option(
    "--scale",
    type=Number(1, 1000),
    show_default=f"the first image's, up to {FINEST:g}",
    help="Pixels per metre that the detector looks at.",
)
@click.option("--height", type=Number(0, min_open=True), help="Metres down a picture, where a list lacks it.")
@click.option("--start", metavar="FILE", type=File(path_type=Path), help="Weights (.pt) to begin from: fine-tuning.")
def detector(
    family: str,
    datasets: tuple[Path, ...],
    shares: tuple[float, ...],
    out: Path,
    steps: int,
    batch: int,
    seed: int,
    threads: int,
    scale: float | None,
    height: float | None,
    start: Path | None,
) -> None:
    """Train a detector of parking slots on labelled images.

    Writes the model and, beside it, its weights (.pt), which a later training can --start from.
    """
    if shares and len(shares) != len(datasets):
        raise InputError("--share", f"{len(shares)} for {len(datasets)} datasets: one for each, or none, is allowed")
    weights = out.with_suffix(".pt")
    if weights.exists():
        raise InputError(weights, "is there already: it would be overwritten; another --out is allowed")
    learning = _learning()
    files.writable(out.parent)
    sets = [_whole(dataset, list(examples(dataset, height))) for dataset in datasets]
    if family != "dmpr" and not any(example.slots is not None for shown in sets for example in shown):
        raise InputError(
            "--family", f"{family}: needs images whose slots are labelled; dmpr is allowed for points alone"
        )
    if scale is None:
        scale = min(FINEST, sets[0][0].frame.scale)
    files.sweep(out.parent)
    # The weights are there when the model is: one without the other would be in the way of the same command again.
    ready = files.aside(weights)
    with _shown("steps", steps) as tell, _gone(ready):
        learning.train(
            family,
            sets,
            out,
            ready,
            steps=steps,
            seed=seed,
            shares=shares or None,
            batch=batch,
            threads=threads,
            pixels_per_metre=scale,
            start=start,
            trained_on=", ".join(dataset.resolve().name for dataset in datasets),
            tell=tell,
        )
        replace(ready, weights)
    click.echo(f"{out}  {out.stat().st_size / 1e6:.1f} MB")


def _whole(dataset: Path, shown: list[Example]) -> list[Example]:
    """The labelled images of a dataset, held before long work: each once, within its picture, which is there."""
    known = [example for example in shown if example.known]
    if len(known) < len(shown):
        what = f"{len(shown) - len(known)} of {len(shown)} images show their plates' own markings painted anew"
        if not known:
            raise InputError(dataset, f"{what}: no label tells their points, and there is nothing to learn from")
        click.echo(f"left out: {dataset}: {what}: no label tells their points", err=True)
    shown, names = known, set()
    for example in shown:
        if example.name in names:
            raise InputError(dataset, f"{example.name}: is listed twice: once is allowed")
        names.add(example.name)
        hold_labelled(example)
    missing = [example.image for example in shown if not example.image.is_file()]
    if missing:
        raise InputError(missing[0], f"is missing, the first of {len(missing)} of the {len(shown)} images of {dataset}")
    return shown


@contextmanager
def _gone(path: Path) -> Iterator[None]:
    """Entered while a file is made that is not to be left behind."""
    try:
        yield
    finally:
        path.unlink(missing_ok=True)


def _learning() -> ModuleType:
    try:
        from pavemark.training.detectors import command  # noqa: PLC0415
    except ImportError as error:
        raise InputError("train detector", f"{error.name} is missing: pip install 'pavemark[train]'") from None
    return command


def _trained(network: str) -> ModuleType:
    """The module that trains a network."""
    try:
        # torch takes seconds to load, and only who trains has it.
        from pavemark.training import inpainter, segmenter  # noqa: PLC0415
    except ImportError as error:
        raise InputError(f"train {network}", f"{error.name} is missing: pip install 'pavemark[train]'") from None
    return {"segmenter": segmenter, "inpainter": inpainter}[network]


@contextmanager
def _shown(what: str, total: int) -> Iterator[Callable[[int, dict[str, float]], None]]:
    """Tells how far it is: a bar in a terminal, a line now and then elsewhere."""
    if not sys.stdout.isatty():

        def line(done: int, told: dict[str, float]) -> None:
            if done % EVERY == 0:
                click.echo(f"{done}/{total} {what}  {_figures(told)}".rstrip())

        yield line
        return
    columns = BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(TextColumn(what), *columns, TextColumn("{task.fields[told]}"), console=Console()) as bar:
        task = bar.add_task("", total=total, told="")

        def draw(done: int, told: dict[str, float]) -> None:
            bar.update(task, completed=done, **({"told": _figures(told)} if told else {}))

        yield draw


def _figures(told: dict[str, float]) -> str:
    return "  ".join(f"{name} {value:.3f}" for name, value in told.items())
