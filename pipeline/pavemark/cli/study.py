"""`pavemark study`: what synthetic images are worth, measured on real ones of unseen places."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark import files
from pavemark.cli.words import File, Folder
from pavemark.job.folder import spare
from pavemark.system import cores


@click.command()
@click.argument("study_file", metavar="STUDY.toml", type=File(path_type=Path))
@click.option(
    "--out", metavar="DIR", required=True, type=Folder(path_type=Path), help="Where all that it makes is kept."
)
@click.option("--real", metavar="DIR", type=Folder(path_type=Path), help="Real images, in place of the file's own.")
@click.option("--only", metavar="ROW", multiple=True, help="Conduct these rows of it, and the one that judges.")
@click.option("--told", is_flag=True, help="Train nothing: tables of the rows whose detectors are there.")
@click.option("--workers", type=click.IntRange(1, 1024), default=cores, show_default="all cores", help="Processes.")
def study(study_file: Path, out: Path, real: Path | None, only: tuple[str, ...], told: bool, workers: int) -> None:
    """Train detectors on real and synthetic images, and judge them on real ones of places they never saw.

    Needs torch: pip install 'pavemark[train]'. The same command again goes on where it was stopped; what is there
    already is not made again. The tables go to DIR/tables.md. Hours on a CPU.
    """
    # Blender's Python, which renders through this command line, has no pyarrow.
    from pavemark.study import design  # noqa: PLC0415
    from pavemark.study.conduct import conduct  # noqa: PLC0415
    from pavemark.study.tables import tables  # noqa: PLC0415

    wanted = design.only(design.read(study_file, real), only)
    spare(out, (), (wanted.real,), "")
    out = out.absolute()
    files.writable(out)
    written = tables(conduct(wanted, out, workers, click.echo, told), wanted.judge)
    files.write(out / "tables.md", written)
    click.echo(f"\n{written}\n{out / 'tables.md'}")
