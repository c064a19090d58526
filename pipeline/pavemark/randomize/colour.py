"""Domain colour: the paint of an image, absolute and as reflectance ratio to its ground."""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.colour import LUMINANCE, to_display
from pavemark.randomize.palette import Palette, Shade
from pavemark.randomize.streams import weighted
from pavemark.records import interval, within
from pavemark.scene import RGB, Paint

_FAINTEST = 1.3
"""Luminance ratio below which fresh paint would hardly show its marking points, let alone worn paint."""

_BRIGHTEST = 5.0
"""Luminance ratio above which a measured marking is taken for glare or a car; fresh white on dark road has 5."""

_FRESH = 1.35
"""How much brighter fresh paint may be than the measured: that is worn, and here wear is drawn by itself."""

_TINT = 0.1
"""Share by which a channel of white paint may leave its luminance. Measured tints of white are largely those of a
clipped highlight or of the ground where it happened to lie, and would be wrong on other ground."""

_GREY = 0.13
"""Linear light of a grey floor, for the absolute colour of what is known by its ratio to one."""

_YELLOW = 0.75
"""Blue over red ratio below which a measured marking counts as yellow."""

_REDDEST = 0.65
"""Green over red ratio below which a measured marking is a lamp, a car or a red floor; yellow paint has over 0.7."""


@attrs.frozen
class Ranges:
    """What may be drawn.

    Attributes
    ----------
    white, yellow : float
        Weights of the families, for plates that had no markings of their own.
    spread : float
        8-bit levels added to or taken from each channel of the palette's colour (paper: 30).
    ratio : tuple of float
        Luminance of the reflectance ratio, for plates that had no markings of their own.
    ratio_spread : float
        Share by which a ratio is varied.
    """

    white: float = attrs.field(default=0.75, validator=within(0.0, 1000.0))
    yellow: float = attrs.field(default=0.25, validator=within(0.0, 1000.0))
    spread: float = attrs.field(default=30.0, validator=within(0.0, 255.0))
    ratio: tuple[float, float] = attrs.field(default=(1.4, 3.3), validator=interval(0.05, 20.0))
    ratio_spread: float = attrs.field(default=0.15, validator=within(0.0, 0.9))

    def __attrs_post_init__(self) -> None:
        if not (self.white or self.yellow):
            raise ValueError("white, yellow are both 0: at least one weight above 0 is allowed")


@attrs.frozen
class Colour:
    """A paint's colour in both ways of telling it, as in `pavemark.scene.Paint`."""

    rgb: RGB
    ratio: RGB


def sample(rng: np.random.Generator, ranges: Ranges, palette: Palette, measured: tuple[RGB, ...]) -> Colour:
    """Draw a paint.

    Parameters
    ----------
    measured : tuple of RGB
        Ratios of the plate's own former markings. Where it had any that stand out and are not red, the quartiles of
        their luminance, the upper one freshened, are the range, and one of them gives hue and family, also of the
        absolute colour.
    """
    paint = [ratio for ratio in measured if np.dot(LUMINANCE, ratio) > 1 and ratio[1] > _REDDEST * ratio[0]]
    brighter = np.array(paint).reshape(-1, 3)
    family = weighted(rng, {"white": ranges.white, "yellow": ranges.yellow})
    own = int(rng.random() * len(brighter))
    if len(brighter):
        family = "yellow" if brighter[own][2] < _YELLOW * brighter[own][0] else "white"
    shade = _shade(rng, getattr(palette, family))
    rgb = np.clip(np.array(shade.rgb) + ranges.spread * rng.uniform(-1, 1, 3), 0, 255)
    # One factor for the coat, a tenth of its spread for each channel: paints differ in depth more than in hue.
    factor = 1 + ranges.ratio_spread * (rng.uniform(-1, 1) + 0.1 * rng.uniform(-1, 1, 3))
    share = rng.random()
    if len(brighter):
        low, high = np.clip(np.quantile(brighter @ LUMINANCE, (0.25, 0.75)) * (1, _FRESH), _FAINTEST, _BRIGHTEST)
        ratio = brighter[own] / (brighter[own] @ LUMINANCE) * (low + share * (high - low))
    else:
        ratio = np.array(shade.ratio) * factor
        luminance = ratio @ LUMINANCE
        if not ranges.ratio[0] <= luminance <= ranges.ratio[1]:
            ratio *= (ranges.ratio[0] + share * (ranges.ratio[1] - ranges.ratio[0])) / luminance
    if family == "white":
        luminance = ratio @ LUMINANCE
        ratio = np.clip(ratio, (1 - _TINT) * luminance, (1 + _TINT) * luminance)
    return Colour(_rgb(rgb), _rgb(np.clip(ratio, 0.05, 20.0)))


def on_grey(ratio: RGB, opacity: float = 1.0) -> Paint:
    """A coat known by its reflectance over that of a grey floor; its absolute colour is the one it has there."""
    return Paint(_rgb(np.clip(to_display(np.clip(_GREY * np.array(ratio), 0, 1)), 0, 255)), ratio, opacity)


def _shade(rng: np.random.Generator, shades: tuple[Shade, ...]) -> Shade:
    return shades[int(weighted(rng, {str(k): shade.weight for k, shade in enumerate(shades)}))]


def _rgb(values: np.ndarray) -> RGB:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
