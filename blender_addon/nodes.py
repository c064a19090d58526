"""Shader nodes written as arithmetic.

A Value is an output socket; adding, multiplying or comparing values links math nodes, so that a paint reads like its
formula.
"""

from __future__ import annotations

import bpy


class Value:
    """An output socket, with arithmetic; numbers mix in freely."""

    def __init__(self, tree: bpy.types.ShaderNodeTree, socket: bpy.types.NodeSocket) -> None:
        self.tree = tree
        self.socket = socket

    def math(self, operation: str, *others: Value | float) -> Value:
        """The result of a math node on this value and others."""
        return _math(self.tree, operation, self, *others)

    def __add__(self, other: Value | float) -> Value:
        return self.math("ADD", other)

    def __sub__(self, other: Value | float) -> Value:
        return self.math("SUBTRACT", other)

    def __rsub__(self, other: float) -> Value:
        return _math(self.tree, "SUBTRACT", other, self)

    def __mul__(self, other: Value | float) -> Value:
        return self.math("MULTIPLY", other)

    def __truediv__(self, other: Value | float) -> Value:
        return self.math("DIVIDE", other)

    def __rtruediv__(self, other: float) -> Value:
        return _math(self.tree, "DIVIDE", other, self)

    def __mod__(self, other: Value | float) -> Value:
        return self.math("FLOORED_MODULO", other)

    def __lt__(self, other: Value | float) -> Value:
        return self.math("LESS_THAN", other)

    def __abs__(self) -> Value:
        return self.math("ABSOLUTE")

    __radd__ = __add__
    __rmul__ = __mul__


def _math(tree: bpy.types.ShaderNodeTree, operation: str, *values: Value | float) -> Value:
    made = tree.nodes.new("ShaderNodeMath")
    made.operation = operation
    for socket, value in zip(made.inputs, values, strict=False):
        feed(tree, socket, value)
    return Value(tree, made.outputs[0])


def feed(tree: bpy.types.ShaderNodeTree, socket: bpy.types.NodeSocket, value: object) -> None:
    """Link a value to an input, or set the input to a number or tuple."""
    if isinstance(value, Value):
        tree.links.new(value.socket, socket)
    else:
        socket.default_value = value


def node(
    tree: bpy.types.ShaderNodeTree, kind: str, inputs: dict[str | int, object] | None = None, **settings: object
) -> bpy.types.Node:
    """A node with its settings and its inputs (by name or number) in place."""
    made = tree.nodes.new(kind)
    for name, value in settings.items():
        setattr(made, name, value)
    for name, value in (inputs or {}).items():
        feed(tree, made.inputs[name], value)
    return made


def output(made: bpy.types.Node, name: str | int = 0) -> Value:
    """One of a node's outputs."""
    return Value(made.id_data, made.outputs[name])


def where(tree: bpy.types.ShaderNodeTree) -> Value:
    """The world position that is shaded, metres."""
    return output(node(tree, "ShaderNodeNewGeometry"), "Position")


def components(position: Value) -> tuple[Value, Value]:
    """X and Y of a vector."""
    made = node(position.tree, "ShaderNodeSeparateXYZ", {"Vector": position})
    return output(made, "X"), output(made, "Y")


def vector(x: Value | float, y: Value | float, tree: bpy.types.ShaderNodeTree) -> Value:
    """A vector in the ground plane."""
    return output(node(tree, "ShaderNodeCombineXYZ", {"X": x, "Y": y}))


def clamp(value: Value, low: Value | float = 0.0, high: Value | float = 1.0) -> Value:
    """Limited to low … high."""
    return value.math("MAXIMUM", low).math("MINIMUM", high)


def ramp(value: Value, low: Value | float, high: Value | float) -> Value:
    """0 below `low`, 1 above `high`, smooth between."""
    return _mapped(value, low, high, "SMOOTHSTEP")


def smooth(value: Value, low: Value | float, high: Value | float) -> Value:
    """As `ramp`, with a curve that also begins and ends without curvature."""
    return _mapped(value, low, high, "SMOOTHERSTEP")


def _mapped(value: Value, low: Value | float, high: Value | float, curve: str) -> Value:
    inputs = {"Value": value, "From Min": low, "From Max": high}
    return output(node(value.tree, "ShaderNodeMapRange", inputs, interpolation_type=curve), "Result")
