"""The plate: a real image cleaned of its markings, with what is known of its ground."""

from __future__ import annotations

import hashlib
import json
from functools import cached_property

import attrs
import numpy as np

from pavemark.ground import Frame
from pavemark.records import unstructure
from pavemark.scene import RGB, PlateRef


@attrs.frozen
class Roadside:
    """How the roadside runs in a picture: the line along which slots lie side by side, or across which they do.

    Attributes
    ----------
    direction : float
        Radians anticlockwise from the world's X, π/4 to 3π/4: the one of the two directions, a quarter turn apart and
        alike by their evidence, that is nearer to the car's way (Y).
    left, right : float or None
        Metres from the frame's centre, along the normal to the left of the direction, to the line where the
        roadside begins to either side of the car; None where none is found.
    confidence : float
        0 to 1: share of the straight edges that agree.
    """

    direction: float
    left: float | None
    right: float | None
    confidence: float


@attrs.define(frozen=True, eq=False, slots=False)
class Plate:
    """A clean background.

    Attributes
    ----------
    name : str
        Stem of the image it was made from.
    frame : Frame
    image : ndarray (H, W, 3) uint8
        Display sRGB, channels R, G, B. Pixels that are not ground are those of the input image.
    ground : ndarray (H, W) bool
        Where paint may lie: not the ego car, not what the mask calls not-ground.
    markings : ndarray (H, W) bool
        Where the input image had markings.
    source : ndarray (H, W, 3) uint8
        The input image, for the preview and for re-painting its own markings.
    ratios : tuple of RGB
        Reflectance ratios, as `pavemark.scene.Paint.ratio`, of the former markings to the ground beside them; empty
        when the image had none.
    roadside : Roadside or None
        None where nothing certain is known of it.
    blur : tuple of tuple of float, or None
        The input image's own blur, as `pavemark.scene.Optics.blur`, where it was measured before; None where `source`
        is to be asked.
    """

    name: str
    frame: Frame
    image: np.ndarray
    ground: np.ndarray
    markings: np.ndarray
    source: np.ndarray
    ratios: tuple[RGB, ...] = ()
    roadside: Roadside | None = None
    blur: tuple[tuple[float, ...], ...] | None = None

    @cached_property
    def sha256(self) -> str:
        """Hash of all that an image made from this plate depends on."""
        digest = hashlib.sha256(json.dumps(unstructure(self.frame), sort_keys=True).encode())
        for array in (self.image, np.packbits(self.ground)):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    @property
    def ref(self) -> PlateRef:
        """The plate as a scene names it."""
        return PlateRef(self.name, self.sha256, self.frame)
