"""Procedural paint: one short node group a kind of ageing, listed in the scene or not built at all.

Every function works in metres on the ground, so that paint looks the same at any frame size. A picture is taken with
one sample at the pixel's centre; detail finer than the pixel's footprint is therefore left out (octaves) or averaged
(softened edges), never met by chance.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy

from pavemark.scene import Chips, Cracks, Dirt, Grain, Paint, Pattern, Wear

from . import versions
from .nodes import Value, clamp, components, node, output, ramp
from .patterns import PATTERNS
from .sheets import Sheet

_OCTAVE_DEVIATION = 0.111
"""Standard deviation of one octave of Blender's noise (its mean is 0.5), measured over 360,000 pixels."""


class Surface:
    """Where a pixel lies on the ground and what the marking's sheet says there.

    Attributes
    ----------
    position : Value
        World position, metres.
    coverage, edge, tyres : Value
        The sheet's channels: share of the pixel painted, metres to the outline, exposure to tyres 0 … 1.
    footprint : float
        Metres a pixel.
    """

    def __init__(self, tree: bpy.types.ShaderNodeTree, sheet: Sheet) -> None:
        self.tree = tree
        self.footprint = 1 / sheet.frame.scale
        self.position = output(node(tree, "ShaderNodeNewGeometry"), "Position")
        width, height = sheet.frame.size
        mapped = node(
            tree,
            "ShaderNodeMapping",
            {"Vector": self.position, "Location": (0.5, 0.5, 0.0), "Scale": (1 / width, 1 / height, 0.0)},
        )
        texture = node(
            tree, "ShaderNodeTexImage", {"Vector": output(mapped)}, interpolation="Closest", extension="CLIP"
        )
        texture.image = sheet.image
        channels = node(tree, "ShaderNodeSeparateColor", {"Color": output(texture, "Color")})
        self.coverage, self.edge, self.tyres = (output(channels, name) for name in ("Red", "Green", "Blue"))

    def noise(self, size: float, seed: float, roughness: float = 0.5) -> Value:
        """Fractal noise spread evenly over 0 … 1: `noise < share` holds on that share of the ground.

        Octaves end at two pixels. Noise that is finer as a whole fades to its mean, which is what a pixel sees of it.
        """
        finest = 2 * self.footprint
        octaves = min(6, max(0, math.floor(math.log2(size / finest))))
        weights = [roughness**k for k in range(octaves + 1)]
        deviation = _OCTAVE_DEVIATION * math.sqrt(sum(w * w for w in weights)) / sum(weights)
        made = node(
            self.tree,
            "ShaderNodeTexNoise",
            {"Vector": self.position, "W": seed, "Scale": 1 / size, "Detail": float(octaves), "Roughness": roughness},
            noise_dimensions="4D",
        )
        # A logistic curve of slope 1.702 is the normal distribution to within 0.01.
        steepness = 1.702 / deviation * min(1.0, size / finest)
        return 1.0 / (((0.5 - output(made)) * steepness).math("EXPONENT") + 1.0)

    def shaken(self, size: float, seed: float, reach: float) -> Value:
        """The position, moved by up to about `reach` metres by noise of `size`: ragged, not geometric."""
        made = node(
            self.tree,
            "ShaderNodeTexNoise",
            {"Vector": self.position, "W": seed, "Scale": 1 / size, "Detail": 1.0},
            noise_dimensions="4D",
        )
        gain = (4 * reach, 4 * reach, 0.0)
        start = (-2 * reach, -2 * reach, 0.0)
        moved = node(
            self.tree,
            "ShaderNodeVectorMath",
            {0: output(made, "Color"), 1: gain, 2: start},
            operation="MULTIPLY_ADD",
        )
        return output(node(self.tree, "ShaderNodeVectorMath", {0: self.position, 1: output(moved)}, operation="ADD"))

    def cells(self, at: Value, size: float, seed: float, feature: str) -> bpy.types.Node:
        """Voronoi cells of `size` metres; distances come in units of `size`."""
        return node(
            self.tree,
            "ShaderNodeTexVoronoi",
            {"Vector": at, "W": seed, "Scale": 1 / size},
            voronoi_dimensions="4D",
            feature=feature,
        )


