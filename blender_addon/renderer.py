"""The renderer that the job is handed: a scene goes in, layers come out of a multilayer EXR."""

from __future__ import annotations

import bpy
import numpy as np

from pavemark import files
from pavemark.ground import Frame
from pavemark.layers import Layers, read
from pavemark.plan import Pass, Plan
from pavemark.plate import Plate
from pavemark.scene import Scene
from pavemark.system import MEMORY

from .passes import PASSES
from .settings import Output, Window, engine
from .stage import Stage


class BlenderRenderer:
    """Cycles in this process.

    Parameters
    ----------
    threads : int
        0 takes all cores.
    target : bpy.types.Scene or None
        Blender's scene that is drawn in: an empty one. None takes that of an empty file, in place of what is open.
    """

    def __init__(self, threads: int = 0, target: bpy.types.Scene | None = None) -> None:
        self.version = f"Blender {bpy.app.version_string}"
        self.threads = threads
        files.sweep(MEMORY)
        if target is None:
            # Factory settings as a whole would also forget which extensions are there, and take their packages away.
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.target = target or bpy.context.scene

    def render(self, scene: Scene, plate: Plate, plan: Plan) -> Layers:
        """The layers of a scene: one stage and one picture for each pass.

        Raises
        ------
        OSError
            When Blender has not written the layers.
        """
        return Layers(**{made.name: self._layer(made, scene, plan) for made in plan.passes})

    def _layer(self, made: Pass, scene: Scene, plan: Plan) -> np.ndarray:
        frame, drawing = scene.plate.frame, PASSES[made.name]
        layer = np.full((frame.height, frame.width, len(drawing.channels)), drawing.blank, np.float32)
        stage = Stage(self.target)
        try:
            stage.camera(frame)
            window = drawing.put(stage, scene, plan, made)
            if window is not None:
                # Every decal may lie over every other.
                engine(made, transparent=len(scene.markings) + 1, threads=self.threads).apply(self.target)
                rendered = self._rendered(frame, window, drawing.channels)
                layer[window.top : window.bottom, window.left : window.right] = rendered
        finally:
            stage.clear()
        return layer

    def _rendered(self, frame: Frame, window: Window, channels: str) -> np.ndarray:
        path = files.aside(MEMORY / "pavemark-layers.exr")
        try:
            Output(frame, window, str(path)).apply(self.target)
            bpy.ops.render.render(write_still=True, scene=self.target.name)
            return read(path, channels)
        finally:
            path.unlink(missing_ok=True)
