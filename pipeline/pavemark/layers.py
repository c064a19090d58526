"""What leaves Blender, and who renders it."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import attrs
import numpy as np
import OpenImageIO as oiio

from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Scene


@attrs.frozen(eq=False)
class Layers:
    """The rendered layers of a scene; None where its plan has no such pass.

    Attributes
    ----------
    decals : ndarray (H, W, 4) float32, or None
        Premultiplied R, G, B and alpha, linear light: all markings over transparency. The colours are reflectance
        ratios to the ground (1 = as the ground) when the scene's blend method is "reflectance", and absolute
        linear-light RGB, 0 to 1, otherwise.
    relief : ndarray (H, W, 1) float32, or None
        Light of the sun on raised paint and the ground about it, 1 on level ground.
    shadows : ndarray (H, W, 1) float32, or None
        Share of the source that the ground sees, 0 to 1.
    wet : ndarray (H, W, 4) float32, or None
        Premultiplied R, G, B that wet ground mirrors, linear light, and how wet it is, 0 to 1.
    """

    decals: np.ndarray | None = None
    relief: np.ndarray | None = None
    shadows: np.ndarray | None = None
    wet: np.ndarray | None = None


def read(path: Path, channels: str = "RGBA") -> np.ndarray:
    """What Blender rendered into a multilayer EXR: channels (H, W, C) float32, linear light, premultiplied.

    Raises
    ------
    OSError
        When there is no such file, or it is not an EXR.
    """
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    try:
        names = source.spec().channelnames
        pixels = source.read_image(oiio.FLOAT)
    finally:
        source.close()
    # The view layer's name stands before the pass's.
    picked = [next(i for i, name in enumerate(names) if name.endswith(f"Combined.{channel}")) for channel in channels]
    return np.ascontiguousarray(pixels[..., picked])


class Renderer(Protocol):
    """Draws scenes. Blender does it in `blender_addon`; tests hand in others."""

    version: str
    """Program and version, for the manifest."""

    def render(self, scene: Scene, plate: Plate, plan: Plan) -> Layers:
        """The layers that the plan calls for."""
        ...
