"""Small ONNX graphs with the inputs and outputs of detectors, which say what they are shown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from onnx import TensorProto, helper, numpy_helper

STRIDE = 16

METADATA = {"pavemark": "detector 1", "family": "dmpr", "pixels_per_metre": "20", "stride": str(STRIDE)}


def graph(
    path: Path,
    *,
    direction=(0.0, -2.0),
    l_shaped=0.0,
    times=1.0,
    points=None,
    pairs=None,
    without=(),
    renamed=("", ""),
    channels=3,
    free=False,
    second_input=False,
    kind=TensorProto.FLOAT,
    said=None,
) -> Path:
    """Write a detector that reads confidence and place in a cell from the cell's mean red, green and blue.

    Parameters
    ----------
    path : Path
    direction, l_shaped
        What is said of every cell.
    times : float
        What the colours are multiplied by.
    points, pairs : array or None
        What the further outputs always say.
    without : names of outputs that are missing
    renamed : (old, new)
        An output or input that is called something else.
    channels : int
        Of the input.
    free : bool
        Whether nothing tells how long the embedding is.
    said : dict
        Changes to METADATA; None takes a line away.
    """
    constants, nodes = [], []

    def constant(name, value):
        constants.append(numpy_helper.from_array(np.asarray(value, np.float32), name))
        return name

    def node(operator, inputs, result, **attributes):
        nodes.append(helper.make_node(operator, inputs, [result], **attributes))

    image = "image" if kind == TensorProto.FLOAT else "cast"
    if image == "cast":
        node("Cast", ["image"], "cast", to=TensorProto.FLOAT)
    node("AveragePool", [image], "means", kernel_shape=[STRIDE, STRIDE], strides=[STRIDE, STRIDE])
    node("Mul", ["means", constant("times", times)], "shares")
    # As large as the grid, whatever that is.
    node("ReduceMean", ["means"], "mean", axes=[1])
    node("Mul", ["mean", constant("zero", 0)], "nothing")
    for name, value in (("cos", direction[0]), ("sin", direction[1]), ("l", l_shaped)):
        node("Add", ["nothing", constant(f"{name}_value", value)], name)
    node("Concat", ["shares", "cos", "sin", "l"], "grid", axis=1)
    node("ReduceMean", [image], "colours", axes=[2, 3], keepdims=0)
    if free:
        # How many are left over is not to be told from the graph.
        constants.append(numpy_helper.from_array(np.ones(channels, bool), "all"))
        node("Compress", ["colours", "all"], "embedding", axis=1)
    else:
        node("Identity", ["colours"], "embedding")
    outputs = {"grid": [None, 6, None, None], "embedding": [None, channels]}
    for name, value in (("points", points), ("pairs", pairs)):
        if value is not None:
            node("Identity", [constant(f"{name}_value", value)], name)
            outputs[name] = list(np.shape(value))
    inputs = [helper.make_tensor_value_info("image", kind, [None, channels, None, None])]
    if second_input:
        inputs.append(helper.make_tensor_value_info("mask", TensorProto.FLOAT, [1]))
    shown = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, [None] * 2 if free and name == "embedding" else sides)
        for name, sides in outputs.items()
        if name not in without
    ]
    old, new = renamed
    for one in nodes:
        for names in (one.input, one.output):
            for k, name in enumerate(names):
                if name == old:
                    names[k] = new
    for one in (*inputs, *shown):
        if one.name == old:
            one.name = new
    model = helper.make_model(
        helper.make_graph(nodes, "g", inputs, shown, constants),
        opset_imports=[helper.make_opsetid("", 17)],
        ir_version=8,
    )
    told = {name: value for name, value in {**METADATA, **(said or {})}.items() if value is not None}
    helper.set_model_props(model, told)
    path.write_bytes(model.SerializeToString())
    return path


def painted(size, cells):
    """A black picture (width, height) with some cells of a colour: {(row, column): (confidence, x, y)}."""
    image = np.zeros((size[1], size[0], 3), np.uint8)
    for (row, column), shares in cells.items():
        image[row * STRIDE : (row + 1) * STRIDE, column * STRIDE : (column + 1) * STRIDE] = np.rint(
            255 * np.array(shares)
        )
    return image
