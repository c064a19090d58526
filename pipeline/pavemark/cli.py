"""The command line."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import click

from pavemark import __version__
from pavemark.errors import InputError, one_line
from pavemark.job.config import merge, read, setting
from pavemark.job.explain import explain, explain_json
from pavemark.job.journal import Shard
from pavemark.job.preview import preview
from pavemark.job.progress import shown
from pavemark.job.run import LOG, PATIENCE, RECYCLE, Machine, log, run

BAD_INPUT = 2

WORKER = (sys.executable, "-m", "pavemark.job.worker")
"""Starts a worker with the renderer that is installed."""


class _Shard(click.ParamType):
    name = "K/N"

    def convert(self, value, param, ctx):
        part, _, parts = value.partition("/")
        if not (part.isdecimal() and parts.isdecimal() and int(part) < int(parts)):
            self.fail(f"{value!r}: allowed is K/N with K from 0 to N - 1, such as 3/16", param, ctx)
        return Shard(int(part), int(parts))


class _Folder(click.Path):
    """A path that was given: an unset variable of a shell script is not the working directory."""

    def convert(self, value, param, ctx):
        if not str(value):
            self.fail("it is empty: a folder is needed", param, ctx)
        return super().convert(value, param, ctx)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@click.group(
    invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, prog_name="pavemark")
@click.pass_context
def pavemark(context: click.Context) -> None:
    """Synthetic around-view-monitor images with exact parking-slot labels."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@pavemark.command("render")
@click.argument("job_file", metavar="[JOB.toml]", required=False, type=click.Path(path_type=Path))
@click.option("--images", metavar="DIR", type=_Folder(), help="Folder of real AVM images.")
@click.option("--masks", metavar="DIR", type=_Folder(), help="Folder of their marking masks: PNGs of the same names.")
@click.option("--out", metavar="DIR", required=True, type=_Folder(path_type=Path), help="Where the dataset goes.")
@click.option("--count", type=int, help="Images to make.  [200]")
@click.option("--seed", type=int, help="Everything random follows from it.  [0]")
@click.option("--preset", metavar="NAME", help="default or paper.")
@click.option("--scale", type=float, metavar="PX/M", help="Pixels per metre of the images.  [60]")
@click.option("--metres-per-pixel", type=float, metavar="M", help="The same, the other way round.")
@click.option("--inpainter", metavar="NAME", help="What fills the ground where markings were.")
@click.option("--set", "settings", metavar="FIELD=VALUE", multiple=True, help="Any other line of a job file.")
@click.option("--workers", type=click.IntRange(1, 1024), default=_cores, show_default="all cores", help="Processes.")
@click.option("--shard", type=_Shard(), default="0/1", help="Make part K of N only, counted from 0.")
@click.option("--recycle", type=click.IntRange(1), default=RECYCLE, help="Images a process.", hidden=True)
@click.option(
    "--patience", type=click.FloatRange(1.0), default=PATIENCE, help="Seconds an image may take.", hidden=True
)
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
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
    **options,
) -> int:
    """Make labelled synthetic images from real ones."""
    told: dict = {}
    for text in settings:
        told = merge(told, setting(text))
    told |= {name: value for name, value in options.items() if value is not None}
    job = read(job_file, told)
    out = out.absolute()
    try:
        return run(job, out, shard, Machine(tuple(command), workers, recycle, patience), shown(quiet))
    except (InputError, BrokenPipeError):
        raise
    except Exception as error:
        log(out, "the run", traceback.format_exc())
        raise InputError(out / LOG, f"an unexpected fault is told there ({type(error).__name__}: {error})") from error


@pavemark.command("preview")
@click.argument("out", type=click.Path(path_type=Path))
def _preview(out: Path) -> None:
    """Draw one contact sheet: image, plate, labels drawn over, masks."""
    click.echo(preview(out))


@pavemark.command("explain")
@click.argument("scene", metavar="SCENE.json", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="For programs.")
def _explain(scene: Path, as_json: bool) -> None:
    """Say what a scene calls for: effects, passes, steps."""
    click.echo(explain_json(scene) if as_json else explain(scene))


def main(arguments: Sequence[str] | None = None, worker: Sequence[str] = WORKER) -> None:
    """Run the command line and leave with its exit code: 0, 1 images lack, 2 bad input, 130 interrupted.

    Parameters
    ----------
    arguments : sequence of str or None
        None takes those of the process.
    worker : sequence of str
        Starts a worker for `render`.
    """
    sys.exit(_run(arguments, worker))


def _run(arguments: Sequence[str] | None, worker: Sequence[str]) -> int:
    try:
        return pavemark.main(arguments, prog_name="pavemark", standalone_mode=False, obj=tuple(worker)) or 0
    except InputError as error:
        return _refuse(str(error))
    except click.ClickException as error:
        return _refuse(_said(error))
    except (KeyboardInterrupt, click.Abort):
        return 130
    except BrokenPipeError:
        # Whoever read stdout has gone, as `| head` does.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        return _refuse(f"unexpected, {type(error).__name__} at {where.filename}:{where.lineno}: {error}")


def _said(error: click.ClickException) -> str:
    if isinstance(error, click.NoSuchOption) and error.possibilities:
        return f"no such option: {error.option_name} (did you mean {error.possibilities[0]}?)"
    return error.format_message()


def _refuse(message: str) -> int:
    print("error:", one_line(" ".join(message.split())), file=sys.stderr)
    return BAD_INPUT
