"""PatchMatch inpainting: the hole is made of patches that occur elsewhere. Texture goes on, without scars."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from pavemark.background.inpainting.source import filled, mirrored, within_margin
from pavemark.errors import InputError

RADIUS = 5
"""Patches are 11×11 pixels, as wide as the joints of paving. Radius 3 is no faster, radius 7 takes twice the time."""

SMALLEST = 96
"""Pixels a side to which a smaller image is mirrored: of its coarsest halved version a hole must leave a source."""

SEED = 0


class PatchMatch:
    """Barnes et al. (2009) with Wexler's coarse-to-fine completion, as PyPatchMatch has it."""

    name = "patchmatch"
    version = "1"

    def fill(self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
        """See `Inpainter.fill`."""

        def propose(image: np.ndarray, hole: np.ndarray) -> np.ndarray:
            margin = max(0, (SMALLEST + 1 - min(hole.shape)) // 2)
            source, wanted, forbidden = (mirrored(array, margin) for array in (image, hole, keep_out))
            patchmatch = _library()
            patchmatch.set_random_seed(SEED)
            result = patchmatch.inpaint(source, wanted, global_mask=forbidden, patch_size=RADIUS)
            return within_margin(result, margin)

        return filled(image, hole, keep_out, propose)


def _library() -> ModuleType:
    # A Blender program's Python may have no wheel of it: the other methods are to work there all the same.
    try:
        import patchmatch  # noqa: PLC0415
    except ImportError:
        raise InputError(
            "inpainter", "patchmatch needs the package PyPatchMatch; fsr and navier-stokes do not"
        ) from None
    return patchmatch
