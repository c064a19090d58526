"""What a cheap car camera does to the light: exposure, white balance, vignette, noise, sharpening, JPEG."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from pavemark.colour import quantise


@attrs.frozen
class Sensor:
    """One camera's electronics.

    Attributes
    ----------
    target : float
        Mean of the picture after automatic exposure, linear light, 0 to 1.
    balance : tuple of float
        Gain of R, G and B.
    vignette : float
        Share of the light lost at the rim of the image circle.
    shot, read : float
        Standard deviation of the noise: of the light's square root, and constant; linear light.
    chroma : float
        Standard deviation of blotches of colour, in display levels 0 to 1.
    sharpen : float
        Strength of the unsharp mask that draws halos beside lines.
    quality : int
        JPEG quality of the camera's stream.
    seed : int
    """

    target: float
    balance: tuple[float, float, float]
    vignette: float
    shot: float
    read: float
    chroma: float
    sharpen: float
    quality: int
    seed: int


def sample(rng: np.random.Generator, noise: float, target: float) -> Sensor:
    """Draw one camera of a set.

    Parameters
    ----------
    rng : Generator
    noise : float
        1 in daylight, more in the dark.
    target : float
        Mean linear light that the set aims for; each camera misses it a little, which makes the steps at the seams.
    """
    warm, green = rng.normal(0, 0.08), rng.normal(0, 0.03)
    return Sensor(
        target=float(target * np.exp(rng.normal(0, 0.22))),
        balance=(float(1 + warm), float(1 + green), float(1 - warm)),
        vignette=float(rng.uniform(0.25, 0.45)),
        shot=float(0.012 * noise),
        read=float(0.003 * noise),
        chroma=float(0.006 * noise),
        sharpen=float(rng.uniform(0.9, 1.5)),
        quality=int(rng.integers(80, 92)),
        seed=int(rng.integers(2**31)),
    )


def develop(light: np.ndarray, used: np.ndarray, sensor: Sensor) -> np.ndarray:
    """The picture that a camera makes of the light it sees.

    Parameters
    ----------
    light : ndarray (h, w, 3), float32
        Linear light, any unit.
    used : ndarray (h, w), bool
        The part that the exposure is metered on.
    sensor : Sensor

    Returns
    -------
    ndarray (h, w, 3), uint8
        Display sRGB.
    """
    rng = np.random.default_rng(sensor.seed)
    height, width = light.shape[:2]
    v, u = np.mgrid[0:height, 0:width]
    radius = np.hypot((u + 0.5) / width - 0.5, (v + 0.5) / height - 0.5) * 2
    exposed = light * (1 - sensor.vignette * np.clip(radius, 0, 1) ** 2)[..., None] * np.array(sensor.balance)
    exposed *= sensor.target / max(float(exposed[used].mean()), 1e-6)
    exposed += rng.normal(size=exposed.shape) * (sensor.shot * np.sqrt(np.clip(exposed, 0, 1)) + sensor.read)
    display = _display(exposed).astype(np.float32)
    blotches = cv2.resize(rng.normal(size=(height // 2 + 1, width // 2 + 1, 3)).astype(np.float32), (width, height))
    display += sensor.chroma * (blotches - blotches.mean(-1, keepdims=True))
    display += sensor.sharpen * (display - cv2.GaussianBlur(display, (0, 0), 1.3))
    coded = cv2.imencode(".jpg", quantise(display * 255)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, sensor.quality])[1]
    return cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1]


def _display(light: np.ndarray) -> np.ndarray:
    """Linear light to display sRGB, highlights above 0.6 rolled off so that glare keeps its shape."""
    light = np.clip(light, 0, None)
    knee = 0.6
    light = np.where(light > knee, 1 - (1 - knee) * np.exp(-(light - knee) / (1 - knee)), light)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
