"""The finished image of a scene, made in the open file as a job makes it."""

from __future__ import annotations

import bpy
import numpy as np

from pavemark.compose.image import compose
from pavemark.plan import plan
from pavemark.plate import Plate
from pavemark.scene import Scene

from .renderer import BlenderRenderer

IMAGE = "Pavemark image"


def taken(scene: Scene, plate: Plate) -> np.ndarray:
    """The image (H, W, 3) uint8, display sRGB, of a scene on its plate, by a Blender scene that lives as long as this.

    Raises
    ------
    OSError
        When Blender has not written the layers.
    """
    todo = plan(scene)
    if not todo.passes:
        return compose(scene, todo, plate, None)
    target = bpy.data.scenes.new("Pavemark render")
    try:
        return compose(scene, todo, plate, BlenderRenderer(target=target).render(scene, plate, todo))
    finally:
        bpy.data.scenes.remove(target)


def shown(pixels: np.ndarray) -> bpy.types.Image:
    """An image of Blender's that holds these pixels, for the Image Editor."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(IMAGE)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    image = image or bpy.data.images.new(IMAGE, width, height)
    values = np.ones((height, width, 4), np.float32)
    values[..., :3] = pixels[::-1] / np.float32(255)
    image.pixels.foreach_set(values.ravel())
    image.update()
    # A file that is saved keeps the picture, whether or not an editor shows it.
    image.use_fake_user = True
    image.pack()
    return image
