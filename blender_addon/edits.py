"""What a changed setting does to the scene. Each takes Blender's scene, and raises `InputError` when it cannot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import bpy
import numpy as np

from pavemark.errors import InputError
from pavemark.light import Caster, Lamp, Sun, Tube
from pavemark.records import structure
from pavemark.scene import Blend, Marking, Paint, Scene

from . import backdrop, document
from .drawing import drawn, rates, values
from .effects import EFFECTS, LABELLED, PAINT, WHOLE, suns
from .properties import fields
from .properties.hearing import heard


def choose_background(target: bpy.types.Scene) -> None:
    """Show the first of the chosen images, or the same one with its new settings."""
    told = target.pavemark.background
    if told.images:
        found = backdrop.listed(target)
        step_to(target, told.name if told.name in found else next(iter(found)))


def step_to(target: bpy.types.Scene, name: str) -> None:
    """Paint on another of the images; the markings stay where they are."""
    told = target.pavemark.background
    told.name, told.file = name, backdrop.listed(target)[name].image.name
    document.look(target)


def draw(target: bpy.types.Scene) -> None:
    """Draw a scene anew from the panel's seed."""
    document.put(target, drawn(target, document.clean(target)))


def redraw(target: bpy.types.Scene) -> None:
    """Draw where the slots lie anew; their paint and the effects stay."""
    before = document.current(target)
    if before is None:
        return
    now = drawn(target, document.clean(target))
    if not now.slots:
        raise InputError("Slots", "there is no room for such slots here: take another seed, or another image")
    paints = iter([marking.paint for marking in before.markings if marking.kind in LABELLED])
    markings = tuple(
        attrs.evolve(marking, paint=next(paints, marking.paint)) if marking.kind in LABELLED else marking
        for marking in now.markings
    )
    kept = {name: getattr(before, name) for name in WHOLE if name != "tyres"}
    if before.tyres is None:
        kept["tyres"] = None
    document.put(target, attrs.evolve(now, markings=markings, blend=before.blend or now.blend, **kept))


def recolour(target: bpy.types.Scene) -> None:
    """Draw the colour of the paint anew."""
    before = document.current(target)
    if before is None:
        return
    fresh = _paints(drawn(target, document.clean(target)))
    if fresh:

        def coloured(paint: Paint, number: int) -> Paint:
            new = fresh[min(number, len(fresh) - 1)]
            return attrs.evolve(paint, rgb=new.rgb, ratio=new.ratio)

        _show(target, document.painted(before, coloured))


def set_paint(target: bpy.types.Scene, field: str) -> None:
    """Set a field of the paint of every marking."""
    before, value = document.current(target), getattr(target.pavemark.colour, field)
    if before is None:
        return
    if field == "rgb":
        value = tuple(round(255 * share, 3) for share in value)
    elif field == "ratio":
        value = tuple(value)
    document.keep(target, document.painted(before, lambda paint, number: attrs.evolve(paint, **{field: value})))


def set_width(target: bpy.types.Scene) -> None:
    """Set the width of the lines of slots."""
    line, before = target.pavemark.line, document.current(target)
    if before is None or not line.use:
        return
    width = round(line.width, 6)

    def wide(marking: Marking) -> Marking:
        return attrs.evolve(marking, strokes=tuple(attrs.evolve(each, width=width) for each in marking.strokes))

    markings = tuple(wide(marking) if marking.kind == "slot" else marking for marking in before.markings)
    document.put(target, attrs.evolve(before, markings=markings))


def set_blend(target: bpy.types.Scene, field: str) -> None:
    """Set how the paint enters the plate."""
    before = document.current(target)
    if before is not None and before.blend is not None:
        value = getattr(target.pavemark.blend, field)
        document.keep(target, attrs.evolve(before, blend=attrs.evolve(before.blend, **{field: value})))


def switch_effect(target: bpy.types.Scene, name: str) -> None:
    """Switch an effect on, with what chance draws for it, or off."""
    before, group = document.current(target), getattr(target.pavemark, name)
    if before is None:
        return
    if not group.use:
        _show(target, _with(before, name, [None]))
        return
    found = _drawn_effect(target, name, rates({name: True}))
    found = found or [structure(EFFECTS[name], values(group, EFFECTS[name]), name)]
    if shining := [sun for other, sun in suns(before).items() if other != name]:
        found = [attrs.evolve(each, sun=shining[0]) if getattr(each, "sun", None) else each for each in found]
    _show(target, _with(before, name, found))


def set_effect(target: bpy.types.Scene, name: str, field: str) -> None:
    """Set a field of an effect wherever the scene has it."""
    before, group = document.current(target), getattr(target.pavemark, name)
    if before is None or not group.use:
        return
    value = fields.value(group, EFFECTS[name], field)
    try:
        now = _changed(before, name, lambda effect: attrs.evolve(effect, **{field: value}))
    except ValueError:
        # Another kind may want other numbers: it is drawn with those that suit it.
        found = _drawn_effect(target, name, rates({name: True}, kinds=[value])) if field == "kind" else []
        if not found:
            document.reflect(target, before)
            raise
        _show(target, _with(before, name, found))
        return
    document.keep(target, now)


def set_sun(target: bpy.types.Scene, field: str) -> None:
    """Set a field of the sun, for all effects that have one."""
    told = {field: fields.value(target.pavemark.sun, Sun, field)}

    def change(scene: Scene) -> Scene:
        lit = {name: attrs.evolve(sun, **told) for name, sun in suns(scene).items()}
        return attrs.evolve(scene, **{name: attrs.evolve(getattr(scene, name), sun=sun) for name, sun in lit.items()})

    _set(target, change)


