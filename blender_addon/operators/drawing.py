"""Operators that draw slots: by chance, and by three clicks."""

import bpy
from bpy_extras import view3d_utils

from pavemark.scene import Paint, Scene

from .. import document, edits
from ..effects import LABELLED
from ..new_slot import with_slot
from .background import CHOOSE
from .reporting import Reporting, needs

CLEAN = "Remove the markings of the image first"


def clean(cls: type, context: bpy.types.Context) -> bool:
    """Whether there is clean ground to draw on; the poll of what does. If not, what is to be done first is told."""
    settings = context.scene.pavemark
    shown = needs(cls, settings.background.name, settings.trouble or CHOOSE)
    return shown and needs(cls, settings.background.clean, CLEAN)


class PAVEMARK_OT_randomize(Reporting, bpy.types.Operator):
    """Draw new slots with a new seed, as a job draws them; what is switched on is held or drawn as it says"""

    bl_idname = "pavemark.randomize"
    bl_label = "Randomize"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return clean(cls, context)

    def act(self, context):
        settings = context.scene.pavemark
        settings.seed = (settings.seed + 1) % 2**31
        edits.draw(context.scene)


class PAVEMARK_OT_draw_again(Reporting, bpy.types.Operator):
    """Draw the slots of this seed again, in place of what hands have made of them"""

    bl_idname = "pavemark.draw_again"
    bl_label = "Draw Again"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return clean(cls, context)

    def act(self, context):
        edits.draw(context.scene)


class PAVEMARK_OT_new_slot(Reporting, bpy.types.Operator):
    """Draw a slot with three clicks: the two ends of its entrance line, then how deep it is"""

    bl_idname = "pavemark.new_slot"
    bl_label = "New Slot"
    bl_options = {"REGISTER", "UNDO", "BLOCKING"}

    first: bpy.props.FloatVectorProperty(
        name="First", description="One end of the entrance line", size=2, unit="LENGTH"
    )
    second: bpy.props.FloatVectorProperty(
        name="Second", description="The other end of the entrance line", size=2, unit="LENGTH", default=(2.5, 0.0)
    )
    depth: bpy.props.FloatVectorProperty(
        name="Depth", description="A point of the back line", size=2, unit="LENGTH", default=(1.25, 5.0)
    )

    CLICKS = ("one end of the entrance line", "the other end of the entrance line", "how deep the slot is")

    @classmethod
    def poll(cls, context):
        return clean(cls, context)

    def invoke(self, context, event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        self._points = []
        self._ask(context)
        context.window.cursor_modal_set("CROSSHAIR")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self._leave(context)
            return {"CANCELLED"}
        if event.type in {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE"}:
            return {"PASS_THROUGH"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        self._points.append(_on_ground(context, (event.mouse_region_x, event.mouse_region_y)))
        if len(self._points) < 3:
            self._ask(context)
            return {"RUNNING_MODAL"}
        self._leave(context)
        self.first, self.second, self.depth = self._points
        return self.execute(context)

    def _ask(self, context):
        context.workspace.status_text_set(f"Click {self.CLICKS[len(self._points)]}    Esc: cancel")

    def _leave(self, context):
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()

    def act(self, context):
        target = context.scene
        settings, plate = target.pavemark, document.clean(target)
        scene = document.current(target) or Scene(settings.index, plate.ref)
        paints = [marking.paint for marking in scene.markings if marking.kind in LABELLED]
        paint = paints[-1] if paints else _paint(settings)
        points = tuple((float(x), float(y)) for x, y in (self.first, self.second, self.depth))
        scene = edits.blended(target, scene)
        document.put(target, with_slot(scene, points, settings.outline.kind, settings.line.width, paint))


def _paint(settings) -> Paint:
    colour = settings.colour
    return Paint(tuple(255 * share for share in colour.rgb), tuple(colour.ratio), colour.opacity)


def _on_ground(context, mouse):
    """The point of the ground, in metres, under a pixel of the region."""
    region, view = context.region, context.space_data.region_3d
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    ray = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    place = origin - ray * (origin.z / ray.z)
    return place.x, place.y


CLASSES = (PAVEMARK_OT_randomize, PAVEMARK_OT_draw_again, PAVEMARK_OT_new_slot)
