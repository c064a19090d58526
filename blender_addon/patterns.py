"""Regular patterns in paint, each a function of pattern coordinates (u, v), one unit a period.

They return 0 in the pattern's bright and 1 in its dark parts. `blur` is a pixel's size in periods: edges are softened
over it, and a pattern finer than two pixels turns into its mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from .nodes import Value, clamp, node, output, vector


def _edge(distance: Value, blur: Value) -> Value:
    """1 where `distance` (in periods, negative inside) is inside, averaged over a pixel."""
    return clamp(0.5 - distance / blur)


def _triangle(u: Value) -> Value:
    """Distance from the nearest whole number, 0 … 0.5."""
    return abs((u + 0.5) % 1.0 - 0.5)


def stripes(u: Value, v: Value, blur: Value) -> Value:
    """Bands as wide as their gaps."""
    return _edge(_triangle(u) - 0.25, blur)


def checks(u: Value, v: Value, blur: Value) -> Value:
    """A chess board."""
    a, b = stripes(u, v, blur), stripes(v, u, blur)
    return a + b - a * b * 2.0


def dots(u: Value, v: Value, blur: Value) -> Value:
    """Round dots on a square lattice."""
    a, b = _triangle(u), _triangle(v)
    return _edge((a * a + b * b).math("SQRT") - 0.3, blur)


def waves(u: Value, v: Value, blur: Value) -> Value:
    """Wavy bands."""
    return stripes(u + (v * (2 * math.pi)).math("SINE") * 0.2, v, blur)


def bricks(u: Value, v: Value, blur: Value) -> Value:
    """Mortar joints of a running bond, bricks two to one."""
    row = (v * 2.0).math("FLOOR")
    joint_across = _triangle(v * 2.0) * 0.5
    joint_along = _triangle(u + row * 0.5)
    return _edge(joint_across.math("MINIMUM", joint_along) - 0.05, blur)


def rings(u: Value, v: Value, blur: Value) -> Value:
    """Circles around lattice points six periods apart."""
    a, b = _triangle(u / 6.0) * 6.0, _triangle(v / 6.0) * 6.0
    return _edge(_triangle((a * a + b * b).math("SQRT")) - 0.2, blur)


def cells(u: Value, v: Value, blur: Value) -> Value:
    """Borders of irregular cells."""
    made = node(u.tree, "ShaderNodeTexVoronoi", {"Vector": vector(u, v, u.tree), "Scale": 1.0}, voronoi_dimensions="2D")
    made.feature = "DISTANCE_TO_EDGE"
    return _edge(output(made, "Distance") - 0.06, blur)


def weave(u: Value, v: Value, blur: Value) -> Value:
    """Gaps of a basket weave: over and under in turn."""
    over = checks(u * 0.5, v * 0.5, blur * 0.5)
    along, across = _edge(0.4 - _triangle(u), blur), _edge(0.4 - _triangle(v), blur)
    return along * over + across * (1.0 - over)


PATTERNS: dict[str, Callable[[Value, Value, Value], Value]] = {
    "stripes": stripes,
    "checks": checks,
    "dots": dots,
    "waves": waves,
    "bricks": bricks,
    "rings": rings,
    "cells": cells,
    "weave": weave,
}
