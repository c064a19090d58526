"""The processes that run beside Blender: one batch and one removal of markings at most, watched by a timer."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from .child import Child
from .edits import redraw_editors

EVERY = 0.3
"""Seconds between two looks."""

BATCH, PLATES = "Batch", "Remove markings"

children: dict[str, Child] = {}
outcomes: dict[str, tuple[str, str]] = {}
"""What came of the last one of each: "INFO", "WARNING" or "ERROR", and a line."""

_then: dict[str, Callable[[], str | None]] = {}


def start(
    what: str,
    command: list[str],
    then: Callable[[], str | None] = lambda: None,
    environment: dict[str, str] | None = None,
) -> None:
    """Start a process and watch it; `then` is called when it has ended, and may say what came of it if all went well.

    Raises
    ------
    OSError
        When it cannot be started.
    """
    child = Child(what)
    child.start(command, environment)
    children[what] = child
    outcomes.pop(what, None)
    _then[what] = then
    if not bpy.app.timers.is_registered(watch):
        bpy.app.timers.register(watch, first_interval=EVERY, persistent=True)


def watch() -> float | None:
    """Look after the processes; seconds until the next look, None when nothing runs."""
    for what, child in list(children.items()):
        if not child.running:
            child.end()
            del children[what]
            kind, line = child.outcome()
            said = _then.pop(what)()
            outcomes[what] = kind, said if said and kind == "INFO" else line
    redraw_editors()
    return EVERY if children else None


def end() -> None:
    """End all of them."""
    for child in children.values():
        child.end()
    children.clear()
    _then.clear()
    outcomes.clear()
    if bpy.app.timers.is_registered(watch):
        bpy.app.timers.unregister(watch)
