"""Whether a changed property is somebody's wish: sliders that are set to show a scene wish nothing."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy

from pavemark.errors import InputError, one_line

_deaf = 0


@contextmanager
def deaf() -> Iterator[None]:
    """Entered while properties are set to show what is, not what is wanted."""
    global _deaf  # noqa: PLW0603 - update callbacks have no other way to tell
    _deaf += 1
    try:
        yield
    finally:
        _deaf -= 1


def heard(act: Callable[[bpy.types.Scene], None]) -> Callable[[object, bpy.types.Context], None]:
    """An update callback that acts on the scene whose property a person, or a script, has changed.

    What cannot be done is told in the panel: a callback has no operator to report by.
    """

    def update(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
        if _deaf:
            return
        target = group.id_data
        with deaf():
            target.pavemark.trouble = ""
            try:
                act(target)
            except (InputError, ValueError, OSError) as error:
                target.pavemark.trouble = one_line(str(error))

    return update
