"""How blurred a picture is where, measured on its own edges, and the same blur for the decals.

An AVM picture is resampled from fisheye cameras: sharp beside the car, ever softer away from it.
"""

from __future__ import annotations

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from pavemark.layers import Layers
from pavemark.plate import Plate
from pavemark.scene import Optics

NODES = 6
"""Nodes of the measured grid along the longer side."""

SHARPEST, SOFTEST = 0.5, 3.0
"""Blur in pixels between which a measurement is believed: sharper is noise or texture, softer is shading."""

UNKNOWN = 0.9
"""Blur in pixels of a picture without edges: the median beside the car of 12 real AVM pictures."""

LEAST_EDGES = 25
"""Edge pixels that a node needs; the median of fewer is uncertain by more than 0.1 px."""

FAINTEST = 3.0
"""Least gradient in levels a pixel that is an edge and not noise."""

FINE, COARSE = 0.7, 1.5
"""The two test blurs in pixels: the first calms noise, the second keeps the two edges of a 10 cm line apart."""

STEP = 0.5
"""Most pixels of blur between the copies that `apply` mixes."""


def measure(plate: Plate) -> tuple[tuple[float, ...], ...]:
    """The picture's local blur, from the edges of its ground and of its former markings.

    At a step edge blurred by σ the gradient is proportional to (σ² + s²)^-½ after a further blur by s; two such
    blurs give σ (Zhuo and Sim, *Defocus map estimation from a single image*, 2011, here with two re-blurs against
    noise). Only straight, lone edges count, as texture is no step.

    Parameters
    ----------
    plate : Plate
        Its source is measured, where it is ground.

    Returns
    -------
    tuple of tuple of float
        Standard deviation in pixels for `Optics.blur`, without the pixel's own aperture (variance 1/12), which the
        decals' coverage has already. A node without edges takes the median of those that have some.
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
    known = blur[np.isfinite(blur)]
    blur[np.isnan(blur)] = np.median(known) if len(known) else UNKNOWN
    blur = np.sqrt(blur**2 - 1 / 12)
    return tuple(tuple(round(float(value), 3) for value in row) for row in blur)


def _edges(plate: Plate) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Image coordinates (N,), (N,) of straight, lone edge pixels and the blur σ (N,) of each."""
    grey = cv2.cvtColor(plate.source, cv2.COLOR_RGB2GRAY).astype(np.float32)
    (across, down), coarse = _gradient(grey, FINE), _gradient(grey, COARSE)
    strength = np.hypot(across, down)
    ground = cv2.erode(plate.ground.astype(np.uint8), np.ones((13, 13), np.uint8), borderValue=1) > 0
    v, u = np.nonzero(ground & (strength > FAINTEST))
    strength = strength[v, u]
    x, y = across[v, u] / strength, down[v, u] / strength

    def along(gradient: tuple[np.ndarray, np.ndarray], du: np.ndarray, dv: np.ndarray) -> np.ndarray:
        """Slope in the direction of the edge's own gradient, (du, dv) pixels away."""
        place = [v + dv, u + du]
        return x * map_coordinates(gradient[0], place, order=1) + y * map_coordinates(gradient[1], place, order=1)

    def busy(side: int) -> np.ndarray:
        """Steepest slope beyond the edge; nearer by, the tail of a soft edge counts less."""
        far, near = (np.abs(along(fine, side * r * x, side * r * y)) for r in (4.5, 3))
        return np.maximum(far, 0.6 * near)

    fine = across, down
    ridge = (strength >= along(fine, x, y)) & (strength >= along(fine, -x, -y))
    straight = np.minimum(along(fine, -6 * y, 6 * x), along(fine, 6 * y, -6 * x)) > 0.75 * strength
    lone = np.minimum(busy(1), busy(-1)) < 0.3 * strength
    steeper = (strength / along(coarse, 0 * x, 0 * y)) ** 2
    variance = (COARSE**2 - steeper * FINE**2) / np.maximum(steeper - 1, 1e-6)
    kept = ridge & straight & lone & (variance > SHARPEST**2) & (variance < SOFTEST**2)
    return u[kept] + 0.5, v[kept] + 0.5, np.sqrt(variance[kept])


def _gradient(grey: np.ndarray, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (across, down), levels a pixel, of a picture (H, W) blurred by sigma."""
    soft = cv2.GaussianBlur(grey, (0, 0), sigma)
    return cv2.Scharr(soft, -1, 1, 0, scale=1 / 32), cv2.Scharr(soft, -1, 0, 1, scale=1 / 32)


def apply(layers: Layers, optics: Optics) -> Layers:
    """Blur the decals as the cameras blurred the picture.

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
    height, width = layers.decals.shape[:2]
    sigma = _over(np.array(optics.blur), height, width)
    reach = int(np.ceil(4 * sigma.max()))
    v, u = (np.flatnonzero((layers.decals[..., 3] > 0).any(axis)) for axis in (1, 0))
    if not len(v) or not reach:
        return layers
    box = tuple(slice(max(0, at[0] - reach), at[-1] + reach + 1) for at in (v, u))
    decals = np.zeros_like(layers.decals)
    decals[box] = _mixed(layers.decals[box], sigma[box])
    return Layers(decals)


def _over(nodes: np.ndarray, height: int, width: int) -> np.ndarray:
    """Values (H, W) float32 at the pixel centres of a grid whose outer nodes lie on the frame's border."""
    rows, columns = (np.minimum((np.arange(n) + 0.5) / n * (k - 1), k - 1) for n, k in zip((height, width), nodes.shape))
    down = np.array([np.interp(rows, np.arange(nodes.shape[0]), column) for column in nodes.T])
    return np.array([np.interp(columns, np.arange(nodes.shape[1]), row) for row in down.T], np.float32)


def _mixed(decals: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    least, most = float(sigma.min()), float(sigma.max())
    levels = np.linspace(least, most, int(np.ceil((most - least) / STEP)) + 1)
    result = _blurred(decals, levels[0])
    for low, high in zip(levels, levels[1:]):
        # Variances mix linearly, deviations do not.
        share = np.clip((sigma**2 - low**2) / (high**2 - low**2), 0, 1)[..., None]
        result += share * (_blurred(decals, high) - _blurred(decals, low))
    return result


def _blurred(decals: np.ndarray, sigma: float) -> np.ndarray:
    """Decals after a Gaussian of one sigma; the paint goes on beyond the picture's border."""
    if sigma == 0:
        return decals.copy()
    return cv2.GaussianBlur(decals, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
