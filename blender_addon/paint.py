"""Procedural paint: one short formula a kind of ageing, listed in the scene or not built at all.

Every formula works in metres on the ground, so that paint looks the same at any frame size. A picture is taken with
one sample at the pixel's centre; detail finer than the pixel's footprint is therefore left out (octaves) or averaged
(softened edges), never met by chance.

An effect is two functions: its numbers, from what the scene says and the pixel's size in metres, and its formula, which
links nodes from inputs of the same names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import bpy

from pavemark.scene import Chips, Cracks, Dirt, Grain, Paint, Pattern, Wear

from . import versions
from .groups import factor
from .nodes import Value, clamp, components, node, output, ramp, smooth, where
from .patterns import PATTERNS
from .sheets import Sheet

Inputs = Mapping[str, Value]
Numbers = dict[str, float]

_OCTAVE_DEVIATION = 0.111
"""Standard deviation of one octave of Blender's noise (its mean is 0.5), measured over 360,000 pixels."""

_REACH = 2.54
"""Deviations at which the quintic step ends that is nearest to the normal distribution: at most 0.013 off."""


def even_noise(size: float, seed: float, roughness: float, pixel: float) -> Numbers:
    """Numbers of a fractal noise that is spread evenly over 0 … 1: `noise < share` holds on that share of the ground.

    Octaves end at two pixels. Noise that is finer as a whole fades to its mean, which is what a pixel sees of it.
    """
    finest = 2 * pixel
    octaves = min(6, max(0, math.floor(math.log2(size / finest))))
    weights = [roughness**k for k in range(octaves + 1)]
    deviation = _OCTAVE_DEVIATION * math.sqrt(sum(w * w for w in weights)) / sum(weights)
    reach = _REACH * deviation / min(1.0, size / finest)
    return {
        "Scale": 1 / size,
        "W": seed,
        "Octaves": float(octaves),
        "Roughness": roughness,
        "Low": 0.5 - reach,
        "High": 0.5 + reach,
    }


def noise(given: Inputs) -> Value:
    """The noise of `even_noise` at "Position", 0 to 1."""
    made = node(
        given["Position"].tree,
        "ShaderNodeTexNoise",
        {
            "Vector": given["Position"],
            "W": given["W"],
            "Scale": given["Scale"],
            "Detail": given["Octaves"],
            "Roughness": given["Roughness"],
        },
        noise_dimensions="4D",
    )
    return smooth(output(made), given["Low"], given["High"])


def cells(size: float, seed: float, grain: float, reach: float) -> Numbers:
    """Numbers of ragged cells: noise of `grain` metres moves their borders by up to about `reach` metres."""
    # A place of its own for every seed, at most 100 m away: cells of a centimetre are then still placed to a thousandth
    # of theirs in float32.
    return {
        "Scale": 1 / size,
        "Noise scale": 1 / grain,
        "W": seed,
        "Reach": 4 * reach,
        "Away": 0.1 * seed - 2 * reach,
    }


def _cells(given: Inputs, feature: str) -> bpy.types.Node:
    """Voronoi cells; their distances come in units of the cell's size."""
    tree = given["Position"].tree
    rough = node(
        tree,
        "ShaderNodeTexNoise",
        {"Vector": given["Position"], "W": given["W"], "Scale": given["Noise scale"], "Detail": 1.0},
        noise_dimensions="4D",
    )
    inputs = {0: output(rough, "Color"), 1: given["Reach"], 2: given["Away"]}
    moved = output(node(tree, "ShaderNodeVectorMath", inputs, operation="MULTIPLY_ADD"))
    at = output(node(tree, "ShaderNodeVectorMath", {0: given["Position"], 1: moved}, operation="ADD"))
    # In 4D nine times as many cells would have to be looked at.
    return node(
        tree, "ShaderNodeTexVoronoi", {"Vector": at, "Scale": given["Scale"]}, voronoi_dimensions="2D", feature=feature
    )


def grain_numbers(effect: Grain, pixel: float) -> Numbers:
    """Fine roughness."""
    return even_noise(effect.size, effect.seed, 0.7, pixel) | {"Contrast": 2 * effect.contrast}


def grain(given: Inputs) -> Value:
    """Factor on the colour, around 1."""
    return (noise(given) - 0.5) * given["Contrast"] + 1.0


def dirt_numbers(effect: Dirt, pixel: float) -> Numbers:
    """Stains."""
    return even_noise(effect.size, effect.seed, 0.6, pixel) | {"Strength": effect.strength}


def dirt(given: Inputs) -> Value:
    """Factor on the colour, at most 1: stains, darker under the tyres."""
    stain = noise(given)
    return 1.0 - clamp(stain * stain + given["Tyres"] * 0.5) * given["Strength"]


def wear_numbers(effect: Wear, pixel: float) -> Numbers:
    """Paint rubbed off."""
    return even_noise(effect.size, effect.seed, 0.7, pixel) | {
        "Fading": -1 / effect.edge,
        "Amount": effect.amount,
        "Edge amount": effect.edge_amount,
        "Tyre amount": effect.tyre_amount,
    }


