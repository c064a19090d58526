"""The command line: a command a file."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence

import click

from pavemark import __version__
from pavemark.cli.accuracy import accuracy
from pavemark.cli.evaluate import evaluate
from pavemark.cli.models import models
from pavemark.cli.plates import plates
from pavemark.cli.render import render
from pavemark.cli.score import score
from pavemark.cli.select import select
from pavemark.cli.show import explain, preview
from pavemark.cli.study import study
from pavemark.cli.sweep import sweep
from pavemark.cli.train import train
from pavemark.errors import InputError, one_line
from pavemark.system import reader_gone

BAD_INPUT = 2

WORKER = (sys.executable, "-m", "pavemark.job.worker")
"""Starts a worker with the renderer that is installed."""


@click.group(
    invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, prog_name="pavemark")
@click.pass_context
def pavemark(context: click.Context) -> None:
    """Synthetic around-view-monitor images with exact parking-slot labels."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for _command in (render, plates, preview, explain, models, train, evaluate, score, select, sweep, study, accuracy):
    pavemark.add_command(_command)


def main(arguments: Sequence[str] | None = None, worker: Sequence[str] = WORKER) -> None:
    """Run the command line and leave with its exit code: 0, 1 images lack, 2 bad input, 130 interrupted.

    Parameters
    ----------
    arguments : sequence of str or None
        None takes those of the process.
    worker : sequence of str
        Starts a worker for `render`.
    """
    # A name that the locale has no letters for, as Windows' where stdout is a file, is no reason to stop.
    sys.stdout.reconfigure(errors="backslashreplace")
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
    except Exception as error:
        if isinstance(error, OSError) and reader_gone(error):
            # Whoever read stdout has gone, as `| head` does.
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            return 1
        where = traceback.extract_tb(error.__traceback__)[-1]
        return _refuse(f"unexpected, {type(error).__name__} at {where.filename}:{where.lineno}: {error}")


def _said(error: click.ClickException) -> str:
    if isinstance(error, click.NoSuchOption) and error.possibilities:
        return f"no such option: {error.option_name} (did you mean {error.possibilities[0]}?)"
    return error.format_message()


def _refuse(message: str) -> int:
    print("error:", one_line(" ".join(message.split())), file=sys.stderr)
    return BAD_INPUT
