"""What shines: sun and lamps, so bright that white ground is 1."""

from __future__ import annotations

import math

import bpy
from mathutils import Matrix, Vector

from pavemark.light import Lamp, Sun


def sun(name: str, shone: Sun) -> tuple[bpy.types.Light, Matrix]:
    """A sun under which level, white, dull ground has radiance 1, and how it is turned."""
    made = bpy.data.lights.new(name, "SUN")
    made.angle = shone.angle
    # White ground sends back 1/π of what reaches it.
    made.energy = math.pi / math.sin(shone.elevation)
    level = math.cos(shone.elevation)
    towards = Vector((level * math.cos(shone.azimuth), level * math.sin(shone.azimuth), math.sin(shone.elevation)))
    return made, towards.to_track_quat("Z", "Y").to_matrix().to_4x4()


def lamp(name: str, shone: Lamp) -> tuple[bpy.types.Light, Matrix]:
    """A lamp under which white, dull ground straight below has radiance 1, and where it is."""
    made = bpy.data.lights.new(name, "POINT")
    made.shadow_soft_size = shone.radius
    made.energy = 4 * math.pi**2 * shone.place[2] ** 2
    return made, Matrix.Translation(shone.place)
