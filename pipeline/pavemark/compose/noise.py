"""Sensor noise over the whole image (the paper's noise domain)."""

from __future__ import annotations

import numpy as np

from pavemark.scene import Noise


def apply(image: np.ndarray, noise: Noise) -> np.ndarray:
    """Add the noise that a scene lists.

    Gaussian and Laplacian noise is drawn for every pixel and channel with standard deviation `amount`.
    Salt-and-pepper hits whole pixels with probability `amount` and makes half of them white, half black.

    Parameters
    ----------
    image : ndarray (H, W, 3) float32
        Display levels 0 to 255.
    noise : Noise
        All randomness comes from its seed.

    Returns
    -------
    ndarray (H, W, 3) float32
        Display levels, neither rounded nor clipped.
    """
    rng = np.random.Generator(np.random.PCG64(noise.seed))
    return _KINDS[noise.kind](rng, image, np.float32(noise.amount))


def _gaussian(rng: np.random.Generator, image: np.ndarray, deviation: np.float32) -> np.ndarray:
    return image + deviation * rng.standard_normal(image.shape, np.float32)


def _laplacian(rng: np.random.Generator, image: np.ndarray, deviation: np.float32) -> np.ndarray:
    # The difference of two exponentials is Laplacian, and has twice the variance of one.
    difference = rng.standard_exponential(image.shape, np.float32) - rng.standard_exponential(image.shape, np.float32)
    return image + deviation * np.float32(0.5**0.5) * difference


def _salt_and_pepper(rng: np.random.Generator, image: np.ndarray, share: np.float32) -> np.ndarray:
    draw = rng.random(image.shape[:2], np.float32)
    result = image.copy()
    result[draw < share] = 255
    result[draw < share / 2] = 0
    return result


_KINDS = {"gaussian": _gaussian, "laplacian": _laplacian, "salt-and-pepper": _salt_and_pepper}
