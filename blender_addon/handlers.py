"""What happens to a file from outside of the panel: it is loaded, undone, its curves are dragged."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from pavemark.errors import InputError, one_line

from . import document, lines
from .properties.hearing import deaf

AFTER = 0.05
"""Seconds from a drag to what it changes: one look for all that a stroke of the hand reports."""


def settle() -> None:
    """Have every scene follow its curves, and show it."""
    for target in bpy.data.scenes:
        if target.pavemark.document or target.pavemark.background.name:
            with deaf():
                try:
                    target.pavemark.trouble = ""
                    document.look(target)
                except (InputError, OSError) as error:
                    target.pavemark.trouble = one_line(str(error))


def follow() -> None:
    """Have every scene whose curves have moved follow them, and show it."""
    for target in bpy.data.scenes:
        if target.pavemark.document:
            with deaf():
                before = target.pavemark.document
                try:
                    document.current(target)
                    target.pavemark.trouble = ""
                    if target.pavemark.document != before:
                        document.look(target)
                except (InputError, OSError) as error:
                    target.pavemark.trouble = one_line(str(error))


@persistent
def restored(*_: object) -> None:
    """A file was loaded, or a step was undone or done again."""
    settle()


@persistent
def moved(_: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Something was evaluated anew: where it was a marking's curves, they are followed once this is over."""
    if bpy.app.timers.is_registered(follow):
        return
    for update in depsgraph.updates:
        changed = update.id
        if isinstance(changed, bpy.types.Object) and lines.NUMBER in changed:
            bpy.app.timers.register(follow, first_interval=AFTER)
            return


LISTS = {
    "load_post": restored,
    "undo_post": restored,
    "redo_post": restored,
    "depsgraph_update_post": moved,
}


def register() -> None:
    """Hear of it."""
    for name, handler in LISTS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Hear of it no more."""
    for name, handler in LISTS.items():
        there = getattr(bpy.app.handlers, name)
        if handler in there:
            there.remove(handler)
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)
