"""Filling the ground where markings were: one protocol, a backend a file."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pavemark.background.inpainting.fsr import FSR
from pavemark.background.inpainting.navier_stokes import NavierStokes
from pavemark.background.inpainting.patch_match import PatchMatch
from pavemark.errors import InputError


class Inpainter(Protocol):
    """Fills holes in an image from what surrounds them. The same input gives the same output."""

    name: str
    """As the job file names it, with whatever parameter the result depends on held fixed under that name."""

    def fill(self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
        """Fill the hole.

        Parameters
        ----------
        image : ndarray (H, W, 3) uint8
            Display sRGB, channels R, G, B; any size from 1×1.
        hole : ndarray (H, W) bool
            What is to be filled.
        keep_out : ndarray (H, W) bool
            What is neither changed nor looked at: the ego car and other things that are not ground.

        Returns
        -------
        ndarray (H, W, 3) uint8
            A new array that differs from the image in pixels of `hole & ~keep_out` only.

        Raises
        ------
        ValueError
            When there is something to fill and no pixel to fill it from.
        """
        ...


METHODS: dict[str, Inpainter] = {method.name: method for method in (PatchMatch(), FSR(), NavierStokes())}
"""The classical inpainters by name."""


def inpainter(name: str) -> Inpainter:
    """The inpainter of that name.

    Raises
    ------
    InputError
        Naming those there are.
    """
    try:
        return METHODS[name]
    except KeyError:
        raise InputError("inpainter", f"{name!r}: allowed {', '.join(METHODS)}") from None
