"""How blurred a picture is where, measured on its own edges, and the same blur for the decals.

An AVM picture is resampled from fisheye cameras: sharp beside the car, ever softer away from it.
"""

from __future__ import annotations

import itertools

import attrs
import cv2
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.special import ndtr

from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Optics

VERSION = 1
"""Counted up with every change that makes `measure` say something else: what is kept of it is then measured anew."""

NODES = 6
"""Nodes of the measured grid along the longer side."""

SHARPEST, SOFTEST = 0.6, 3.0
"""Blur in pixels, aperture included, that is believed: sharper is a camera seam or noise, softer is shading."""

UNKNOWN = 0.7
"""Blur in pixels of a picture without edges: the median of line edges beside the car in 12 real AVM pictures."""

LEAST_EDGES = 25
"""Edge pixels that a node needs; the median of fewer is uncertain by more than 0.1 px."""

FAINTEST = 3.0
"""Least gradient in levels a pixel that is an edge and not noise."""

CALM = 0.7
"""Blur in pixels against noise, while edges are looked for."""

APERTURE = 1 / 4
"""Variance in px² that is not the camera's: the pixel's own, 1/12, and the bilinear reading's, 1/6."""

STEP = 0.5
"""Most pixels of blur between the copies that `apply` mixes."""


def measure(plate: Plate) -> tuple[tuple[float, ...], ...]:
    """The picture's local blur, from the edges of its ground and of its former markings.

    A blurred step rises by Φ(t/σ) - Φ(-t/σ) within t pixels of its place; the rise within 3 px over that within 1 px
    gives σ. Only straight, lone edges count, as texture is no step.

    Parameters
    ----------
    plate : Plate
        Its source is measured, where it is ground.

    Returns
    -------
    tuple of tuple of float
        Standard deviation in pixels for `Optics.blur`, without the pixel's own aperture, which the decals' coverage
        has already. A node without edges takes the median of those that have some; a picture without edges, UNKNOWN.
    """
    u, v, sigma = _edges(plate)
    height, width = plate.ground.shape
    spacing = (max(height, width) - 1) / (NODES - 1)
    rows, columns = (max(2, round((side - 1) / spacing) + 1) for side in (height, width))
    blur = np.full((rows, columns), np.nan)
    for i, y in enumerate(np.linspace(0, height, rows)):
        for j, x in enumerate(np.linspace(0, width, columns)):
            near = sigma[np.maximum(abs(u - x), abs(v - y)) <= spacing * 0.75]
            if len(near) >= LEAST_EDGES:
                blur[i, j] = np.median(near)
    if np.isnan(blur).all():
        return ((UNKNOWN,),)
    blur = np.sqrt(np.where(np.isnan(blur), np.nanmedian(blur), blur) ** 2 - APERTURE)
    return tuple(tuple(round(float(value), 3) for value in row) for row in blur)


