"""`pavemark preview` and `pavemark explain`: what was made, and what a scene calls for."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import click

from pavemark.detect.reading import SELECTION, manifest, source
from pavemark.job.explain import explain as explained
from pavemark.job.explain import explain_json
from pavemark.job.preview import preview as drawn


@click.command()
@click.argument("out", type=click.Path(path_type=Path))
def preview(out: Path) -> None:
    """Draw one contact sheet: image, plate, labels drawn over, masks. Of a selection: of images it keeps."""
    if (out / SELECTION).exists():
        kept = (PurePosixPath(name).name for name, _ in manifest(out))
        click.echo(drawn(source(out), out / "preview.png", kept))
    else:
        click.echo(drawn(out))


@click.command()
@click.argument("scene", metavar="SCENE.json", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="For programs.")
def explain(scene: Path, as_json: bool) -> None:
    """Say what a scene calls for: effects, passes, steps."""
    click.echo(explain_json(scene) if as_json else explained(scene))
