"""A marking's sheet as an image that shaders can read."""

from __future__ import annotations

import attrs
import bpy
import numpy as np

from pavemark.ground import Frame

from .nodes import Value, node, output


@attrs.frozen
class Sheet:
    """A data image that covers the frame, one texel a pixel."""

    image: bpy.types.Image
    frame: Frame

    def mapped(self, position: Value) -> Value:
        """Where in the image a position on the ground (metres) lies."""
        width, height = self.frame.size
        inputs = {"Vector": position, "Location": (0.5, 0.5, 0.0), "Scale": (1 / width, 1 / height, 0.0)}
        return output(node(position.tree, "ShaderNodeMapping", inputs))


def load(name: str, values: np.ndarray, frame: Frame) -> Sheet:
    """Hand an array (H, W, 4) float32, rows from the top, to Blender (whose rows run from the bottom)."""
    image = bpy.data.images.new(name, frame.width, frame.height, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = "CHANNEL_PACKED"
    image.pixels.foreach_set(np.ascontiguousarray(values[::-1], np.float32).ravel())
    return Sheet(image, frame)