def set_lamp(target: bpy.types.Scene, field: str) -> None:
    """Set a field of the lamp that casts the shadows."""
    told = {field: fields.value(target.pavemark.lamp, Lamp, field)}

    def change(scene: Scene) -> Scene:
        shadows = scene.shadows
        if shadows is None or shadows.lamp is None:
            return scene
        return attrs.evolve(scene, shadows=attrs.evolve(shadows, lamp=attrs.evolve(shadows.lamp, **told)))

    _set(target, change)


def set_casters(target: bpy.types.Scene, field: str) -> None:
    """Set a field of each caster whose slider shows another value than the caster has."""
    groups = target.pavemark.casters

    def changed(caster: Caster, group: bpy.types.PropertyGroup) -> Caster:
        there, told = getattr(caster, field), fields.value(group, Caster, field)
        same = there == told if isinstance(there, str) else np.array_equal(np.float32(there), np.float32(told))
        return caster if same else attrs.evolve(caster, **{field: told})

    def change(scene: Scene) -> Scene:
        shadows = scene.shadows
        if shadows is None or len(shadows.casters) != len(groups):
            return scene
        casters = tuple(changed(*pair) for pair in zip(shadows.casters, groups, strict=True))
        return attrs.evolve(scene, shadows=attrs.evolve(shadows, casters=casters))

    _set(target, change)


def set_tubes(target: bpy.types.Scene, field: str) -> None:
    """Set a field of all tubes that the floor mirrors, or how high they hang."""
    group = target.pavemark.tubes

    def changed(tube: Tube) -> Tube:
        if field == "height":
            return attrs.evolve(tube, place=(*tube.place[:2], group.height))
        return attrs.evolve(tube, **{field: fields.value(group, Tube, field)})

    def change(scene: Scene) -> Scene:
        glare = scene.glare
        if glare is None:
            return scene
        return attrs.evolve(scene, glare=attrs.evolve(glare, tubes=tuple(map(changed, glare.tubes))))

    _set(target, change)


def _set(target: bpy.types.Scene, change: Callable[[Scene], Scene]) -> None:
    before = document.current(target)
    if before is None:
        return
    try:
        now = change(before)
    except ValueError:
        document.reflect(target, before)
        raise
    document.keep(target, now)


def apply(target: bpy.types.Scene) -> None:
    """Give the scene all that the panel says, as after a preset has set it."""
    settings = target.pavemark
    if document.current(target) is None:
        return
    wanted = {
        name: values(getattr(settings, name), record) if getattr(settings, name).use else None
        for name, record in EFFECTS.items()
    }
    paint = {"rgb": tuple(255 * share for share in settings.colour.rgb), "ratio": tuple(settings.colour.ratio)}
    paint["opacity"] = settings.colour.opacity
    fresh = drawn(target, document.clean(target), rates({name: told is not None for name, told in wanted.items()}))
    if settings.count.use or settings.shape.use or settings.outline.use:
        redraw(target)
    scene = document.current(target)
    if settings.colour.use:
        scene = document.painted(scene, lambda before, number: attrs.evolve(before, **paint))
    for name, told in wanted.items():
        found = _effects(fresh, name) if told is not None else []
        scene = _with(scene, name, [attrs.evolve(effect, **told) for effect in found] or [None])
    document.put(target, scene)
    set_width(target)


def renumber(target: bpy.types.Scene) -> None:
    """Give the scene another number in its job."""
    before = document.current(target)
    if before is not None:
        document.keep(target, attrs.evolve(before, index=target.pavemark.index))


def blended(target: bpy.types.Scene, scene: Scene) -> Scene:
    """The scene with a blend, which one with markings needs: its own, or the panel's."""
    return scene if scene.blend else attrs.evolve(scene, blend=Blend(**values(target.pavemark.blend, Blend)))


def looked_at(target: bpy.types.Scene) -> None:
    """Show the scene; what is in the way is told in the panel."""
    heard(document.look)(target.pavemark, bpy.context)


def _show(target: bpy.types.Scene, scene: Scene) -> None:
    document.keep(target, scene)
    document.reflect(target, scene)


def _paints(scene: Scene) -> list[Paint]:
    return [marking.paint for marking in scene.markings if marking.kind in LABELLED]


def _drawn_effect(target: bpy.types.Scene, name: str, told: dict[str, Any]) -> list[object]:
    """What chance draws for an effect: once, or for a paint's once for each marking."""
    return _effects(drawn(target, document.clean(target), told), name)


def _effects(scene: Scene, name: str) -> list[object]:
    """An effect of the scene: once, or a paint's for each marking."""
    found = [getattr(paint, name) for paint in _paints(scene)] if name in PAINT else [getattr(scene, name)]
    return [effect for effect in found if effect is not None]


def _with(scene: Scene, name: str, effects: list[object]) -> Scene:
    if name in WHOLE:
        return attrs.evolve(scene, **{name: effects[0]})
    numbers = [number for number, marking in enumerate(scene.markings) if marking.kind in LABELLED]
    nth = {number: effects[min(k, len(effects) - 1)] for k, number in enumerate(numbers)}
    return document.painted(scene, lambda paint, number: attrs.evolve(paint, **{name: nth[number]}))


def _changed(scene: Scene, name: str, change) -> Scene:
    if name in WHOLE:
        there = getattr(scene, name)
        return scene if there is None else attrs.evolve(scene, **{name: change(there)})

    def repainted(paint: Paint, number: int) -> Paint:
        there = getattr(paint, name)
        return paint if there is None else attrs.evolve(paint, **{name: change(there)})

    return document.painted(scene, repainted)


def redraw_editors() -> None:
    """Have every editor draw itself anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()
