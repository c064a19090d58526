"""The renderer that the job is handed: a scene goes in, layers come out of a multilayer EXR."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio

from pavemark.layers import Layers
from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Scene

from .settings import Cycles, Output
from .stage import Stage

_MEMORY = Path("/dev/shm")


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
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.target = bpy.context.scene

    def render(self, scene: Scene, plate: Plate, plan: Plan) -> Layers:
        """The decals of a scene over transparency.

        Raises
        ------
        RuntimeError
            When Blender does not write the layers.
        """
        stage = Stage(self.target)
        try:
            stage.camera(scene.plate.frame)
            stage.markings(scene, plan)
            # Every decal may lie over every other.
            Cycles(plan.samples, transparent=len(scene.markings) + 1, threads=self.threads).apply(self.target)
            with tempfile.TemporaryDirectory(dir=_MEMORY if _MEMORY.is_dir() else None) as folder:
                path = Path(folder) / "layers.exr"
                Output(scene.plate.frame, str(path)).apply(self.target)
                bpy.ops.render.render(write_still=True, scene=self.target.name)
                return Layers(_read(path, "Combined"))
        finally:
            stage.clear()


def _read(path: Path, layer: str) -> np.ndarray:
    """One RGBA layer (H, W, 4) float32 of a multilayer EXR, by channel name."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise RuntimeError(f"Blender wrote no layers: {oiio.geterror()}")
    try:
        names = source.spec().channelnames
        pixels = source.read_image(oiio.FLOAT)
    finally:
        source.close()
    picked = [next(i for i, name in enumerate(names) if name.endswith(f"{layer}.{channel}")) for channel in "RGBA"]
    return np.ascontiguousarray(pixels[..., picked])
