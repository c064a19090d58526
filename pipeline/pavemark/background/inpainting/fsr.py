"""Frequency-selective reconstruction: the hole as a sum of the waves found around it. Good on regular paving, slow."""

from __future__ import annotations

import cv2
import numpy as np

from pavemark.background.inpainting.source import filled, mirrored, neutral, within_margin

MARGIN = 16
"""Pixels added around the image: xphoto leaves holes black in a last block of rows or columns that is cut short."""


class FSR:
    """Seiler and Kaup (2010), as OpenCV's xphoto has it in its fast setting."""

    name = "fsr"
    version = "1"

    def fill(self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
        """See `Inpainter.fill`."""

        def propose(image: np.ndarray, hole: np.ndarray) -> np.ndarray:
            source = cv2.cvtColor(mirrored(neutral(image, hole, keep_out), MARGIN), cv2.COLOR_RGB2BGR)
            known = mirrored(np.where(hole, 0, 255).astype(np.uint8), MARGIN)
            result = np.empty_like(source)
            cv2.xphoto.inpaint(source, known, result, cv2.xphoto.INPAINT_FSR_FAST)
            return within_margin(cv2.cvtColor(result, cv2.COLOR_BGR2RGB), MARGIN)

        return filled(image, hole, keep_out, propose)
