"""The image of a scene as plain OpenCV makes it: what Pavemark is measured against."""

from __future__ import annotations

import cv2
import numpy as np
import shapely

from pavemark.geometry.outline import outline
from pavemark.plate import Plate
from pavemark.scene import Brightness, Curvature, Noise, Scene


def composite(scene: Scene, plate: Plate) -> np.ndarray:
    """Filled polygons, a remap for the elastic bend, `seamlessClone`, a blur, brightness and noise.

    Returns
    -------
    ndarray (H, W, 3), uint8
        Display sRGB. No textures, no optics, no reflectance: only what OpenCV has a call for.
    """
    painted, mask = _filled(scene, plate)
    if scene.curvature is not None:
        x, y = _bent(scene.curvature, plate)
        painted = cv2.remap(painted, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        mask = cv2.remap(mask, x, y, cv2.INTER_LINEAR)
    mask[~plate.ground] = 0
    image = _cloned(painted, mask, plate.image)
    soft = cv2.GaussianBlur(image, (5, 5), 0)
    edge = cv2.morphologyEx(mask, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
    image = np.where(edge[..., None], soft, image)
    if scene.brightness is not None:
        image = _lit(image, scene.brightness)
    return image if scene.noise is None else _noisy(image, scene.noise)


def _filled(scene: Scene, plate: Plate) -> tuple[np.ndarray, np.ndarray]:
    painted, mask = plate.image.copy(), np.zeros(plate.ground.shape, np.uint8)
    fraction = 4
    for marking in scene.markings:
        for polygon in outline(marking, None).geoms:
            rings = [polygon.exterior, *polygon.interiors]
            pixels = [plate.frame.to_image(shapely.get_coordinates(ring)) - 0.5 for ring in rings]
            fixed = [np.rint(ring * 2**fraction).astype(np.int32) for ring in pixels]
            cv2.fillPoly(painted, fixed, marking.paint.rgb, cv2.LINE_AA, fraction)
            cv2.fillPoly(mask, fixed, 255, cv2.LINE_AA, fraction)
    return painted, mask


def _bent(curvature: Curvature, plate: Plate) -> tuple[np.ndarray, np.ndarray]:
    height, width = plate.ground.shape
    noise = np.random.default_rng(curvature.seed).uniform(-1, 1, (height, width, 2)).astype(np.float32)
    field = cv2.GaussianBlur(noise, (0, 0), curvature.sigma * plate.frame.scale)
    field *= curvature.alpha * plate.frame.scale / 60
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    return x + field[..., 0], y + field[..., 1]


def _cloned(painted: np.ndarray, mask: np.ndarray, ground: np.ndarray) -> np.ndarray:
    # seamlessClone eats 3 px of the mask a side, and throws where it meets the border.
    wide = cv2.dilate(mask, np.ones((15, 15), np.uint8))
    wide[:2], wide[-2:], wide[:, :2], wide[:, -2:] = 0, 0, 0, 0
    if not wide.any():
        return ground
    left, top, width, height = cv2.boundingRect(wide)
    return cv2.seamlessClone(painted, ground, wide, (left + width // 2, top + height // 2), cv2.NORMAL_CLONE)


def _lit(image: np.ndarray, brightness: Brightness) -> np.ndarray:
    hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV)
    hsv[..., 2] = cv2.convertScaleAbs(hsv[..., 2], alpha=brightness.factor)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


def _noisy(image: np.ndarray, noise: Noise) -> np.ndarray:
    rng = np.random.default_rng(noise.seed)
    if noise.kind == "salt-and-pepper":
        draw = rng.random(image.shape[:2])
        image = image.copy()
        image[draw < noise.amount / 2] = 0
        image[draw > 1 - noise.amount / 2] = 255
        return image
    scale = noise.amount if noise.kind == "gaussian" else noise.amount / np.sqrt(2)
    grain = (rng.normal if noise.kind == "gaussian" else rng.laplace)(0, scale, image.shape)
    return np.clip(np.rint(image + grain), 0, 255).astype(np.uint8)
