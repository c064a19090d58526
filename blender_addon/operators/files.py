"""Operators that open and save scenes of jobs, and write a job of what the panel says."""

from pathlib import Path

import bpy

from pavemark import files
from pavemark.errors import InputError
from pavemark.job.config import FOLDERS, merge, toml
from pavemark.job.folder import RECORD, recorded
from pavemark.records import from_json, to_json
from pavemark.scene import Scene

from .. import backdrop, document
from ..drawing import light_tables
from .background import CHOOSE
from .batch import job_tables
from .render import SLOTS, ready
from .reporting import Reporting, needs


class Filed(Reporting):
    """Mixed into an operator on a file that is asked for."""

    filepath: bpy.props.StringProperty(name="File", description="Path of the file", subtype="FILE_PATH")

    def invoke(self, context, event):
        if not self.filepath:
            self.filepath = self.first(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def first(self, context) -> str:
        """What the file browser begins with."""
        return ""

    def path(self) -> Path:
        """The chosen file.

        Raises
        ------
        InputError
            When none is.
        """
        if not self.filepath:
            raise InputError(self.bl_label, "no file is chosen")
        return Path(bpy.path.abspath(self.filepath)).absolute()

    def goal(self) -> Path:
        """The chosen file, to be written: its folder is there, for one that is not is a slip of the pen.

        Raises
        ------
        InputError
            When none is chosen, or its folder is not there.
        """
        path = self.path()
        if not path.parent.is_dir():
            raise InputError(path.parent, "is no folder that is there: make it first, or choose another one")
        return path


class PAVEMARK_OT_open_scene(Filed, bpy.types.Operator):
    """Open a scene of a job (OUT/scenes/….json) to look at it and to change it; its background is found by the job"""

    bl_idname = "pavemark.open_scene"
    bl_label = "Open Scene"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    filepath: bpy.props.StringProperty(name="File", description="A scene, JSON", subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def act(self, context):
        target, path = context.scene, self.path()
        scene = from_json(Scene, path)
        settings = target.pavemark
        before = {name: getattr(settings.background, name) for name in _SHOWN}
        out = path.parent.parent
        try:
            if (out / RECORD).is_file():
                told = recorded(out)
                backdrop.show(target, told)
                settings.seed, settings.preset = min(told.seed, 2**31 - 1), told.preset
                settings.formats = set(told.formats)
            _choose(target, scene)
        except (InputError, ValueError, OSError):
            # Nothing of what was open is lost to a scene that cannot be shown.
            for name, value in before.items():
                setattr(settings.background, name, value)
            raise
        document.put(target, scene)
        settings.folder = str(out) if path.parent.name == "scenes" else settings.folder
        if not settings.background.clean:
            return f"{path.name}: opened; Remove Markings makes the plate that it is painted on"
        plate = backdrop.plate(target)
        if plate.sha256 != scene.plate.sha256:
            self.report({"WARNING"}, f"{scene.plate.name}: its plate has changed since: the image will be another")
        return f"{path.name}: {len(scene.slots)} slots on {scene.plate.name}"


_SHOWN = ("images", "masks", "marking", "ground", "metres_per_pixel", "inpainter", "segmenter", "name", "file", "clean")


def _choose(target: bpy.types.Scene, scene: Scene) -> None:
    told = target.pavemark.background
    if not told.images:
        raise InputError(scene.plate.name, "its image is not known: choose the image or its folder first")
    found = backdrop.listed(target)
    if scene.plate.name not in found:
        raise InputError(
            told.images, f"holds no image {scene.plate.name}: choose the folder of the scene's image first"
        )
    told.name, told.file = scene.plate.name, found[scene.plate.name].image.name
    if backdrop.picture(target).frame.size != scene.plate.frame.size:
        size = "{:.4g} m × {:.4g} m".format(*scene.plate.frame.size)
        raise InputError(told.file, f"is not {size}, as the scene says: its pixel size or the image is another")


class PAVEMARK_OT_save_scene(Filed, bpy.types.Operator):
    """Save the scene as JSON, as a job keeps it; pavemark explain and this panel read it"""

    bl_idname = "pavemark.save_scene"
    bl_label = "Save Scene"
    bl_options = {"REGISTER", "PRESET"}

    filepath: bpy.props.StringProperty(name="File", description="Where the scene goes, JSON", subtype="FILE_PATH")
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return needs(cls, context.scene.pavemark.document, SLOTS)

    def first(self, context):
        return f"{context.scene.pavemark.index:06d}.json"

    def act(self, context):
        target, path = context.scene, self.goal()
        scene = ready(target)[0] if target.pavemark.background.clean else document.current(target)
        files.write(path, to_json(scene))
        return f"saved {path}"


class PAVEMARK_OT_export_job(Filed, bpy.types.Operator):
    """Write a job file of these settings, for pavemark render, render.py and blender -b -P render.py"""

    bl_idname = "pavemark.export_job"
    bl_label = "Export Job"
    bl_options = {"REGISTER", "PRESET"}

    filepath: bpy.props.StringProperty(name="File", description="Where the job file goes, TOML", subtype="FILE_PATH")
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    filter_glob: bpy.props.StringProperty(default="*.toml", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return needs(cls, context.scene.pavemark.background.images, CHOOSE)

    def first(self, context):
        return "job.toml"

    def act(self, context):
        path = self.goal()
        backdrop.job(context.scene)
        # What is not listed keeps the preset's ranges, unseen: whoever asks for light will want to narrow them.
        told = merge(job_tables(context.scene), light_tables(context.scene))
        # Folders of a job file are relative to it, so that both can be moved together.
        told |= {name: files.relative(told[name], path.parent) for name in FOLDERS if name in told}
        files.write(path, toml(told))
        return f"saved {path}"


CLASSES = (PAVEMARK_OT_open_scene, PAVEMARK_OT_save_scene, PAVEMARK_OT_export_job)
