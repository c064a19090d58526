"""The markings as curves in the open file: laid out from a scene, and read back as hands have left them."""

from __future__ import annotations

import bpy

from pavemark.geometry.follow import Drawn
from pavemark.scene import Marking, Scene

from . import curves
from .stage import Stage

COLLECTION = "Pavemark markings"
NUMBER = "pavemark_marking"
"""Of a curve's marking in the scene: an object's own property, which a duplicate keeps."""


def lay(target: bpy.types.Scene, scene: Scene) -> None:
    """Lay out the curves of a scene in place of those that are there."""
    bpy.data.batch_remove([made for shown in _objects(target) for made in (shown, shown.data)])
    for there in [each for each in target.collection.children if each.name.startswith(COLLECTION)]:
        bpy.data.collections.remove(there)
    stage = Stage(target, COLLECTION)
    for number, marking in enumerate(scene.markings):
        for shown in stage.curves(number, marking):
            shown[NUMBER] = number
            shown.show_in_front = True


def add(target: bpy.types.Scene, number: int, marking: Marking) -> tuple[bpy.types.Object, ...]:
    """Lay out one more marking."""
    stage = Stage(target, COLLECTION)
    made = stage.curves(number, marking)
    home = next((each for each in target.collection.children if each.name == COLLECTION), stage.collection)
    for shown in made:
        shown[NUMBER] = number
        shown.show_in_front = True
        if home != stage.collection:
            home.objects.link(shown)
            stage.collection.objects.unlink(shown)
    if home != stage.collection:
        bpy.data.collections.remove(stage.collection)
    return made


def read(target: bpy.types.Scene) -> list[tuple[Drawn, tuple[bpy.types.Object, ...]]]:
    """What the curves show, marking by marking in the scene's order, copies after what they were copied from."""
    found: dict[tuple[int, int], dict[str, bpy.types.Object]] = {}
    copies: dict[tuple[int, str], int] = {}
    for shown in sorted(_objects(target), key=lambda shown: (len(shown.name), shown.name)):
        what = "areas" if shown.data.dimensions == "2D" else "strokes"
        copy = copies.get((shown[NUMBER], what), 0)
        copies[shown[NUMBER], what] = copy + 1
        found.setdefault((shown[NUMBER], copy), {})[what] = shown
    read_by = {"strokes": curves.read_strokes, "areas": curves.read_areas}
    return [
        (
            Drawn(number, **{what: read_by[what](shown.data, _world(shown)) for what, shown in parts.items()}),
            tuple(parts.values()),
        )
        for (number, _), parts in sorted(found.items())
    ]


def renumber(drawn: list[tuple[Drawn, tuple[bpy.types.Object, ...]]]) -> None:
    """Give the curves the numbers that their markings have once the scene has followed them."""
    for number, (_, objects) in enumerate(drawn):
        for shown in objects:
            if shown[NUMBER] != number:
                shown[NUMBER] = number


def _world(shown: bpy.types.Object):
    # What the depsgraph has not evaluated yet is not in matrix_world.
    return shown.matrix_basis if shown.parent is None else shown.matrix_world


def _objects(target: bpy.types.Scene) -> list[bpy.types.Object]:
    return [shown for shown in target.objects if NUMBER in shown and shown.type == "CURVE"]
