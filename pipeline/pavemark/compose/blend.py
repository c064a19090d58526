"""How the decals enter the plate: Poisson editing in log linear light or in display space, or plain alpha.

All Poisson methods solve on the marking widened by a margin, with the plate as boundary. They differ in the gradient
that is wanted along a link of neighbouring pixels. Where what stands on the ground cuts a marking, that gradient is
the plain composite's, so that nothing bleeds from a car into the paint. Where paint leaves no pixel of the plate to
hold on to, the plain composite is the answer.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from pavemark.colour import LINEAR, lit_grey, to_display, within_gamut
from pavemark.compose import poisson
from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Blend

FAINTEST = 1 / 512
"""Alpha that cannot show: less than half a level even for white on black."""

DARKEST = float(LINEAR[1]) / 2
"""Linear light added before the logarithm: half the first 8-bit step, which is all that a black byte says."""

BLACKEST = 1e-3
"""Least reflectance ratio: soot on asphalt; dirt may take a paint to zero, whose logarithm is not finite."""

NEIGHBOURHOOD = 0.5
"""Metres a side of the square in which paint keeps the light that its ratio asks for."""


LOG = np.log(LINEAR + DARKEST)
"""Log linear light (256,) float64 of each 8-bit display level."""
LOG.setflags(write=False)


@attrs.frozen(eq=False)
class _Decal:
    """The painted pixels, flat: their index (P,), alpha (P,) and premultiplied colour (P, 3), float64."""

    pixels: np.ndarray
    alpha: np.ndarray
    colour: np.ndarray


def apply(plate: Plate, layers: Layers, blend: Blend) -> np.ndarray:
    """Blend the decals into the plate.

    Parameters
    ----------
    plate : Plate
    layers : Layers
    blend : Blend

    Returns
    -------
    ndarray (H, W, 3) float32
        Display levels 0 to 255, not rounded; exactly the plate's outside the domain, which is the marking widened by
        `blend.margin` pixels ("alpha": the marking) and never leaves the plate's ground.
    """
    decal = _decal(plate, layers.decals, blend.edge_blur)
    image = plate.image.astype(np.float32)
    if len(decal.pixels):
        pixels, levels = _METHODS[blend.method](plate, decal, blend)
        image.reshape(-1, 3)[pixels] = levels
    return image


def _decal(plate: Plate, decals: np.ndarray, edge_blur: bool) -> _Decal:
    if edge_blur:
        decals = cv2.GaussianBlur(decals, (5, 5), 0, borderType=cv2.BORDER_REPLICATE)
    pixels = np.flatnonzero((decals[..., 3] > FAINTEST) & plate.ground)
    values = decals.reshape(-1, 4)[pixels].astype(np.float64)
    return _Decal(pixels, values[:, 3], values[:, :3])


def _domain(plate: Plate, decal: _Decal, margin: int) -> np.ndarray:
    painted = np.zeros(plate.ground.shape, np.uint8)
    painted.reshape(-1)[decal.pixels] = 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * margin + 1, 2 * margin + 1))
    return (cv2.dilate(painted, disc) > 0) & plate.ground


def _everywhere(plate: Plate, decal: _Decal, values: np.ndarray) -> np.ndarray:
    """Values (P, C) of the painted pixels as a flat picture (H·W, C), 0 elsewhere."""
    picture = np.zeros((plate.ground.size, values.shape[1]), values.dtype)
    picture[decal.pixels] = values
    return picture


@attrs.frozen(eq=False)
class Asked:
    """What "reflectance" asks for: Poisson's equation as `poisson.solve` takes it, in log linear light.

    Attributes
    ----------
    domain, a, b, guidance, boundary : ndarray
        See `poisson.solve`.
    plain : ndarray (P, 3) float64
        What paint over ground is without an equation, at the painted pixels.
    """

    domain: np.ndarray
    a: np.ndarray
    b: np.ndarray
    guidance: np.ndarray
    boundary: np.ndarray
    plain: np.ndarray


def asked(plate: Plate, layers: Layers, blend: Blend) -> Asked:
    """The equation of a blend with the method "reflectance"."""
    return _asked(plate, _decal(plate, layers.decals, blend.edge_blur), blend)


def lit(log: np.ndarray) -> np.ndarray:
    """Display levels (..., 3), 0 to 255, not rounded, of log linear light as `Asked` has it."""
    return to_display(within_gamut(np.exp(log) - DARKEST, 1.0))


def _asked(plate: Plate, decal: _Decal, blend: Blend) -> Asked:
    """Gradient of the log reflectance ratio, plus the plate's own, damped where both ends lie under paint."""
    domain = _domain(plate, decal, blend.margin)
    a, b = poisson.links(domain)
    ground = LOG[plate.image].reshape(-1, 3)
    ratio = np.maximum(decal.colour * _hue_hidden(plate, decal) + (1 - decal.alpha)[:, None], BLACKEST)
    paint = _everywhere(plate, decal, np.log(ratio))
    alpha = _everywhere(plate, decal, decal.alpha[:, None])
    hidden = (1 - blend.ground_texture) * np.minimum(alpha[a], alpha[b])
    guidance = paint[b] - paint[a] + (1 - hidden) * (ground[b] - ground[a])
    plain = paint[decal.pixels] + ground[decal.pixels]
    return Asked(domain, a, b, guidance, ground.reshape(plate.image.shape), plain)


