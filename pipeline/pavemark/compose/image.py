"""The finished image: the plan's steps, one after the other."""

from __future__ import annotations

import numpy as np

from pavemark.colour import quantise
from pavemark.compose import blend, brightness, light, noise, optics
from pavemark.layers import Layers
from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Scene


def compose(scene: Scene, plan: Plan, plate: Plate, layers: Layers | None) -> np.ndarray:
    """Run the plan's steps and nothing else.

    Parameters
    ----------
    scene : Scene
    plan : Plan
        `pavemark.plan.plan(scene)`.
    plate : Plate
        The scene's.
    layers : Layers or None
        What the renderer gave; None when the plan renders nothing.

    Returns
    -------
    ndarray (H, W, 3) uint8
        Display sRGB. Rounded once, after the last step; pixels that no step touches are the plate's.
    """
    image = plate.image.astype(np.float32)
    for step in plan.steps:
        if step == "optics":
            layers = optics.apply(layers, scene.optics)
        elif step == "blend":
            image = blend.apply(plate, layers, scene.blend)
        elif step == "relief":
            image = light.relief(image, plate, layers, scene.relief)
        elif step == "shadows":
            image = light.shadows(image, plate, layers, scene.shadows)
        elif step == "wet":
            image = light.wet(image, plate, layers, scene.wet)
        elif step == "glare":
            image = light.glare(image, plate, scene.glare)
        elif step == "brightness":
            image = brightness.apply(image, scene.brightness)
        else:
            image = noise.apply(image, scene.noise)
    return quantise(image)
