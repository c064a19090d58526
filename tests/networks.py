"""Small ONNX graphs with the inputs and outputs of great inpainting networks, and fills that are known beforehand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from onnx import TensorProto, helper, numpy_helper

COLOUR = (0.8, 0.4, 0.2)
"""R, G, B of a constant fill."""


def network(
    path: Path,
    *,
    output="output",
    side=None,
    white=1.0,
    fill=COLOUR,
    byte=False,
    hole_is=1.0,
    outside="image",
    halved=False,
    bgr=False,
    shape=None,
    batch="n",
) -> Path:
    """Write a graph that gives back what it is shown, and fills what it is not shown.

    Parameters
    ----------
    path : Path
    output : str
        Name of the output.
    side : int or None
        Height and width; None leaves them free.
    white : float
        White in the output.
    fill : tuple of float, "mean", "across" or "shown"
        R, G, B; the mean of the known pixels; the column's number, counted from 1, in thousandths; what lies under
        the hole.
    byte : bool
        uint8 in and out, and a mask of 0 and 255.
    hole_is : float
        Value of the mask in a hole, 0 or 1 (255).
    outside : "image" or "fill"
        What is outside the hole.
    bgr : bool
        The output's channels are the other way round.
    halved : bool
        The output has half the height and width.
    shape : tuple or None
        Shape of the inputs `image` and `mask` but for their channels, NCHW unless told otherwise.
    """
    constants, nodes = {}, []

    def constant(name, value):
        constants[name] = numpy_helper.from_array(np.asarray(value, np.float32), name)

    def node(kind, inputs, result, **attributes):
        nodes.append(helper.make_node(kind, inputs, [result], **attributes))

    for name, value in {"zero": 0, "one": 1, "byte": 255, "white": white}.items():
        constant(name, value)
    kind = TensorProto.UINT8 if byte else TensorProto.FLOAT
    if byte:
        for name in ("image", "mask"):
            node("Cast", [name], f"{name}_f", to=TensorProto.FLOAT)
            node("Div", [f"{name}_f", "byte"], f"{name}_1")
    image, mask = ("image_1", "mask_1") if byte else ("image", "mask")
    if hole_is == 0:
        node("Sub", ["one", mask], "hole")
    else:
        node("Identity", [mask], "hole")
    node("Sub", ["one", "hole"], "known")
    node("Mul", [image, "known"], "seen")
    if fill == "shown":
        node("Identity", [image], "fill")
    elif fill == "mean":
        node("ReduceMean", ["seen"], "sum", axes=[2, 3])
        node("ReduceMean", ["known"], "count", axes=[2, 3])
        node("Div", ["sum", "count"], "fill")
    elif fill == "across":
        constants["axis"] = numpy_helper.from_array(np.asarray(3, np.int64), "axis")
        constant("thousandth", 1 / 1000)
        node("Mul", ["hole", "zero"], "nothing")
        node("Add", ["nothing", "thousandth"], "steps")
        node("CumSum", ["steps", "axis"], "fill")
    else:
        constant("fill", np.reshape(fill, (1, 3, 1, 1)))
    node("Mul", ["fill", "hole"], "filled_hole")
    if outside == "fill":
        node("Mul", [image, "zero"], "black")
        node("Add", ["black", "fill"], "whole")
    else:
        node("Add", ["seen", "filled_hole"], "whole")
    if bgr:
        constants["order"] = numpy_helper.from_array(np.array([2, 1, 0]), "order")
        node("Gather", ["whole", "order"], "turned", axis=1)
    if halved:
        node("AveragePool", ["whole"], "half_size", kernel_shape=[2, 2], strides=[2, 2])
    node("Mul", ["half_size" if halved else "turned" if bgr else "whole", "white"], "scaled")
    if byte:
        constant("half", 0.5)
        node("Add", ["scaled", "half"], "rounded")
        node("Cast", ["rounded"], output, to=kind)
    else:
        node("Identity", ["scaled"], output)
    size = [batch, None, side or "height", side or "width"] if shape is None else shape
    inputs = [
        helper.make_tensor_value_info(name, kind, [channels if one is None else one for one in size])
        for name, channels in (("image", 3), ("mask", 1))
    ]
    graph = helper.make_graph(
        nodes, "g", inputs, [helper.make_tensor_value_info(output, kind, None)], list(constants.values())
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path.write_bytes(model.SerializeToString())
    return path


KINDS = {
    "lama-512": {"side": 512, "white": 255.0},
    "lama-dynamic": {"white": 1.0},
    "migan": {"output": "result", "white": 255.0, "byte": True, "hole_is": 0.0},
    "pavemark": {"output": "filled", "white": 1.0, "batch": 1},
}
"""What `network` needs to be told for each contract."""
