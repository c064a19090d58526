"""`pavemark models`: networks that users bring."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark.background import models as registry
from pavemark.background.inpainting import METHODS
from pavemark.errors import InputError


@click.group(invoke_without_command=True)
@click.pass_context
def models(context: click.Context) -> None:
    """Networks of your own that fill the ground. Nothing is downloaded."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@models.command()
@click.argument("file", metavar="FILE.onnx", type=click.Path(path_type=Path))
@click.option("--name", help="What jobs call it.  [the file's]")
@click.option("--licence", metavar="TEXT", help="A note on its licence.  [what is known of a published file]")
def add(file: Path, name: str | None, licence: str | None) -> None:
    """Record a model: where its file lies, its kind and its hash."""
    click.echo(_told(registry.add(file, name, licence, {*METHODS, registry.SHIPPED})))


@models.command("list")
def list_() -> int:
    """Say which models are recorded."""
    damaged = 0
    for name in registry.names():
        try:
            click.echo(_told(registry.read(name)))
        except InputError as error:
            click.echo(f"{error}; pavemark models remove {name} forgets it", err=True)
            damaged = 1
    if not registry.names():
        click.echo("none: pavemark models add FILE.onnx records one")
    return damaged


@models.command()
@click.argument("name")
def remove(name: str) -> None:
    """Forget a model. Its file stays."""
    registry.remove(name)


def _told(model: registry.Model) -> str:
    known = registry.KNOWN.get(model.sha256)
    lines = {
        "kind": f"{model.contract}, white is {model.white:g}",
        "sha256": model.sha256,
        "known": f"{known.what} of {known.source}" if known else "no, not one of the published files",
        "licence": model.licence or "not told: --licence TEXT does",
        "file": f"{model.file}, {model.bytes / 1e6:.1f} MB" + ("" if Path(model.file).is_file() else ", is missing"),
    }
    return "\n".join([model.name, *(f"  {what:<9}{told}" for what, told in lines.items())])
