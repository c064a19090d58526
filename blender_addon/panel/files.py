"""6. Import / Export."""

import bpy

from .layout import Sub


class PAVEMARK_PT_files(Sub, bpy.types.Panel):
    """Scenes of jobs in and out, and jobs of these settings"""

    bl_label = "Import / Export"
    bl_order = 6

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("pavemark.open_scene", icon="FILE_FOLDER")
        row.operator("pavemark.save_scene", icon="FILE_TICK")
        layout.operator("pavemark.export_job", icon="EXPORT")


CLASSES = (PAVEMARK_PT_files,)
