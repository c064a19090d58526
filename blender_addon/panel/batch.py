"""5. Batch."""

import bpy

from .. import running
from .layout import Sub, columns, outcome, progress


class PAVEMARK_PT_batch(Sub, bpy.types.Panel):
    """A dataset with these settings, made beside Blender"""

    bl_label = "Batch"
    bl_order = 5

    def draw(self, context):
        settings, layout = context.scene.pavemark, columns(self.layout)
        layout.prop(settings, "batch_count")
        layout.prop(settings, "batch_folder")
        layout.column(align=True).prop(settings, "formats")
        layout.prop(settings, "workers")
        child = running.children.get(running.BATCH)
        if child:
            progress(layout, child, running.BATCH)
            return
        row = layout.row()
        row.scale_y = 1.3
        row.operator("pavemark.batch", icon="PLAY")
        outcome(context, layout, running.outcomes.get(running.BATCH))


CLASSES = (PAVEMARK_PT_batch,)
