"""Operators of the background: which image, its markings removed, the view of it."""

import tempfile
from pathlib import Path

import bpy

from pavemark.background import cache
from pavemark.job.config import toml

from .. import backdrop, child, document, edits, running
from .reporting import Reporting, needs

CHOOSE = "Choose an AVM image or a folder of them first"


class PAVEMARK_OT_step_background(Reporting, bpy.types.Operator):
    """Paint on the next or the previous image of the folder. The markings stay where they are"""

    bl_idname = "pavemark.step_background"
    bl_label = "Step Through Images"
    bl_options = {"REGISTER", "UNDO"}

    step: bpy.props.IntProperty(name="Step", description="Images to go on by; -1 goes back by one", default=1)

    @classmethod
    def poll(cls, context):
        return needs(cls, context.scene.pavemark.background.name, CHOOSE)

    def act(self, context):
        target = context.scene
        names = list(backdrop.listed(target))
        here = target.pavemark.background.name
        place = names.index(here) + self.step if here in names else 0
        edits.step_to(target, names[place % len(names)])
        return f"{target.pavemark.background.file}: image {place % len(names) + 1} of {len(names)}"


class PAVEMARK_OT_remove_markings(Reporting, bpy.types.Operator):
    """Take the markings off the image, in a process of its own. Slots are painted on what comes of it"""

    bl_idname = "pavemark.remove_markings"
    bl_label = "Remove Markings"

    every: bpy.props.BoolProperty(
        name="All Images", description="Of all images of the folder, not of this one alone", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context):
        return needs(cls, context.scene.pavemark.background.name, CHOOSE) and needs(
            cls, running.PLATES not in running.children, "Markings are being removed already"
        )

    def act(self, context):
        target, name = context.scene, context.scene.name
        tables = backdrop.tables(target)
        if "plates" in tables:
            document.look(target)
            return "the plates of this folder are made already"
        scratch = tempfile.TemporaryDirectory(prefix="pavemark-")
        images = tables.pop("images") if self.every else str(backdrop.chosen(target).image)
        tables.pop("images", None)
        command = [*child.plates_command(), images, "--out", str(Path(scratch.name) / "plates"), "--workers", "1"]
        for line in toml(tables).splitlines():
            command += ["--set", line]

        def then() -> str:
            scratch.cleanup()
            if name in bpy.data.scenes:
                edits.looked_at(bpy.data.scenes[name])
                if not bpy.data.scenes[name].pavemark.background.clean:
                    return f"The plate cannot be kept: {cache.folder()} cannot be written"
            return "Markings removed"

        running.start(running.PLATES, [*command, "--leash", "--every", "0"], then)


class PAVEMARK_OT_stop(bpy.types.Operator):
    """Stop what runs beside Blender. What is finished stays, and the same again goes on from there"""

    bl_idname = "pavemark.stop"
    bl_label = "Stop"

    what: bpy.props.EnumProperty(
        name="What",
        description="Which of them",
        items=[(running.BATCH, "Batch", ""), (running.PLATES, "Remove Markings", "")],
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context):
        return needs(cls, running.children, "Nothing runs beside Blender")

    def execute(self, context):
        if self.what in running.children:
            running.children[self.what].stop()
        return {"FINISHED"}


class PAVEMARK_OT_look_down(bpy.types.Operator):
    """Look straight down on the image, in its own colours"""

    bl_idname = "pavemark.look_down"
    bl_label = "Look Straight Down"

    @classmethod
    def poll(cls, context):
        here = context.area is not None and context.area.type == "VIEW_3D"
        return needs(cls, here, "It is for a 3D view") and needs(cls, context.scene.pavemark.background.name, CHOOSE)

    def execute(self, context):
        space, told = context.space_data, context.scene.pavemark.background
        view = space.region_3d
        view.view_perspective = "ORTHO"
        view.view_rotation = (1.0, 0.0, 0.0, 0.0)
        view.view_location = (0.0, 0.0, 0.0)
        # Of a lens of 50 mm, with a margin of a tenth.
        view.view_distance = 1.1 * 50 / 36 * max(told.size) * told.metres_per_pixel
        space.lens = 50.0
        space.shading.type = "MATERIAL"
        space.shading.use_scene_world = False
        space.overlay.show_floor = space.overlay.show_cursor = False
        space.overlay.show_axis_x = space.overlay.show_axis_y = False
        return {"FINISHED"}


CLASSES = (
    PAVEMARK_OT_step_background,
    PAVEMARK_OT_remove_markings,
    PAVEMARK_OT_stop,
    PAVEMARK_OT_look_down,
)
