"""Node groups: a formula built once, when first called for, and used by every material with numbers of its own.

Blender checks a whole tree after each node, link and number, so a material of a hundred nodes takes 25 ms to build, and
one of a handful of groups a few. A person who opens it sees what each is for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import bpy

from pavemark import __version__

from .nodes import Value, feed, node, output

VECTOR = frozenset({"Position"})
"""Inputs that are vectors; all others are numbers."""

VERSION = "pavemark_version"
"""Property of a group: which version has built it."""


def factor(
    tree: bpy.types.ShaderNodeTree,
    name: str,
    inputs: Mapping[str, Value | float],
    formula: Callable[[Mapping[str, Value]], Value],
) -> Value:
    """What a formula makes of some inputs, as a group node in a tree.

    Parameters
    ----------
    name : str
        Names the group; one name stands for one formula.
    inputs : mapping of str to Value or float
        The inputs by name; the same names whenever the group is used.
    formula : callable
        Links nodes from the inputs' sockets to a number.
    """
    title = f"Pavemark {name}"
    group = bpy.data.node_groups.get(title)
    if group is not None and group.get(VERSION) != __version__:
        # A file may hold groups that another version has built.
        group.name = f"{title} of another version"
        group = None
    group = group or _built(title, tuple(inputs), formula)
    used = node(tree, "ShaderNodeGroup", node_tree=group, label=name)
    for socket, value in zip(used.inputs, inputs.values(), strict=True):
        feed(tree, socket, value)
    return output(used)


def _built(name: str, inputs: tuple[str, ...], formula: Callable[[Mapping[str, Value]], Value]):
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree[VERSION] = __version__
    for label in inputs:
        kind = "NodeSocketVector" if label in VECTOR else "NodeSocketFloat"
        tree.interface.new_socket(label, in_out="INPUT", socket_type=kind)
    tree.interface.new_socket("Factor", in_out="OUTPUT", socket_type="NodeSocketFloat")
    entered = tree.nodes.new("NodeGroupInput")
    result = formula({label: Value(tree, entered.outputs[label]) for label in inputs})
    feed(tree, tree.nodes.new("NodeGroupOutput").inputs[0], result)
    return tree
