"""What the 3D view shows of a scene: the ground with its decals, on the stage that the renderer uses."""

from __future__ import annotations

import attrs
import bpy

from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.scene import Scene

from . import versions
from .stage import Stage

COLLECTION = "Pavemark view"
MARK = "pavemark_view"
"""Property of all that is made anew with every change; references would not outlive an undo."""

_KINDS = ("objects", "meshes", "materials", "images", "collections")


def show(target: bpy.types.Scene, ground: Plate, scene: Scene | None) -> None:
    """Show a scene in place of what is shown.

    Paint has its absolute colour here, whatever the blend: a ratio to the ground is no colour to look at.

    Parameters
    ----------
    ground : Plate
        What lies on the ground.
    scene : Scene or None
        None shows the ground alone.
    """
    clear(target)
    stage = Stage(target, COLLECTION)
    stage.ground(ground)
    if scene is not None:
        stage.decals(scene, attrs.evolve(plan(scene), colour="absolute"), hard=False)
    for made in stage.made:
        made[MARK] = target.name
        if isinstance(made, bpy.types.Material):
            versions.see_through(made)
        elif isinstance(made, bpy.types.Object):
            made.hide_select = True
    target.view_settings.view_transform = "Standard"


def clear(target: bpy.types.Scene) -> None:
    """Remove what is shown of a scene."""
    bpy.data.batch_remove(
        [made for kind in _KINDS for made in getattr(bpy.data, kind) if made.get(MARK) == target.name]
    )
