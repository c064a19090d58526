"""The groups of the panel, from the contract's records and for what is held fast when slots are drawn."""

import functools

import bpy

from pavemark.light import Caster, Lamp, Sun, Tube
from pavemark.randomize import layout
from pavemark.records import OneOf, Within, bounds
from pavemark.scene import Blend, Slot, Stroke

from .. import edits
from ..effects import EFFECTS
from .fields import description, group
from .hearing import heard


def _use(text: str, act) -> bpy.props.BoolProperty:
    return bpy.props.BoolProperty(name="Switched on", description=text, default=False, update=heard(act))


def _effect(name: str) -> type[bpy.types.PropertyGroup]:
    return group(
        EFFECTS[name],
        name,
        lambda field: heard(functools.partial(edits.set_effect, name=name, field=field)),
        {"use": _use(description(EFFECTS[name], ""), functools.partial(edits.switch_effect, name=name))},
    )


EFFECT_GROUPS = {name: _effect(name) for name in EFFECTS}

BlendGroup = group(Blend, "blend", lambda field: heard(functools.partial(edits.set_blend, field=field)))


SunGroup = group(Sun, "sun", lambda field: heard(functools.partial(edits.set_sun, field=field)))
LampGroup = group(Lamp, "lamp", lambda field: heard(functools.partial(edits.set_lamp, field=field)))
CasterGroup = group(Caster, "caster", lambda field: heard(functools.partial(edits.set_casters, field=field)))
TubesGroup = group(
    Tube,
    "tubes",
    lambda field: heard(functools.partial(edits.set_tubes, field=field)),
    {
        "height": bpy.props.FloatProperty(
            name="Height",
            description="Metres from the floor up to the tubes",
            subtype="DISTANCE",
            unit="LENGTH",
            default=3.0,
            min=0.1,
            max=20.0,
            step=10,
            precision=3,
            update=heard(functools.partial(edits.set_tubes, field="height")),
        )
    },
    without="place",
)
LIGHTS = (SunGroup, LampGroup, CasterGroup, TubesGroup)
"""What light comes from, and what it falls on."""


def _words(record: type, field: str) -> list[tuple[str, str, str]]:
    words = bounds(getattr(record.__attrs_attrs__, field), OneOf).allowed
    return [(word, word.replace("-", " ").capitalize(), "") for word in words]


_MOST = round(layout.Ranges().slots[1])
_WIDTH = bounds(Stroke.__attrs_attrs__.width, Within)


class PAVEMARK_PG_count(bpy.types.PropertyGroup):
    """How many slots a row has."""

    use: _use("Draw rows of so many slots, as far as there is room for them", edits.redraw)
    slots: bpy.props.IntProperty(
        name="Slots", description="Slots of a row", default=3, min=1, max=_MOST, update=heard(edits.redraw)
    )
    both_sides: bpy.props.BoolProperty(
        name="Both Sides", description="A second row opposite the first", update=heard(edits.redraw)
    )


class PAVEMARK_PG_shape(bpy.types.PropertyGroup):
    """Which way slots lie."""

    use: _use("Draw slots of this shape", edits.redraw)
    kind: bpy.props.EnumProperty(
        name="Shape", description=description(Slot, "kind"), items=_words(Slot, "kind"), update=heard(edits.redraw)
    )
    slant: bpy.props.FloatProperty(
        name="Slant",
        description="Angle between the entrance line and the separating lines of slanted slots",
        subtype="ANGLE",
        unit="ROTATION",
        default=1.05,
        min=0.35,
        max=1.55,
        update=heard(edits.redraw),
    )


class PAVEMARK_PG_outline(bpy.types.PropertyGroup):
    """Which lines of a slot are painted."""

    use: _use("Draw slots of this outline", edits.redraw)
    kind: bpy.props.EnumProperty(
        name="Outline",
        description=description(Slot, "outline"),
        items=_words(Slot, "outline"),
        update=heard(edits.redraw),
    )


class PAVEMARK_PG_line(bpy.types.PropertyGroup):
    """How wide lines are."""

    use: _use("Hold the width of the lines", edits.set_width)
    width: bpy.props.FloatProperty(
        name="Width",
        description="Metres across a line of slots",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.12,
        min=max(_WIDTH.low, 0.02),
        max=1.0,
        soft_max=0.3,
        step=1,
        precision=3,
        update=heard(edits.set_width),
    )


class PAVEMARK_PG_colour(bpy.types.PropertyGroup):
    """What the paint looks like."""

    use: _use("Hold the colour of the paint", edits.recolour)
    family: bpy.props.EnumProperty(
        name="Family",
        description="What paint is drawn",
        items=[("white", "White", ""), ("yellow", "Yellow", "")],
        update=heard(edits.recolour),
    )
    rgb: bpy.props.FloatVectorProperty(
        name="Colour",
        description="Absolute colour of the paint, for the blends of the paper",
        subtype="COLOR_GAMMA",
        default=(0.82, 0.82, 0.8),
        min=0.0,
        max=1.0,
        update=heard(functools.partial(edits.set_paint, field="rgb")),
    )
    ratio: bpy.props.FloatVectorProperty(
        name="Ratio",
        description="How many times the light of its ground the paint sends back: red, green, blue",
        default=(2.4, 2.4, 2.3),
        min=0.01,
        max=100.0,
        soft_max=5.0,
        step=5,
        precision=2,
        update=heard(functools.partial(edits.set_paint, field="ratio")),
    )
    opacity: bpy.props.FloatProperty(
        name="Opacity",
        description="Share of the ground that the paint hides",
        subtype="FACTOR",
        default=1.0,
        min=0.0,
        max=1.0,
        update=heard(functools.partial(edits.set_paint, field="opacity")),
    )


HELD = (PAVEMARK_PG_count, PAVEMARK_PG_shape, PAVEMARK_PG_outline, PAVEMARK_PG_line, PAVEMARK_PG_colour)
