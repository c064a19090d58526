"""1. Background."""

import bpy

from .. import running
from .layout import Sub, columns, outcome, progress


class PAVEMARK_PT_background(Sub, bpy.types.Panel):
    """The image that is painted on"""

    bl_label = "Background"
    bl_order = 1

    def draw(self, context):
        told, layout = context.scene.pavemark.background, columns(self.layout)
        layout.prop(told, "images")
        layout.prop(told, "metres_per_pixel")
        if told.name:
            row = layout.row(align=True)
            row.operator("pavemark.step_background", text="", icon="TRIA_LEFT").step = -1
            row.label(text=told.file)
            row.operator("pavemark.step_background", text="", icon="TRIA_RIGHT").step = 1
            width, height = told.size
            across, down = (pixels * told.metres_per_pixel for pixels in (width, height))
            layout.label(text=f"{width} × {height} px  ·  {across:.2f} m × {down:.2f} m")
            layout.operator("pavemark.look_down", icon="VIEW_ORTHO")
        child = running.children.get(running.PLATES)
        if child:
            progress(layout, child, running.PLATES)
            return
        done = "CHECKMARK" if told.clean else "BRUSH_DATA"
        buttons = layout.column(align=True)
        buttons.operator("pavemark.remove_markings", icon=done).every = False
        buttons.operator("pavemark.remove_markings", text="Of All Images").every = True
        outcome(context, layout, running.outcomes.get(running.PLATES))


class PAVEMARK_PT_masks(Sub, bpy.types.Panel):
    """Where markings are, and what fills the ground below them"""

    bl_label = "Masks and Filling"
    bl_parent_id = "PAVEMARK_PT_background"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        told, layout = context.scene.pavemark.background, columns(self.layout)
        layout.prop(told, "masks")
        values = layout.column()
        values.active = bool(told.masks)
        values.prop(told, "marking", text="Marking Values")
        values.prop(told, "ground", text="Ground Values")
        layout.prop(told, "segmenter")
        layout.prop(told, "inpainter")


CLASSES = (PAVEMARK_PT_background, PAVEMARK_PT_masks)
