"""4. Render."""

import bpy

from .layout import Sub, columns


class PAVEMARK_PT_render(Sub, bpy.types.Panel):
    """The finished image, with its labels"""

    bl_label = "Render"
    bl_order = 4

    def draw(self, context):
        settings, layout = context.scene.pavemark, columns(self.layout)
        layout.prop(settings, "index")
        layout.prop(settings, "max_error", text="Error, Levels")
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("pavemark.render", icon="RENDER_STILL")
        row.operator("pavemark.open_editor", text="", icon="IMAGE")
        layout.prop(settings, "overlay")
        layout.separator()
        layout.prop(settings, "folder")
        layout.operator("pavemark.save_image", icon="FILE_TICK")


CLASSES = (PAVEMARK_PT_render,)