def _reflectance(plate: Plate, decal: _Decal, blend: Blend) -> tuple[np.ndarray, np.ndarray]:
    """Solved for the light, which is then raised to what the ratio asks for."""
    equation = _asked(plate, decal, blend)
    domain = equation.domain
    if domain.all():
        return decal.pixels, lit(equation.plain)
    solved = poisson.solve(domain, equation.a, equation.b, equation.guidance, equation.boundary)
    pixels = np.flatnonzero(domain)
    under = (np.cumsum(domain) - 1)[decal.pixels]
    gain = _gain(plate, decal, np.exp(equation.plain), np.exp(solved[under]))
    solved[under] += decal.alpha[:, None] * np.log(gain)
    return pixels, lit(solved)


def _hue_hidden(plate: Plate, decal: _Decal) -> np.ndarray:
    """Factor (P, 3) on a ratio that takes the ground's own hue out of the paint and leaves luminance as it is.

    A ratio to a green floor would make green paint. The ground is taken over the neighbourhood.
    """
    side = 2 * round(NEIGHBOURHOOD * plate.frame.scale / 2) + 1
    near = cv2.boxFilter(LINEAR.astype(np.float32)[plate.image], -1, (side, side), borderType=cv2.BORDER_REFLECT)
    ground = near.reshape(-1, 3)[decal.pixels].astype(np.float64) + DARKEST
    return lit_grey(ground) / ground


def _gain(plate: Plate, decal: _Decal, asked: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Light asked for over light found (P, 3), each the mean over the paint of the neighbourhood.

    Damped in the logarithm, texture closes in on its geometric mean, which is darker than the mean of its light: by
    5 % on brick. Alpha times a constant is integrable, so adding it afterwards is the solution for that source.
    """
    side = 2 * round(NEIGHBOURHOOD * plate.frame.scale / 2) + 1

    def near(light: np.ndarray) -> np.ndarray:
        picture = _everywhere(plate, decal, (decal.alpha[:, None] * light).astype(np.float32))
        sums = cv2.boxFilter(picture.reshape(plate.image.shape), -1, (side, side), normalize=False)
        return sums.reshape(-1, 3)[decal.pixels]

    return near(asked) / near(found)


def _normal(plate: Plate, decal: _Decal, blend: Blend) -> tuple[np.ndarray, np.ndarray]:
    """Gradient of the source where it is painted: the marking on a flat ground of the domain's mean colour."""
    return _seamless(plate, decal, blend, lambda source, ground: source)


def _mixed(plate: Plate, decal: _Decal, blend: Blend) -> tuple[np.ndarray, np.ndarray]:
    """The stronger of the source's gradient and the plate's, all channels together so that hues stay."""

    def stronger(source: np.ndarray, ground: np.ndarray) -> np.ndarray:
        return np.where(((source**2).sum(1) > (ground**2).sum(1))[:, None], source, ground)

    return _seamless(plate, decal, blend, stronger)


def _seamless(plate: Plate, decal: _Decal, blend: Blend, wanted) -> tuple[np.ndarray, np.ndarray]:
    """Poisson editing of display levels with absolute colours (Pérez, Gangnet, Blake 2003, Eq. 9 to 13)."""
    domain = _domain(plate, decal, blend.margin)
    if domain.all():
        return _alpha(plate, decal, blend)
    a, b = poisson.links(domain)
    ground = plate.image.reshape(-1, 3).astype(np.float64)
    colour = _absolute(decal)
    alpha = decal.alpha[:, None]
    flat = ground[domain.reshape(-1)].mean(0)
    source = _everywhere(plate, decal, alpha * (colour - flat))
    covered = _everywhere(plate, decal, alpha)

    own = ground[b] - ground[a]
    painted = np.maximum(covered[a], covered[b])[:, 0] > 0
    guidance = own.copy()
    guidance[painted] = wanted((source[b] - source[a])[painted], own[painted])
    cut = np.flatnonzero(painted & ~(plate.ground.reshape(-1)[a] & plate.ground.reshape(-1)[b]))
    over = ground.copy()
    over[decal.pixels] += alpha * (colour - ground[decal.pixels])
    guidance[cut] = over[b[cut]] - over[a[cut]]
    solved = poisson.solve(domain, a, b, guidance, ground.reshape(plate.image.shape))
    return np.flatnonzero(domain), within_gamut(solved, 255.0)


def _alpha(plate: Plate, decal: _Decal, blend: Blend) -> tuple[np.ndarray, np.ndarray]:
    """Over, in display space."""
    ground = plate.image.reshape(-1, 3)[decal.pixels]
    return decal.pixels, ground + decal.alpha[:, None] * (_absolute(decal) - ground)


def _absolute(decal: _Decal) -> np.ndarray:
    """Display levels (P, 3) of the decal's own colour."""
    return to_display(within_gamut(decal.colour / decal.alpha[:, None], 1.0))


_METHODS = {"reflectance": _reflectance, "normal": _normal, "mixed": _mixed, "alpha": _alpha}
