"""The tab itself."""

import bpy

from pavemark import __version__

from .layout import say


class PAVEMARK_PT_root(bpy.types.Panel):
    """Pavement markings on real around-view-monitor images"""

    bl_label = "Pavemark"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Pavemark"

    def draw_header_preset(self, context):
        row = self.layout.row(align=True)
        row.label(text=__version__)

    def draw(self, context):
        layout, trouble = self.layout, context.scene.pavemark.trouble
        row = layout.row(align=True)
        menu = _menu()
        row.menu(menu.__name__, text=menu.bl_label)
        row.operator("pavemark.add_preset", text="", icon="ADD")
        row.operator("pavemark.add_preset", text="", icon="REMOVE").remove_active = True
        if trouble:
            say(context, layout, trouble, "ERROR", alert=True)


def _menu() -> type[bpy.types.Menu]:
    return bpy.types.PAVEMARK_MT_presets


CLASSES = (PAVEMARK_PT_root,)
