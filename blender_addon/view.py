"""What the 3D view shows of a scene: the ground with its decals, on the stage that the renderer uses."""

from __future__ import annotations

import attrs
import bpy
import numpy as np

from pavemark.colour import LUMINANCE, to_display, to_linear, within_gamut
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.scene import Paint, Scene

from . import versions
from .stage import Stage

COLLECTION = "Pavemark view"
MARK = "pavemark_view"
"""Property of all that is made anew with every change; references would not outlive an undo."""

_KINDS = ("objects", "meshes", "materials", "images", "collections")


def show(target: bpy.types.Scene, ground: Plate, scene: Scene | None) -> None:
    """Show a scene in place of what is shown.

    Paint whose colour is a ratio to its ground has that of the ground's mean here: the blend comes with the image.

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
        stage.decals(_coloured(scene, ground), attrs.evolve(plan(scene), colour="absolute"), hard=False)
    for made in stage.made:
        made[MARK] = target.name
        if isinstance(made, bpy.types.Material):
            versions.see_through(made)
        elif isinstance(made, bpy.types.Object):
            made.hide_select = True
    target.view_settings.view_transform = "Standard"


def _coloured(scene: Scene, ground: Plate) -> Scene:
    """The scene with absolute colours that look as its blend makes them look."""
    if plan(scene).colour == "absolute":
        return scene
    light = to_linear(ground.image[ground.ground] if ground.ground.any() else ground.image.reshape(-1, 3)).mean(0)

    def coloured(paint: Paint) -> Paint:
        rgb = to_display(within_gamut(np.array(paint.ratio) * (light @ LUMINANCE), 1.0))
        return attrs.evolve(paint, rgb=tuple(rgb.tolist()))

    markings = tuple(attrs.evolve(marking, paint=coloured(marking.paint)) for marking in scene.markings)
    return attrs.evolve(scene, markings=markings)


def clear(target: bpy.types.Scene) -> None:
    """Remove what is shown of a scene."""
    bpy.data.batch_remove(
        [made for kind in _KINDS for made in getattr(bpy.data, kind) if made.get(MARK) == target.name]
    )
