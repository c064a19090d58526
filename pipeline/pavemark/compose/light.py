"""Light on the finished ground: raised paint, shadows, wet patches and glare, each a step of its own.

All of them work in linear light and on the plate's ground alone: what stands on it has its own light already.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from pavemark.colour import to_display, to_linear
from pavemark.compose.glare import gleam
from pavemark.layers import Layers
from pavemark.light import Glare, Relief, Shadows, Wet
from pavemark.plate import Plate

FAINTEST = 1e-4
"""Light, or share of it, that cannot show: on black ground it would be a third of a level."""


def relief(image: np.ndarray, plate: Plate, layers: Layers, effect: Relief) -> np.ndarray:
    """Light and shade the rims of raised paint; where paint is worn off, nothing stands up.

    Parameters
    ----------
    image : ndarray (H, W, 3) float32
        Display levels 0 to 255.
    plate : Plate
    layers : Layers
        With `relief`, and the decals.
    effect : Relief

    Returns
    -------
    ndarray (H, W, 3) float32
        Display levels 0 to 255, not rounded; exactly as before wherever the light is.
    """
    reach = math.ceil(effect.height / math.tan(effect.sun.elevation) * plate.frame.scale) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    paint = np.minimum(cv2.dilate(np.ascontiguousarray(layers.decals[..., 3]), disc), 1.0)
    light = 1 + (1 - effect.left) * (layers.relief[..., 0] - 1) * paint
    return _lit(image, plate, light[..., None], None)


def shadows(image: np.ndarray, plate: Plate, layers: Layers, effect: Shadows) -> np.ndarray:
    """Take away the light whose source is hidden.

    Of a lamp's light the share that reaches the ground fades with the distance from its foot, of the rest none does.

    Parameters
    ----------
    image, plate, layers
        As for `relief`; with `shadows`.
    effect : Shadows

    Returns
    -------
    ndarray (H, W, 3) float32
        As from `relief`.
    """
    seen = layers.shadows.astype(np.float64)
    left, direct = np.asarray(effect.left), np.ones(1)
    if effect.lamp is not None:
        x, y, height = effect.lamp.place
        away = ((plate.frame.pixel_centres() - (x, y)) ** 2).sum(-1, keepdims=True)
        direct = (1 + away / height**2) ** -1.5
    light = (left + (1 - left) * direct * seen) / (left + (1 - left) * direct)
    return _lit(image, plate, light, None)


def wet(image: np.ndarray, plate: Plate, layers: Layers, effect: Wet) -> np.ndarray:
    """Darken wet ground, and add what it mirrors.

    Parameters
    ----------
    image, plate, layers
        As for `relief`; with `wet`.
    effect : Wet

    Returns
    -------
    ndarray (H, W, 3) float32
        As from `relief`.
    """
    return _lit(image, plate, 1 - effect.darkening * layers.wet[..., 3:], layers.wet[..., :3])


def glare(image: np.ndarray, plate: Plate, effect: Glare) -> np.ndarray:
    """Add what a smooth floor mirrors: see `pavemark.compose.glare`.

    Parameters
    ----------
    image, plate
        As for `relief`.
    effect : Glare

    Returns
    -------
    ndarray (H, W, 3) float32
        As from `relief`.
    """
    return _lit(image, plate, None, gleam(plate.frame, effect, plate.ground))


def _lit(image: np.ndarray, plate: Plate, light: np.ndarray | None, gleam: np.ndarray | None) -> np.ndarray:
    """Display levels with linear light multiplied by `light` (H, W, 1 or 3) and `gleam` (H, W, 3) added."""
    changed = np.zeros(plate.ground.shape, bool)
    if light is not None:
        changed |= (np.abs(light - 1) > FAINTEST).any(-1)
    if gleam is not None:
        changed |= (gleam > FAINTEST).any(-1)
    pixels = np.nonzero(changed & plate.ground)
    linear = to_linear(image[pixels])
    if light is not None:
        linear = linear * light[pixels]
    if gleam is not None:
        linear = linear + gleam[pixels]
    lit = image.astype(np.float32)
    # A sensor that has enough of one channel goes on counting the others: lamps come out white.
    lit[pixels] = to_display(np.clip(linear, 0.0, 1.0))
    return lit
