"""The batch: the headless job in a process of its own, so that Blender stays usable."""

from pathlib import Path

import bpy

from pavemark import files
from pavemark.job.config import FORMATS, toml

from .. import backdrop, child, drawing, running
from .background import CHOOSE
from .reporting import Reporting, needs


def job_tables(target: bpy.types.Scene) -> dict:
    """The job that the panel describes, as a job file holds it."""
    settings = target.pavemark
    told = backdrop.tables(target) | {
        "count": settings.batch_count,
        "seed": settings.seed,
        "preset": settings.preset,
        "formats": [name for name in FORMATS if name in settings.formats],
    }
    if settings.max_error > 0:
        told["max_error"] = round(settings.max_error, 4)
    return told | drawing.job_tables(target)


class PAVEMARK_OT_batch(Reporting, bpy.types.Operator):
    """Make a dataset with these settings in a process of its own; the same again goes on where it was stopped"""

    bl_idname = "pavemark.batch"
    bl_label = "Start Batch"

    @classmethod
    def poll(cls, context):
        settings = context.scene.pavemark
        return (
            needs(cls, settings.background.images, CHOOSE)
            and needs(cls, settings.batch_folder, "Choose the batch's folder first")
            and needs(cls, settings.formats, "Choose a format of the labels first")
            and needs(cls, running.BATCH not in running.children, "A batch runs already")
        )

    def act(self, context):
        settings = context.scene.pavemark
        backdrop.job(context.scene)
        out = Path(bpy.path.abspath(settings.batch_folder)).absolute()
        path = Path(bpy.app.tempdir) / "pavemark-job.toml"
        files.write(path, toml(job_tables(context.scene)))
        options = [str(path), "--out", str(out), "--workers", str(settings.workers), "--leash", "--every", "0.5"]
        running.start(running.BATCH, [*child.render_command(), *options])


CLASSES = (PAVEMARK_OT_batch,)
