"""What leaves Blender, and who renders it."""

from __future__ import annotations

from typing import Protocol

import attrs
import numpy as np

from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Scene


@attrs.frozen(eq=False)
class Layers:
    """The rendered layers of a scene.

    Attributes
    ----------
    decals : ndarray (H, W, 4) float32
        Premultiplied R, G, B and alpha, linear light: all markings over transparency. The colours are reflectance
        ratios to the ground (1 = as the ground) when the scene's blend method is "reflectance", and absolute
        linear-light RGB, 0 to 1, otherwise.
    """

    decals: np.ndarray


class Renderer(Protocol):
    """Draws scenes. Blender does it in `blender_addon`; tests hand in others."""

    version: str
    """Program and version, for the manifest."""

    def render(self, scene: Scene, plate: Plate, plan: Plan) -> Layers:
        """The layers that the plan calls for."""
        ...
