"""How far a filled hole is from the truth: one function a measure, each over the hole alone.

No one of them suffices. On regular paving a mere blur has a better PSNR than a fill that carries the joints on, half a
brick off; what is blurred betrays itself by its texture, what does not fit by the step across the hole's rim.
"""

from __future__ import annotations

import cv2
import numpy as np
import OpenImageIO as oiio

from pavemark.colour import LINEAR

WINDOW = 7
"""Pixels a side of the windows of SSIM."""

FINE = 2.0
"""Standard deviation in pixels of the Gaussian that divides texture from the rest."""

REACH = 2.5
"""Standard deviation in pixels of the Gaussian mean on either side of the hole's rim."""


def psnr(fill: np.ndarray, truth: np.ndarray, hole: np.ndarray) -> float:
    """Peak signal-to-noise ratio in dB over the hole, all channels together, peak 255; inf where nothing differs.

    Parameters
    ----------
    fill, truth : ndarray (H, W, 3) uint8
        Display sRGB.
    hole : ndarray (H, W) bool
        At least one pixel.

    Examples
    --------
    >>> truth = np.full((9, 9, 3), 100, np.uint8)
    >>> round(psnr(truth + np.uint8(5), truth, np.ones((9, 9), bool)), 3)  # 20 log10(255 / 5)
    34.151
    """
    error = ((fill[hole].astype(np.float64) - truth[hole]) ** 2).mean()
    return float("inf") if error == 0 else float(10 * np.log10(255**2 / error))


def ssim(fill: np.ndarray, truth: np.ndarray, hole: np.ndarray) -> float:
    """Structural similarity (Wang et al., 2004), mean over the channels and the hole's pixels; 1 where nothing differs.

    Windows of 7×7 pixels of equal weight, sample covariance, K1 = 0.01, K2 = 0.03, range 255: scikit-image's defaults.

    Parameters
    ----------
    fill, truth : ndarray (H, W, 3) uint8
        Display sRGB, equal outside the hole.
    hole : ndarray (H, W) bool
        Pixels whose window reaches beyond the picture do not count.

    Returns
    -------
    float
        nan where no pixel's window lies in the picture.
    """
    x, y = fill.astype(np.float64), truth.astype(np.float64)
    unbiased = WINDOW**2 / (WINDOW**2 - 1)
    mean_x, mean_y = _mean(x), _mean(y)
    variance_x = unbiased * (_mean(x * x) - mean_x**2)
    variance_y = unbiased * (_mean(y * y) - mean_y**2)
    covariance = unbiased * (_mean(x * y) - mean_x * mean_y)
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    light = (2 * mean_x * mean_y + c1) / (mean_x**2 + mean_y**2 + c1)
    similarity = light * (2 * covariance + c2) / (variance_x + variance_y + c2)
    pad = WINDOW // 2
    whole = np.zeros_like(hole)
    whole[pad:-pad, pad:-pad] = hole[pad:-pad, pad:-pad]
    return float(similarity[whole].mean()) if whole.any() else float("nan")


def flip(fill: np.ndarray, truth: np.ndarray, hole: np.ndarray) -> float:
    """What an eye sees of the difference when the two pictures are flipped: LDR-FLIP (Andersson et al., 2020).

    The error map is OpenImageIO's, of the whole pictures in linear light at 67 pixels a degree (a screen 0.7 m away);
    its mean over the hole is 0 where nothing is seen and at most 1.

    Parameters
    ----------
    fill, truth : ndarray (H, W, 3) uint8
        Display sRGB, equal outside the hole.
    hole : ndarray (H, W) bool

    Returns
    -------
    float
        nan where OpenImageIO is older than 3.2, which brought FLIP.
    """
    if not hasattr(oiio.ImageBufAlgo, "FLIP_diff"):
        return float("nan")
    errors = oiio.ImageBufAlgo.FLIP_diff(_linear(truth), _linear(fill), hdr=0, nthreads=1)
    return float(errors.get_pixels(oiio.FLOAT)[..., 0].astype(np.float64)[hole].mean())


def texture(fill: np.ndarray, truth: np.ndarray, hole: np.ndarray) -> float:
    """Texture energy of the fill as a share of the truth's: below 1 it is too smooth, above 1 too rough.

    The standard deviation over the hole of what a Gaussian blur of 2 pixels takes away, root mean square of the
    channels.

    Parameters
    ----------
    fill, truth : ndarray (H, W, 3) uint8
        Display sRGB, equal outside the hole.
    hole : ndarray (H, W) bool

    Returns
    -------
    float
        nan where the truth has no texture.
    """
    made, true = (_fine(picture)[hole].std(0) for picture in (fill, truth))
    energy = np.sqrt((true**2).mean())
    return float(np.sqrt((made**2).mean()) / energy) if energy else float("nan")


def step(fill: np.ndarray, truth: np.ndarray, hole: np.ndarray, beside: np.ndarray) -> float:
    """How much more the picture jumps across the hole's rim than the truth does there, in 8-bit levels.

    At every pixel of the rim the Gaussian mean of the fill (reach 2.5 pixels) is held against that of the ground on the
    other side; mean over rim and channels of the absolute difference, less the same of the truth. 0 is a fill that
    joins as the ground does, above it a seam shows, below it the fill runs on more smoothly than the ground would.

    Parameters
    ----------
    fill, truth : ndarray (H, W, 3) uint8
        Display sRGB, equal outside the hole.
    hole : ndarray (H, W) bool
    beside : ndarray (H, W) bool
        What counts as the other side: ground that is neither hole nor kept out.

    Returns
    -------
    float
        nan where the hole borders on no such ground.
    """
    other = beside & ~hole
    cross = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
    rim = hole & (cv2.dilate(other.astype(np.uint8), cross) > 0)
    if not rim.any():
        return float("nan")
    outside = _mean_within(truth, other)[rim]
    made, true = (np.abs(_mean_within(picture, hole)[rim] - outside).mean() for picture in (fill, truth))
    return float(made - true)


def _mean(array: np.ndarray) -> np.ndarray:
    return cv2.blur(array, (WINDOW, WINDOW), borderType=cv2.BORDER_REFLECT)


def _linear(picture: np.ndarray) -> oiio.ImageBuf:
    height, width, _ = picture.shape
    buffer = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, oiio.FLOAT))
    buffer.set_pixels(buffer.roi, LINEAR[picture].astype(np.float32))
    return buffer


def _fine(picture: np.ndarray) -> np.ndarray:
    picture = picture.astype(np.float64)
    return picture - cv2.GaussianBlur(picture, (0, 0), FINE, borderType=cv2.BORDER_REFLECT)


def _mean_within(picture: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Gaussian mean (H, W, 3) of the pixels that belong to a part."""
    weight = part.astype(np.float64)
    total = cv2.GaussianBlur(picture * weight[..., None], (0, 0), REACH)
    return total / np.maximum(cv2.GaussianBlur(weight, (0, 0), REACH), 1e-9)[..., None]