def grain(surface: Surface, effect: Grain) -> Value:
    """Factor on the colour, around 1."""
    return 1.0 + (surface.noise(effect.size, effect.seed, 0.7) - 0.5) * (2 * effect.contrast)


def dirt(surface: Surface, effect: Dirt) -> Value:
    """Factor on the colour, at most 1: stains, darker under the tyres."""
    stain = surface.noise(effect.size, effect.seed, 0.6)
    return 1.0 - clamp(stain * stain + surface.tyres * 0.5) * effect.strength


def wear(surface: Surface, effect: Wear) -> Value:
    """Share of the paint that is left: it goes first at the edges and under the tyres, in ragged patches."""
    from_edge = (surface.edge * (-1 / effect.edge)).math("EXPONENT")
    gone = surface.tyres * effect.tyre_amount + from_edge * effect.edge_amount + effect.amount
    patch = surface.noise(effect.size, effect.seed, 0.7)
    # Thinning paint fades over a tenth of the noise's range before it is gone.
    return ramp(patch, gone - 0.1, gone + 0.1)


def chips(surface: Surface, effect: Chips) -> Value:
    """Share of the paint that is left: some cells have flaked off to the ground."""
    at = surface.shaken(effect.size, effect.seed + 1, effect.size * 0.4)
    cell = surface.cells(at, effect.size, effect.seed, "F1")
    chance = output(node(surface.tree, "ShaderNodeSeparateColor", {"Color": output(cell, "Color")}), "Red")
    border = surface.footprint / effect.size
    flake = 1.0 - ramp(output(cell, "Distance"), 0.5 - border / 2, 0.5 + border / 2)
    return 1.0 - (chance < effect.share) * flake


def cracks(surface: Surface, effect: Cracks) -> Value:
    """Share of the paint that is left beside a network of cracks, each as wide as it covers the pixel."""
    at = surface.shaken(effect.size * 0.3, effect.seed + 1, effect.size * 0.15)
    cell = surface.cells(at, effect.size, effect.seed, "DISTANCE_TO_EDGE")
    away = output(cell, "Distance") * effect.size
    pixel = surface.footprint
    covered = clamp((0.5 * (effect.width + pixel) - away) / pixel, 0.0, min(1.0, effect.width / pixel))
    return 1.0 - covered


def pattern(surface: Surface, effect: Pattern) -> Value:
    """Share of the paint that is left by a regular pattern turned by its angle and shifted by its seed."""
    x, y = components(surface.position)
    cos, sin = math.cos(effect.angle) / effect.size, math.sin(effect.angle) / effect.size
    u = x * cos + y * sin + effect.seed * 0.618
    v = y * cos - x * sin + effect.seed * 0.414
    return 1.0 - PATTERNS[effect.kind](u, v, surface.footprint / effect.size) * effect.strength


COLOUR: dict[str, Callable[[Surface, object], Value]] = {"grain": grain, "dirt": dirt}
"""Effects that scale the paint's colour."""

OPACITY: dict[str, Callable[[Surface, object], Value]] = {
    "wear": wear,
    "chips": chips,
    "cracks": cracks,
    "pattern": pattern,
}
"""Effects that take paint away."""


def material(
    name: str, paint: Paint, colour: tuple[float, float, float], effects: tuple[str, ...], sheet: Sheet
) -> bpy.types.Material:
    """The material of one marking: it emits its colour where there is paint and is transparent elsewhere.

    Parameters
    ----------
    colour : tuple of float
        What fresh paint emits, linear light (a reflectance ratio or an absolute colour, as the plan says).
    effects : tuple of str
        The paint's effects that the plan calls for.
    """
    made, tree = versions.material(name)
    surface = Surface(tree, sheet)
    alpha = surface.coverage * paint.opacity
    scale: Value | float = 1.0
    for effect in effects:
        if effect in OPACITY:
            alpha = alpha * OPACITY[effect](surface, getattr(paint, effect))
        else:
            scale = COLOUR[effect](surface, getattr(paint, effect)) * scale
    emission = node(tree, "ShaderNodeEmission", {"Color": (*colour, 1.0), "Strength": scale})
    clear = node(tree, "ShaderNodeBsdfTransparent")
    mixed = node(tree, "ShaderNodeMixShader", {0: alpha, 1: output(clear), 2: output(emission)})
    node(tree, "ShaderNodeOutputMaterial", {"Surface": output(mixed)})
    return made