def _edges(plate: Plate) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Image coordinates (N,), (N,) of straight, lone edge pixels and the blur σ (N,) of each."""
    grey = cv2.cvtColor(plate.source, cv2.COLOR_RGB2GRAY).astype(np.float32)
    soft = cv2.GaussianBlur(grey, (0, 0), CALM)
    across, down = (cv2.Scharr(soft, -1, *axis, scale=1 / 32) for axis in ((1, 0), (0, 1)))
    strength = np.hypot(across, down)
    ground = cv2.erode(plate.ground.astype(np.uint8), np.ones((13, 13), np.uint8), borderValue=1) > 0
    v, u = np.nonzero(ground & (strength > FAINTEST))
    x, y = across[v, u] / strength[v, u], down[v, u] / strength[v, u]

    def read(picture: np.ndarray, t: float | np.ndarray, s: float = 0.0) -> np.ndarray:
        """The picture t pixels across each edge, towards its bright side, and s pixels along it."""
        return map_coordinates(picture, [v + t * y + s * x, u + t * x - s * y], order=1, mode="nearest")

    def slope(t: float, s: float = 0.0) -> np.ndarray:
        return x * read(across, t, s) + y * read(down, t, s)

    def busy(side: int) -> np.ndarray:
        """Slope beyond the edge; nearer by it may be the tail of a soft edge and counts less."""
        return np.maximum(np.abs(slope(4.5 * side)), 0.6 * np.abs(slope(3 * side)))

    before, here, after = slope(-1), slope(0), slope(1)
    ridge = (here >= before) & (here >= after)
    straight = np.minimum(slope(0, -6), slope(0, 6)) > 0.75 * here
    lone = np.minimum(busy(1), busy(-1)) < 0.3 * here
    kept = ridge & straight & lone
    v, u, x, y = v[kept], u[kept], x[kept], y[kept]
    before, here, after = before[kept], here[kept], after[kept]
    summit = 0.5 * (before - after) / np.minimum(before - 2 * here + after, -1e-6)

    def rise(t: float) -> np.ndarray:
        return sum(read(grey, summit + t, s) - read(grey, summit - t, s) for s in (-1.0, 0.0, 1.0))

    sigma = np.interp(rise(3) / np.maximum(rise(1), 1e-6), _RISES, _SIGMAS)
    kept = (sigma > SHARPEST) & (sigma < SOFTEST)
    return u[kept] + 0.5, v[kept] + 0.5, sigma[kept]


def apply(layers: Layers, optics: Optics) -> Layers:
    """Blur the layers as the cameras blurred the picture.

    Copies of fixed blur are mixed in the share that gives each pixel the wanted variance; a constant blur is exact.

    Parameters
    ----------
    layers : Layers
    optics : Optics

    Returns
    -------
    Layers
        Premultiplied as before, so that the paint's colour does not bleed.
    """
    rendered = {name: layer for name, layer in attrs.asdict(layers, recurse=False).items() if layer is not None}
    height, width = next(iter(rendered.values())).shape[:2]
    sigma = _over(np.array(optics.blur), height, width)
    reach = int(np.ceil(4 * sigma.max()))
    if not reach:
        return layers
    return Layers(**{name: _softened(layer, sigma, reach) for name, layer in rendered.items()})


def _softened(layer: np.ndarray, sigma: np.ndarray, reach: int) -> np.ndarray:
    """A layer (H, W, C) blurred by sigma (H, W) pixels; where it does not differ from its corner, it stays as it is."""
    v, u = (np.flatnonzero((layer != layer[0, 0]).any((axis, 2))) for axis in (1, 0))
    if not len(v):
        return layer
    box = tuple(slice(max(0, at[0] - reach), at[-1] + reach + 1) for at in (v, u))
    softened = layer.copy()
    softened[box] = _mixed(layer[box], sigma[box])
    return softened


def _over(nodes: np.ndarray, height: int, width: int) -> np.ndarray:
    """Values (H, W) float32 at the pixel centres of a grid whose outer nodes lie on the frame's border."""
    rows, columns = nodes.shape
    v = (np.arange(height) + 0.5) / height * (rows - 1)
    u = (np.arange(width) + 0.5) / width * (columns - 1)
    down = np.array([np.interp(v, np.arange(rows), column) for column in nodes.T])
    return np.array([np.interp(u, np.arange(columns), row) for row in down.T], np.float32)


def _mixed(decals: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    least, most = float(sigma.min()), float(sigma.max())
    levels = np.linspace(least, most, int(np.ceil((most - least) / STEP)) + 1).tolist()
    sharper = _blurred(decals, levels[0])
    result = sharper.copy()
    for low, high in itertools.pairwise(levels):
        softer = _blurred(decals, high)
        # Variances mix linearly, deviations do not.
        share = np.clip((sigma**2 - low**2) / (high**2 - low**2), 0, 1)
        result += share[..., None] * (softer - sharper)
        sharper = softer
    return result


def _blurred(decals: np.ndarray, sigma: float) -> np.ndarray:
    """Decals after a Gaussian of one sigma; the paint goes on beyond the picture's border."""
    if sigma == 0:
        return decals.copy()
    # OpenCV drops the axis of a single channel.
    return cv2.GaussianBlur(decals, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE).reshape(decals.shape)


_SIGMAS = np.geomspace(0.2, 6, 200)
_RISES = (2 * ndtr(3 / _SIGMAS) - 1) / (2 * ndtr(1 / _SIGMAS) - 1)
