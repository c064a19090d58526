"""2. Slots."""

import bpy

from pavemark.errors import InputError

from .. import document
from ..effects import EFFECTS, TEXTURE, WITH_SLOTS
from .layout import Sub, Switched, columns, record, say


class PAVEMARK_PT_slots(Sub, bpy.types.Panel):
    """Where slots lie, and what their lines look like"""

    bl_label = "Slots"
    bl_order = 2

    def draw(self, context):
        settings, layout = context.scene.pavemark, columns(self.layout)
        layout.prop(settings, "seed")
        layout.prop(settings, "draw")
        layout.prop(settings, "preset")
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("pavemark.randomize", icon="FILE_REFRESH")
        row.operator("pavemark.draw_again", text="", icon="LOOP_BACK")
        layout.operator("pavemark.new_slot", icon="GREASEPENCIL")


class Held(Switched):
    """Mixed into a subpanel of Slots."""

    bl_parent_id = "PAVEMARK_PT_slots"


class PAVEMARK_PT_count(Held, bpy.types.Panel):
    """Draw rows of so many slots"""

    bl_label = "Count"
    bl_order = 1
    group = "count"

    def draw(self, context):
        Held.draw(self, context)
        told = context.scene.pavemark.count
        try:
            scene = document.known(context.scene)
        except InputError:
            return  # the effects say what is wrong with it
        asked = told.slots * (2 if told.both_sides else 1)
        there = asked if scene is None else len(scene.slots)
        if told.use and there < asked:
            say(context, self.layout, f"{there} of {asked} slots are there: none is drawn where there is no room")


class PAVEMARK_PT_shape(Held, bpy.types.Panel):
    """Draw slots of this shape"""

    bl_label = "Shape"
    bl_order = 2
    group = "shape"

    def fields(self, layout, told):
        layout.prop(told, "kind")
        if told.kind == "slanted":
            layout.prop(told, "slant")


class PAVEMARK_PT_outline(Held, bpy.types.Panel):
    """Draw slots of this outline"""

    bl_label = "Outline"
    bl_order = 3
    group = "outline"


class PAVEMARK_PT_line(Held, bpy.types.Panel):
    """Hold the width of the lines"""

    bl_label = "Line Width"
    bl_order = 4
    group = "line"


class PAVEMARK_PT_colour(Held, bpy.types.Panel):
    """Hold the colour of the paint"""

    bl_label = "Colour"
    bl_order = 5
    group = "colour"

    def fields(self, layout, told):
        layout.prop(told, "family")
        reflectance = told.id_data.pavemark.blend.method == "reflectance"
        layout.prop(told, "ratio" if reflectance else "rgb", text="RGB × Ground" if reflectance else "Colour")
        layout.prop(told, "opacity")


class PAVEMARK_PT_texture(Sub, bpy.types.Panel):
    """What time and hand do to the paint"""

    bl_label = "Texture"
    bl_parent_id = "PAVEMARK_PT_slots"
    bl_order = 6
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context):
        on = sum(getattr(context.scene.pavemark, name).use for name in TEXTURE)
        self.layout.label(text=f"{on} on" if on else "off")

    def draw(self, context):
        pass


def effect(name: str, parent: str, order: int) -> type[bpy.types.Panel]:
    """The subpanel of an effect."""

    def fields(self, layout, told):
        record(layout, told, EFFECTS[name])

    told = {"bl_label": name.capitalize(), "bl_parent_id": parent, "bl_order": order, "group": name, "fields": fields}
    return type(
        f"PAVEMARK_PT_{name}", (Switched, bpy.types.Panel), told | {"__doc__": EFFECTS[name].__doc__.split("\n")[0]}
    )


CLASSES = (
    PAVEMARK_PT_slots,
    PAVEMARK_PT_count,
    PAVEMARK_PT_shape,
    PAVEMARK_PT_outline,
    PAVEMARK_PT_line,
    PAVEMARK_PT_colour,
    PAVEMARK_PT_texture,
    *(effect(name, "PAVEMARK_PT_texture", order) for order, name in enumerate(TEXTURE)),
    *(effect(name, "PAVEMARK_PT_slots", order) for order, name in enumerate(WITH_SLOTS, 7)),
)
