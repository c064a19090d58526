"""The renderer that the job is handed: a scene goes in, layers come out of a multilayer EXR."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np

from pavemark import files
from pavemark.ground import Frame
from pavemark.layers import Layers, read
from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Scene

from .settings import Output, Window, engine
from .stage import Stage

_MEMORY = Path("/dev/shm") if Path("/dev/shm").is_dir() else Path(tempfile.gettempdir())
"""Where layers pass from Blender to us: a folder in memory where there is one."""


class BlenderRenderer:
    """Cycles in this process.

    Parameters
    ----------
    threads : int
        0 takes all cores.
    """

    def __init__(self, threads: int = 0) -> None:
        self.version = f"Blender {bpy.app.version_string}"
        self.threads = threads
        files.sweep(_MEMORY)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.target = bpy.context.scene

    def render(self, scene: Scene, plate: Plate, plan: Plan) -> Layers:
        """The decals of a scene over transparency.

        Raises
        ------
        OSError
            When Blender has not written the layers.
        """
        frame = scene.plate.frame
        decals = np.zeros((frame.height, frame.width, 4), np.float32)
        stage = Stage(self.target)
        try:
            stage.camera(frame)
            window = stage.markings(scene, plan)
            if window is not None:
                # Every decal may lie over every other.
                engine(plan, transparent=len(scene.markings) + 1, threads=self.threads).apply(self.target)
                decals[window.top : window.bottom, window.left : window.right] = self._rendered(frame, window).decals
        finally:
            stage.clear()
        return Layers(decals)

    def _rendered(self, frame: Frame, window: Window) -> Layers:
        path = files.aside(_MEMORY / "pavemark-layers.exr")
        try:
            Output(frame, window, str(path)).apply(self.target)
            bpy.ops.render.render(write_still=True, scene=self.target.name)
            return read(path)
        finally:
            path.unlink(missing_ok=True)
