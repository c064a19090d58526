"""3. Effects."""

import bpy

from pavemark.errors import InputError
from pavemark.scene import Blend

from .. import cost, document
from ..effects import OTHERS
from .layout import Sub, columns, record, say
from .slots import effect


class PAVEMARK_PT_effects(Sub, bpy.types.Panel):
    """What happens to the whole image; what is off is in no node tree and costs nothing"""

    bl_label = "Effects"
    bl_order = 3

    def draw(self, context):
        layout = self.layout
        try:
            scene = document.known(context.scene)
        except InputError as error:
            say(context, layout, str(error), "ERROR", alert=True)
            return
        for line in cost.lines(scene, context.scene.pavemark.seconds, context.scene.pavemark.off):
            say(context, layout, line)


class PAVEMARK_PT_blend(Sub, bpy.types.Panel):
    """How the paint enters the image"""

    bl_label = "Blend"
    bl_parent_id = "PAVEMARK_PT_effects"
    bl_order = 50
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        record(columns(self.layout), context.scene.pavemark.blend, Blend)


CLASSES = (
    PAVEMARK_PT_effects,
    *(effect(name, "PAVEMARK_PT_effects", order) for order, name in enumerate(OTHERS)),
    PAVEMARK_PT_blend,
)
