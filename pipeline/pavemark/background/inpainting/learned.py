"""Inpainting by a network in an ONNX file: LaMa, MI-GAN, our own."""

from __future__ import annotations

import importlib.metadata
from functools import partial

import attrs
import numpy as np

from pavemark.background.contracts import CONTRACTS
from pavemark.background.inpainting.crops import filled_in_crops
from pavemark.background.inpainting.source import filled, neutral
from pavemark.background.models import Model, checked

VERSION = 1
"""Counted up with every change that makes other fills of the same network."""


@attrs.frozen
class Learned:
    """The network of a model.

    Attributes
    ----------
    model : Model
        Its file is checked and opened when there is something to fill.
    """

    model: Model

    @property
    def name(self) -> str:
        """See `Inpainter.name`."""
        return self.model.name

    @property
    def version(self) -> str:
        """See `Inpainter.version`."""
        try:
            runtime = importlib.metadata.version("onnxruntime")
        except importlib.metadata.PackageNotFoundError:
            runtime = ""
        return f"{VERSION} {self.model.contract} {self.model.sha256} white {self.model.white:g} onnxruntime {runtime}"

    def fill(self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
        """See `Inpainter.fill`.

        Raises
        ------
        ValueError
            When there is something to fill and no pixel to fill it from, in a whole crop or at all.
        InputError
            When the model's file has gone or changed, or what it gives is of no use.
        """

        def propose(image: np.ndarray, hole: np.ndarray) -> np.ndarray:
            contract = CONTRACTS[self.model.contract]
            fill = partial(contract.fill, checked(self.model), self.model.white)
            # No paint is shown, not even under the hole.
            return filled_in_crops(neutral(image, hole, hole | keep_out), hole, contract.crop, fill)

        return filled(image, hole, keep_out, propose)
