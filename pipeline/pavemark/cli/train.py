"""`pavemark train`: make the networks that ship with Pavemark anew."""

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
from pavemark.errors import InputError
from pavemark.system import cores
from pavemark.training.pool import drawn

VIEWS = {"segmenter": 4000, "inpainter": 1600}
STEPS = {"segmenter": 7000, "inpainter": 6000}
"""What the shipped networks were trained on, and for how long."""

EVERY = 100
"""Steps between two lines where there is no terminal."""


@click.command()
@click.argument("network", type=click.Choice(list(STEPS)))
@click.option("--out", metavar="FILE", required=True, type=click.Path(path_type=Path), help="The model, ONNX.")
@click.option(
    "--views", type=click.IntRange(100, 10**6), show_default="segmenter 4000, inpainter 1600", help="Pictures to draw."
)
@click.option(
    "--steps", type=click.IntRange(1), show_default="segmenter 7000, inpainter 6000", help="Steps of training."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="All else follows from it.")
@click.option("--threads", type=click.IntRange(1), default=cores, show_default="all cores", help="Of the training.")
@click.option("--workers", type=click.IntRange(1), default=cores, show_default="all cores", help="Of the drawing.")
@click.option(
    "--pool", "kept", metavar="DIR", type=click.Path(path_type=Path), help="Where the views are kept, 0.9 MB each."
)
def train(
    network: str,
    out: Path,
    views: int | None,
    steps: int | None,
    seed: int,
    threads: int,
    workers: int,
    kept: Path | None,
) -> None:
    """Train the segmenter or the inpainter, on pictures that are drawn for it.

    Needs torch: pip install 'pavemark[train]'. The same command again goes on where it was stopped. Hours on a CPU.
    """
    if out.suffix != ".onnx":
        raise InputError("--out", f"{out}: a file ending in .onnx is allowed")
    if out.exists():
        raise InputError(out, "is there already: it would be overwritten; another --out is allowed")
    trained = _trained(network)
    views = VIEWS[network] if views is None else views
    steps = STEPS[network] if steps is None else steps
    folder = cache.folder() / "views" if kept is None else kept
    for written in (out.parent, folder):
        files.writable(written)
    with _shown("views", views) as tell:
        pool = drawn(folder, views, seed, workers, lambda done: tell(done, {}))
    with _shown("steps", steps) as tell:
        trained.train(pool, out, steps, seed, threads, tell)
    click.echo(f"{out}  {out.stat().st_size / 1e6:.1f} MB")


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
