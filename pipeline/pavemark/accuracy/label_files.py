"""Label files as others read them: nothing here is shared with what writes them.

Points come in image coordinates, continuous, 0…W and 0…H.
"""

from __future__ import annotations

import io
import json

import cv2
import numpy as np
import scipy.io
from shapely.geometry import MultiPolygon, Polygon


def ps2_points(data: bytes) -> np.ndarray:
    """Marking points (N, 2) of a ps2.0 file, in which the first pixel's centre is 1."""
    return scipy.io.loadmat(io.BytesIO(data))["marks"].reshape(-1, 2) - 0.5


def dmpr_points(data: bytes) -> np.ndarray:
    """Marking points (N, 2) of a file of DMPR-PS, in which the first pixel's centre is 1."""
    return np.array([mark[:2] for mark in json.loads(data)["marks"]], float).reshape(-1, 2) - 0.5


def yolo_points(data: bytes, width: int, height: int) -> np.ndarray:
    """Keypoints (N, 2) in the frame of a YOLO pose text, which has shares of width and height."""
    lines = [np.array(line.split()[5:], float).reshape(-1, 3) for line in data.decode().splitlines()]
    points = np.concatenate([np.empty((0, 3)), *lines])
    return points[points[:, 2] > 0, :2] * (width, height)


def coco_points(data: bytes) -> np.ndarray:
    """Keypoints (N, 2) in the frame of what an image adds to a COCO file, in which the first pixel's centre is 0."""
    slots = [entry for entry in json.loads(data)["annotations"] if "keypoints" in entry]
    points = np.array([entry["keypoints"] for entry in slots], float).reshape(-1, 3)
    return points[points[:, 2] > 0, :2] + 0.5


def coco_floors(data: bytes) -> list[MultiPolygon]:
    """Floors of the slots of what an image adds to a COCO file."""
    slots = [entry for entry in json.loads(data)["annotations"] if "keypoints" in entry]
    return [MultiPolygon([Polygon(np.reshape(ring, (-1, 2))) for ring in entry["segmentation"]]) for entry in slots]


def mask(data: bytes) -> np.ndarray:
    """Pixels (H, W) bool that a mask's PNG marks."""
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) > 0
