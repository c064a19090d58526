"""Navier-Stokes inpainting: isophotes carried on into the hole. Fast, smooth, without texture."""

from __future__ import annotations

import cv2
import numpy as np

from pavemark.background.inpainting.source import filled, neutral

RADIUS = 3
"""Pixels looked at around each point."""


class NavierStokes:
    """Bertalmío, Bertozzi and Sapiro (2001), as OpenCV has it."""

    name = "navier-stokes"
    version = "1"

    def fill(self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
        """See `Inpainter.fill`."""

        def propose(image: np.ndarray, hole: np.ndarray) -> np.ndarray:
            return cv2.inpaint(neutral(image, hole, keep_out), hole.astype(np.uint8), RADIUS, cv2.INPAINT_NS)

        return filled(image, hole, keep_out, propose)
