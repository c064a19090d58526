"""Operators that make the finished image, and save it with its labels."""

from pathlib import Path

import attrs
import bpy
import numpy as np

from pavemark.errors import InputError
from pavemark.job.by_hand import save
from pavemark.job.clock import Timings
from pavemark.job.config import FORMATS
from pavemark.job.exactness import exactness
from pavemark.job.folder import RECORD, Folder, recorded
from pavemark.job.worker import versions
from pavemark.plate import Plate
from pavemark.scene import Scene

from .. import backdrop, cost, document, overlay, shot
from .drawing import clean
from .reporting import Reporting, needs

SLOTS = "Draw slots first: Randomize, New Slot, or Open Scene"


def ready(target: bpy.types.Scene) -> tuple[Scene, Plate]:
    """The scene as its curves are now, on the plate of the chosen image, with the rays that the largest error takes.

    Raises
    ------
    InputError
        When the one or the other is not there.
    """
    plate, scene = document.clean(target), document.current(target)
    if scene is None:
        raise InputError("scene", SLOTS)
    now = attrs.evolve(scene, plate=plate.ref)
    if target.pavemark.max_error > 0:
        job = attrs.evolve(backdrop.job(target), max_error=round(target.pavemark.max_error, 4))
        now = exactness(job).met(now, plate)
    else:
        now = attrs.evolve(now, rays=1)
    if now != scene:
        document.keep(target, now)
    return now, plate


def taken(target: bpy.types.Scene) -> tuple[Scene, Plate, np.ndarray]:
    """The image of the scene, shown with its labels."""
    timings = Timings()
    scene, plate = ready(target)
    with timings.stage("image"):
        pixels = shot.taken(scene, plate)
    target.pavemark.seconds = timings.seconds["image"]
    target.pavemark.off = cost.edges_off(scene, plate)
    image = shot.shown(pixels)
    overlay.remember(target)
    _into_editors(image)
    return scene, plate, pixels


def _into_editors(image: bpy.types.Image) -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image


def renderable(cls: type, context: bpy.types.Context) -> bool:
    """Whether there is something to render; the poll of what does."""
    settings = context.scene.pavemark
    return clean(cls, context) and needs(cls, settings.document, SLOTS)


class PAVEMARK_OT_render(Reporting, bpy.types.Operator):
    """Make the image as a job makes it, to the bit, and show it in the Image Editor with its labels over it"""

    bl_idname = "pavemark.render"
    bl_label = "Render Image"

    @classmethod
    def poll(cls, context):
        return renderable(cls, context)

    def act(self, context):
        taken(context.scene)
        return f"rendered in {context.scene.pavemark.seconds:.2f} s"


class PAVEMARK_OT_open_editor(bpy.types.Operator):
    """Make room for the rendered image: split the 3D view and show an Image Editor beside it"""

    bl_idname = "pavemark.open_editor"
    bl_label = "Image Editor Beside"

    @classmethod
    def poll(cls, context):
        return needs(cls, context.area is not None and context.area.type == "VIEW_3D", "It is for a 3D view")

    def execute(self, context):
        before = set(context.screen.areas)
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
        (made,) = set(context.screen.areas) - before
        made.type = "IMAGE_EDITOR"
        if shot.IMAGE in bpy.data.images:
            made.spaces.active.image = bpy.data.images[shot.IMAGE]
        return {"FINISHED"}


class PAVEMARK_OT_save_image(Reporting, bpy.types.Operator):
    """Render, and put image, masks, labels and scene into the dataset, in place of those of the same number"""

    bl_idname = "pavemark.save_image"
    bl_label = "Save Image + Labels"

    @classmethod
    def poll(cls, context):
        folder = context.scene.pavemark.folder
        return renderable(cls, context) and needs(cls, folder, "Choose the folder of the dataset first")

    def act(self, context):
        target = context.scene
        settings = target.pavemark
        out = Path(bpy.path.abspath(settings.folder)).absolute()
        if (out / RECORD).exists():
            folder = Folder.of(out, recorded(out))
        else:
            folder = Folder(out, tuple(name for name in FORMATS if name in settings.formats), 6)
        scene, plate, pixels = taken(target)
        made_by = versions() | {"renderer": f"Blender {bpy.app.version_string}"}
        source = backdrop.chosen(target).image.name
        path = save(scene, pixels, plate, source, folder, settings.seed, made_by)
        return f"saved {path} with masks, labels and scene"


CLASSES = (PAVEMARK_OT_render, PAVEMARK_OT_open_editor, PAVEMARK_OT_save_image)
