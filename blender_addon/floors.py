"""Materials of the ground where light is simulated: dull and white to be shaded, or wet to mirror what is above."""

from __future__ import annotations

import math

import bpy

from pavemark.light import Lamp, Wet

from . import versions
from .nodes import Value, clamp, node, output, ramp, vector, where
from .paint import even_noise, noise
from .sheets import Sheet

WATER = 0.02
"""Share of light that water mirrors straight up (index 1.33)."""

DULL = 0.3
"""Share of what water mirrors that a film on rough ground does."""

ROUGHNESS = 0.35
"""How much less each octave of the patches counts than the one before: water evens out what is small."""

SHORE = 0.2
"""Share of the ground over which wet patches dry out and puddles run shallow."""

SKYLINE = 1.5
"""How often what stands around rises and falls, to a radian of the horizon."""

HAZE = 0.03
"""Sine of the elevation over which what stands around gives way to the sky."""


def white(name: str, under: Lamp | None) -> bpy.types.Material:
    """Dull ground that shows which share of the light reaches it; that of a lamp, which fades from its foot, evened."""
    made, tree = versions.material(name)
    colour: Value | tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    if under is not None:
        position = where(tree)
        away = output(node(tree, "ShaderNodeVectorMath", {0: position, 1: under.place}, operation="DISTANCE"), "Value")
        # Irradiance falls with the square of the distance, and with the cosine of the angle from the vertical.
        colour = (away / under.place[2]).math("POWER", 3.0)
    dull = node(tree, "ShaderNodeBsdfDiffuse", {"Color": colour})
    node(tree, "ShaderNodeOutputMaterial", {"Surface": output(dull)})
    return made


def wet(name: str, ground: Wet, rays: Sheet) -> bpy.types.Material:
    """What wet patches and puddles mirror, as opaque as they are wet.

    Parameters
    ----------
    rays : Sheet
        `pavemark.geometry.mirror.mirrored`.
    """
    made, tree = versions.material(name)
    position = where(tree)
    field = noise({"Position": position, **even_noise(ground.size, ground.seed, ROUGHNESS, 1 / rays.frame.scale)})
    damp, pool = (_below(field, share) for share in (ground.share, ground.share * ground.pools))
    picture = node(
        tree, "ShaderNodeTexImage", {"Vector": rays.mapped(position)}, interpolation="Closest", extension="EXTEND"
    )
    picture.image = rays.image
    ray = output(picture, "Color")
    east, north, up = (output(node(tree, "ShaderNodeSeparateXYZ", {"Vector": ray}), axis) for axis in "XYZ")
    share = clamp(1.0 - up).math("POWER", 5.0) * (1 - WATER) + WATER
    shown = node(
        tree,
        "ShaderNodeMix",
        {"Factor": _sky(tree, east, north, up, ground), 6: (*ground.around, 1.0), 7: (*ground.sky, 1.0)},
        data_type="RGBA",
    )
    film = pool * (1 - DULL) + DULL
    inputs = {"Color": Value(tree, shown.outputs[2]), "Strength": share * film}
    shining = node(tree, "ShaderNodeEmission", inputs)
    clear = node(tree, "ShaderNodeBsdfTransparent")
    mixed = node(tree, "ShaderNodeMixShader", {0: damp, 1: output(clear), 2: output(shining)})
    node(tree, "ShaderNodeOutputMaterial", {"Surface": output(mixed)})
    return made


def _below(field: Value, share: float) -> Value:
    """1 on that share of the ground, and 0 off its shore."""
    shore = min(SHORE, share, 1 - share)
    if not shore:
        return (field < 2.0) * share
    return 1.0 - ramp(field, share - shore / 2, share + shore / 2)


def _sky(tree: bpy.types.ShaderNodeTree, east: Value, north: Value, up: Value, ground: Wet) -> Value:
    """1 where a ray ends in the sky, 0 below a ragged skyline."""
    level = (east * east + north * north).math("SQRT").math("MAXIMUM", 1e-3)
    round_about = vector(east / level * SKYLINE, north / level * SKYLINE, tree)
    ragged = node(
        tree, "ShaderNodeTexNoise", {"Vector": round_about, "W": ground.seed, "Detail": 1.0}, noise_dimensions="4D"
    )
    height = output(ragged) * (2 * math.sin(ground.skyline))
    return ramp(up, height - HAZE, height + HAZE)