def wear(given: Inputs) -> Value:
    """Share of the paint that is left: it goes first at the edges and under the tyres, in ragged patches."""
    from_edge = (given["Edge"] * given["Fading"]).math("EXPONENT")
    gone = given["Tyres"] * given["Tyre amount"] + from_edge * given["Edge amount"] + given["Amount"]
    # Thinning paint fades over a tenth of the noise's range before it is gone.
    return ramp(noise(given), gone - 0.1, gone + 0.1)


def chips_numbers(effect: Chips, pixel: float) -> Numbers:
    """Flakes: ragged cells, their borders softened over a pixel."""
    border = pixel / effect.size
    return cells(effect.size, effect.seed, effect.size, effect.size * 0.4) | {
        "Share": effect.share,
        "Inner": 0.5 - border / 2,
        "Outer": 0.5 + border / 2,
    }


def chips(given: Inputs) -> Value:
    """Share of the paint that is left: some cells have flaked off to the ground."""
    cell = _cells(given, "F1")
    chance = output(node(cell.id_data, "ShaderNodeSeparateColor", {"Color": output(cell, "Color")}), "Red")
    flake = 1.0 - ramp(output(cell, "Distance"), given["Inner"], given["Outer"])
    return 1.0 - (chance < given["Share"]) * flake


def cracks_numbers(effect: Cracks, pixel: float) -> Numbers:
    """Cracks: borders of ragged cells, as wide as they cover the pixel."""
    return cells(effect.size, effect.seed, effect.size * 0.3, effect.size * 0.15) | {
        "Size in pixels": effect.size / pixel,
        "Reach in pixels": 0.5 * (effect.width / pixel + 1),
        "Most": min(1.0, effect.width / pixel),
    }


def cracks(given: Inputs) -> Value:
    """Share of the paint that is left beside a network of cracks."""
    away = output(_cells(given, "DISTANCE_TO_EDGE"), "Distance") * given["Size in pixels"]
    return 1.0 - clamp(given["Reach in pixels"] - away, 0.0, given["Most"])


def pattern_numbers(effect: Pattern, pixel: float) -> Numbers:
    """A regular pattern turned by its angle and shifted by its seed."""
    return {
        "Cosine": math.cos(effect.angle) / effect.size,
        "Sine": math.sin(effect.angle) / effect.size,
        "Shift": effect.seed,
        "Blur": pixel / effect.size,
        "Strength": effect.strength,
    }


def pattern(kind: str) -> Callable[[Inputs], Value]:
    """Share of the paint that a pattern leaves."""

    def formula(given: Inputs) -> Value:
        x, y = components(given["Position"])
        u = x * given["Cosine"] + y * given["Sine"] + given["Shift"] * 0.618
        v = y * given["Cosine"] - x * given["Sine"] + given["Shift"] * 0.414
        return 1.0 - PATTERNS[kind](u, v, given["Blur"]) * given["Strength"]

    return formula


_GEOMETRY = {"wear": ("Edge", "Tyres"), "dirt": ("Tyres",)}
"""What an effect has to know of the sheet beside the position."""

_NUMBERS = {
    "grain": grain_numbers,
    "dirt": dirt_numbers,
    "wear": wear_numbers,
    "chips": chips_numbers,
    "cracks": cracks_numbers,
    "pattern": pattern_numbers,
}
_FORMULAS = {"grain": grain, "dirt": dirt, "wear": wear, "chips": chips, "cracks": cracks}
_COLOURING = frozenset({"grain", "dirt"})
"""Effects that scale the paint's colour; the others take paint away."""


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
    surface = _surface(tree, sheet)
    alpha = surface["Coverage"] * paint.opacity
    strength: Value | float = 1.0
    for effect in effects:
        share = _factor(tree, effect, getattr(paint, effect), surface, 1 / sheet.frame.scale)
        if effect in _COLOURING:
            strength = share * strength
        else:
            alpha = alpha * share
    emission = node(tree, "ShaderNodeEmission", {"Color": (*colour, 1.0), "Strength": strength})
    clear = node(tree, "ShaderNodeBsdfTransparent")
    mixed = node(tree, "ShaderNodeMixShader", {0: alpha, 1: output(clear), 2: output(emission)})
    node(tree, "ShaderNodeOutputMaterial", {"Surface": output(mixed)})
    return made


def _factor(tree: bpy.types.ShaderNodeTree, name: str, effect: object, surface: Inputs, pixel: float) -> Value:
    known = {label: surface[label] for label in ("Position", *_GEOMETRY.get(name, ()))}
    title, formula = (f"{effect.kind} pattern", pattern(effect.kind)) if name == "pattern" else (name, _FORMULAS[name])
    return factor(tree, title, known | _NUMBERS[name](effect, pixel), formula)


def _surface(tree: bpy.types.ShaderNodeTree, sheet: Sheet) -> Inputs:
    """Position on the ground (metres), and the sheet's channels there: coverage, edge (metres), tyres."""
    position = where(tree)
    inputs = {"Vector": sheet.mapped(position)}
    texture = node(tree, "ShaderNodeTexImage", inputs, interpolation="Closest", extension="CLIP")
    texture.image = sheet.image
    channels = node(tree, "ShaderNodeSeparateColor", {"Color": output(texture, "Color")})
    return {
        "Position": position,
        "Coverage": output(channels, "Red"),
        "Edge": output(channels, "Green"),
        "Tyres": output(channels, "Blue"),
    }
