"""Filling the ground where markings were: one protocol, a backend a file."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pavemark.background import models
from pavemark.background.inpainting.fsr import FSR
from pavemark.background.inpainting.learned import Learned
from pavemark.background.inpainting.navier_stokes import NavierStokes
from pavemark.background.inpainting.patch_match import PatchMatch
from pavemark.errors import InputError


class Inpainter(Protocol):
    """Fills holes in an image from what surrounds them. The same input gives the same output."""

    name: str
    """As the job file names it, with whatever parameter the result depends on held fixed under that name."""

    version: str
    """Changes with all that the result depends on besides the input, but for the libraries of the cache's shelf."""

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


def choices() -> tuple[str, ...]:
    """Names of all inpainters: the classical ones, our own network, and the models that were recorded."""
    return (*METHODS, models.SHIPPED, *models.names())


def inpainter(name: str) -> Inpainter:
    """The inpainter of that name.

    Raises
    ------
    InputError
        Naming those there are, or when the file of a model has gone or changed.
    """
    if name in METHODS:
        return METHODS[name]
    if name not in choices():
        raise InputError(f"inpainter = {name!r}", f"allowed {', '.join(choices())}")
    model = models.shipped() if name == models.SHIPPED else models.read(name)
    models.verify(model)
    return Learned(model)
