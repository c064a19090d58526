"""Detectors as ONNX files, with all that another program has to know of them inside."""

from __future__ import annotations

import io

import onnx
import torch
from torch import nn

from pavemark.training.detectors.network import STRIDE, Points

OPSET = 17

LICENCE = "GPL-3.0-or-later"

AXES = {
    "image": {0: "images", 2: "height", 3: "width"},
    "grid": {0: "images", 2: "rows", 3: "columns"},
    "embedding": {0: "images"},
    "points": {0: "images"},
    "pairs": {0: "images"},
}
"""Sides that are free."""


class _Whole(nn.Module):
    """The network with what belongs to it: shares and probabilities rather than logits."""

    def __init__(self, network: Points) -> None:
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> tuple[torch.Tensor, ...]:
        return tuple(self.network.outputs(image).values())


def exported(
    network: Points, pixels_per_metre: float, made: str, trained_on: str = "", licence: str = LICENCE
) -> bytes:
    """The network as an ONNX file.

    Parameters
    ----------
    network : Points
        Of any family. It is left ready to look, not to learn.
    pixels_per_metre : float
        Scale of what it learnt from.
    made : str
        The command that made it.
    trained_on : str
        What it learnt from.
    licence : str
        SPDX.

    Returns
    -------
    bytes
        A graph `image` (N, 3, H, W), display RGB, 0 to 1, H and W whole STRIDEs, to `grid` (N, 6, H/STRIDE, W/STRIDE),
        `embedding` (N, E) and, where the family finds pairs itself, `points` (N, K, 3) and `pairs` (N, K, K).
    """
    stream = io.BytesIO()
    whole = _Whole(network).eval()
    example = torch.zeros(1, 3, 6 * STRIDE, 8 * STRIDE)
    with torch.no_grad():
        names, shown = zip(*network.outputs(example).items(), strict=True)
    torch.onnx.export(
        whole,
        (example,),
        stream,
        input_names=["image"],
        output_names=list(names),
        dynamic_axes={name: AXES[name] for name in ("image", *names)},
        opset_version=OPSET,
        dynamo=False,
    )
    model = onnx.load_from_string(stream.getvalue())
    # The exporter does not always find out which sides are fixed.
    for port, told in zip(model.graph.output, shown, strict=True):
        for k, side in enumerate(told.shape):
            if k not in AXES[port.name]:
                port.type.tensor_type.shape.dim[k].dim_value = side
    onnx.helper.set_model_props(
        model,
        {
            "pavemark": "detector 1",
            "family": network.family,
            "pixels_per_metre": f"{pixels_per_metre:g}",
            "stride": str(STRIDE),
            "made": made,
            "licence": licence,
            "trained_on": trained_on,
        },
    )
    onnx.checker.check_model(model)
    return model.SerializeToString()
