"""The scene of Pavemark that a file holds: its JSON together with the curves of its markings.

The curves tell where paint lies, the JSON all the rest. Whoever asks gets the scene as the curves are at that moment.
"""

from __future__ import annotations

import functools
import json

import attrs
import bpy

from pavemark.errors import InputError
from pavemark.geometry.follow import follow
from pavemark.plate import Plate
from pavemark.records import structure, to_json
from pavemark.scene import Blend, Scene

from . import backdrop, lines, view
from .effects import LABELLED, PAINT, WHOLE, suns
from .properties.fields import shown
from .properties.hearing import deaf

WHERE = "scene"


def known(target: bpy.types.Scene) -> Scene | None:
    """The scene as it was last followed: for the panel, which may look but not touch.

    Raises
    ------
    InputError
        When the file holds no scene of this version.
    """
    text = target.pavemark.document
    return _parsed(text) if text else None


@functools.lru_cache(maxsize=8)
def _parsed(text: str) -> Scene:
    try:
        return structure(Scene, json.loads(text), WHERE)
    except ValueError as error:
        raise InputError(WHERE, f"not JSON: {error}") from None


def current(target: bpy.types.Scene) -> Scene | None:
    """The scene as its curves are now; None when there is none.

    Raises
    ------
    InputError
        When curves were moved to where no slot can be.
    """
    before = known(target)
    if before is None:
        return None
    drawn = lines.read(target)
    try:
        now = follow(before, (one for one, _ in drawn))
    except ValueError as error:
        raise InputError(WHERE, f"{error}; move it back, or undo") from None
    if now is not before:
        lines.renumber(drawn)
        target.pavemark.document = to_json(now)
    return now


def put(target: bpy.types.Scene, scene: Scene) -> None:
    """Make a scene the file's: its curves, its settings in the panel, its view."""
    target.pavemark.document = to_json(scene)
    lines.lay(target, scene)
    reflect(target, scene)
    look(target)


def keep(target: bpy.types.Scene, scene: Scene) -> None:
    """As `put`, for a scene whose geometry is what the curves show."""
    target.pavemark.document = to_json(scene)
    look(target)


def look(target: bpy.types.Scene) -> None:
    """Show the scene, or the ground alone, as it is now.

    Raises
    ------
    InputError
        When the image cannot be read any more. What is shown stays.
    """
    told = target.pavemark.background
    if not told.name:
        return
    ground = backdrop.plate(target)
    with deaf():
        told.clean = ground is not None
        ground = ground or backdrop.picture(target)
        told.size = ground.frame.width, ground.frame.height
    scene = current(target)
    view.show(target, ground, scene if scene is not None and scene.plate.frame == ground.frame else None)


def clean(target: bpy.types.Scene) -> Plate:
    """The plate of the chosen image.

    Raises
    ------
    InputError
        When its markings have not been removed yet.
    """
    plate = backdrop.plate(target)
    if plate is None:
        raise InputError(target.pavemark.background.file, "its markings are still on it: Remove Markings comes first")
    return plate


def reflect(target: bpy.types.Scene, scene: Scene) -> None:
    """Show a scene's effects in the panel: switched on where the scene has them."""
    settings = target.pavemark
    paint = next((marking.paint for marking in scene.markings if marking.kind in LABELLED), None)
    with deaf():
        settings.index = min(scene.index, 2**31 - 1)
        for name in WHOLE:
            fill(getattr(settings, name), getattr(scene, name))
        _lights(settings, scene)
        _fields(settings.blend, scene.blend or Blend())
        if paint is None:
            return
        for name in PAINT:
            fill(getattr(settings, name), getattr(paint, name))
        settings.colour.rgb = [level / 255 for level in paint.rgb]
        settings.colour.ratio = paint.ratio
        settings.colour.opacity = paint.opacity
        widths = [stroke.width for marking in scene.markings if marking.kind == "slot" for stroke in marking.strokes]
        if widths:
            settings.line.width = widths[0]


def fill(group: bpy.types.PropertyGroup, effect: object | None) -> None:
    """Show an effect, or that there is none."""
    group.use = effect is not None
    if effect is not None:
        _fields(group, effect)


def _lights(settings: bpy.types.PropertyGroup, scene: Scene) -> None:
    """Show what an image's light comes from, and what it falls on."""
    for sun in suns(scene).values():
        _fields(settings.sun, sun)
    if scene.shadows is not None and scene.shadows.lamp is not None:
        _fields(settings.lamp, scene.shadows.lamp)
    casters, groups = scene.shadows.casters if scene.shadows else (), settings.casters
    # No more of them than need be: one whose slider is being moved must not go under its hand.
    while len(groups) > len(casters):
        groups.remove(len(groups) - 1)
    while len(groups) < len(casters):
        groups.add()
    for group, caster in zip(groups, casters, strict=True):
        _fields(group, caster)
    if scene.glare is not None and scene.glare.tubes:
        _fields(settings.tubes, scene.glare.tubes[0])
        settings.tubes.height = scene.glare.tubes[0].place[2]


def _fields(group: bpy.types.PropertyGroup, record: object) -> None:
    for name in shown(type(record)):
        if name in group.bl_rna.properties:
            setattr(group, name, getattr(record, name))


def painted(scene: Scene, change) -> Scene:
    """The scene with the paint of every labelled marking changed by a function of it and the marking's number."""
    return attrs.evolve(
        scene,
        markings=tuple(
            attrs.evolve(marking, paint=change(marking.paint, number)) if marking.kind in LABELLED else marking
            for number, marking in enumerate(scene.markings)
        ),
    )
