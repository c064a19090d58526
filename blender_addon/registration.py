"""All that the extension makes known to Blender, and takes back."""

from __future__ import annotations

import bpy

from . import handlers, operators, overlay, panel, running
from .properties import root

CLASSES = (*root.CLASSES, *operators.CLASSES, *panel.CLASSES)


def register() -> None:
    """Classes, properties, handlers."""
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.pavemark = bpy.props.PointerProperty(type=root.PAVEMARK_PG_scene)
    handlers.register()
    overlay.register()


def unregister() -> None:
    """Handlers, properties, classes; processes that still run are ended."""
    running.end()
    overlay.unregister()
    handlers.unregister()
    del bpy.types.Scene.pavemark
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
