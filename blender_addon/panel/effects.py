"""3. Effects."""

import bpy

from pavemark.errors import InputError
from pavemark.light import Caster, Lamp, Sun, Tube
from pavemark.scene import Blend

from .. import cost, document
from ..effects import OTHERS, suns
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


class Lit(Sub):
    """Mixed into a subpanel of what an effect's light comes from or falls on: there only where the scene has it."""

    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        try:
            scene = document.known(context.scene)
        except InputError:
            return False
        return scene is not None and cls.there(scene)


class PAVEMARK_PT_sun(Lit, bpy.types.Panel):
    """Where the sun stands, for all effects that have one"""

    bl_label = "Sun"
    bl_parent_id = "PAVEMARK_PT_effects"
    bl_order = 40

    @staticmethod
    def there(scene):
        return bool(suns(scene))

    def draw(self, context):
        record(columns(self.layout), context.scene.pavemark.sun, Sun)


class PAVEMARK_PT_lamp(Lit, bpy.types.Panel):
    """The lamp that casts the shadows"""

    bl_label = "Lamp"
    bl_parent_id = "PAVEMARK_PT_shadows"
    bl_order = 1

    @staticmethod
    def there(scene):
        return scene.shadows is not None and scene.shadows.lamp is not None

    def draw(self, context):
        record(columns(self.layout), context.scene.pavemark.lamp, Lamp)


class PAVEMARK_PT_casters(Lit, bpy.types.Panel):
    """What stands outside the frame and casts the shadows"""

    bl_label = "Casters"
    bl_parent_id = "PAVEMARK_PT_shadows"
    bl_order = 2

    @staticmethod
    def there(scene):
        return scene.shadows is not None and bool(scene.shadows.casters)

    def draw(self, context):
        layout = columns(self.layout)
        for number, caster in enumerate(context.scene.pavemark.casters, 1):
            layout.label(text=f"{number}. {caster.kind.capitalize()}")
            record(layout, caster, Caster)


class PAVEMARK_PT_tubes(Lit, bpy.types.Panel):
    """The lamps that the floor mirrors, all alike"""

    bl_label = "Tubes"
    bl_parent_id = "PAVEMARK_PT_glare"
    bl_order = 1

    @staticmethod
    def there(scene):
        return scene.glare is not None and bool(scene.glare.tubes)

    def draw(self, context):
        layout, told = columns(self.layout), context.scene.pavemark.tubes
        layout.prop(told, "height")
        record(layout, told, Tube)


CLASSES = (
    PAVEMARK_PT_effects,
    *(effect(name, "PAVEMARK_PT_effects", order) for order, name in enumerate(OTHERS)),
    PAVEMARK_PT_sun,
    PAVEMARK_PT_lamp,
    PAVEMARK_PT_casters,
    PAVEMARK_PT_tubes,
    PAVEMARK_PT_blend,
)
