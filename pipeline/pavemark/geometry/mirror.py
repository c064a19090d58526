"""What level ground mirrors into the cameras of the car."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pavemark.light import Place

SEAM = 0.5
"""Metres by which one camera may be nearer than another where a stitched picture still mixes what the two saw."""


def seen_by(points: np.ndarray, eyes: Sequence[Place]) -> np.ndarray:
    """Shares (P, E) in which a stitched picture shows points of the ground as each camera saw them.

    Parameters
    ----------
    points : ndarray (P, 2)
        Metres.
    eyes : sequence of (X, Y, Z)
        The cameras, metres. A point is seen by the nearest, and near a seam by others too.
    """
    away = np.stack([np.hypot(*(points - eye[:2]).T) for eye in eyes], -1)
    share = np.maximum(1 - (away - away.min(-1, keepdims=True)) / SEAM, 0.0)
    return share / share.sum(-1, keepdims=True)


def mirrored(points: np.ndarray, eyes: np.ndarray) -> np.ndarray:
    """Where points of the ground, were it a mirror, show an eye what is there.

    Parameters
    ----------
    points : ndarray (P, 2)
        Metres.
    eyes : ndarray (3,) or (P, 3)
        One eye, or one for each point; metres.

    Returns
    -------
    ndarray (P, 3)
        Unit vectors in world axes, upwards from the ground. Z is the cosine of the angle of incidence.
    """
    eyes = np.broadcast_to(eyes, (len(points), 3))
    ray = np.concatenate([points - eyes[:, :2], eyes[:, 2:]], -1)
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def schlick(cosine: np.ndarray, straight: float) -> np.ndarray:
    """Share of the light that is mirrored at an angle of incidence of that cosine (Schlick, 1994).

    Parameters
    ----------
    cosine : ndarray
    straight : float
        Share that is mirrored straight back.
    """
    return straight + (1 - straight) * (1 - cosine) ** 5
