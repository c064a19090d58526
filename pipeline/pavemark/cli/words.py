"""What the commands' options have in common."""

from __future__ import annotations

import os

import click


class Folder(click.Path):
    """A path that was given: an unset variable of a shell script is not the working directory."""

    def convert(self, value, param, ctx):
        if not str(value):
            self.fail("it is empty: a folder is needed", param, ctx)
        return super().convert(value, param, ctx)


def cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
