"""The labels drawn over the image in the Image Editor: marking points, entrance lines, numbers of slots."""

from __future__ import annotations

import attrs
import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from pavemark.labels.truth import Truth, truth

from . import document, shot

T_COLOUR, L_COLOUR = (1.0, 0.25, 0.2, 1.0), (0.25, 0.55, 1.0, 1.0)
"""Red T, blue L, as in the contact sheets."""

LINE_COLOUR = (0.1, 0.95, 0.35, 1.0)
ARM = 14.0
"""Image pixels of the stroke that tells a marking point's direction."""


@attrs.frozen(eq=False)
class Marks:
    """What is drawn, in shares of the image's width and height, from its lower left corner.

    Attributes
    ----------
    entrances : ndarray (N, 2, 2)
        Entrance lines of the slots with both marking points visible.
    points : tuple of (str, ndarray (2, 2))
        Shape of each visible marking point, where it lies and where its stroke ends.
    numbers : tuple of (str, ndarray (2,))
        Number of each slot that is seen, from 1, and the middle of what is seen of it.
    """

    entrances: np.ndarray
    points: tuple[tuple[str, np.ndarray], ...]
    numbers: tuple[tuple[str, np.ndarray], ...]


def marks(true: Truth) -> Marks:
    """What is to be drawn over an image."""
    size = np.array((true.frame.width, true.frame.height))

    def shares(points) -> np.ndarray:
        return np.abs(np.array((0.0, 1.0)) - np.asarray(points, np.float64) / size)

    entrances = [slot.corners[:2] for slot in true.slots if slot.paired]
    points = tuple(
        (mark.shape, shares((mark.point, np.array(mark.point) + ARM * np.array(mark.direction))))
        for mark in true.marks
        if mark.visible
    )
    numbers = tuple(
        (str(number), shares(slot.region.representative_point().coords[0]))
        for number, slot in enumerate(true.slots, 1)
        if slot.seen
    )
    return Marks(shares(entrances).reshape(-1, 2, 2), points, numbers)


_of: dict[str, tuple[tuple[str, str], Marks]] = {}


def remember(target: bpy.types.Scene) -> None:
    """Keep what is to be drawn over the image that was just rendered of a scene."""
    scene, plate = document.known(target), document.clean(target)
    _of[target.name] = (scene.plate.sha256, target.pavemark.document), marks(truth(scene, plate.ground))


def remembered(target: bpy.types.Scene) -> Marks | None:
    """The labels of the rendered image; None before the first."""
    return _of[target.name][1] if target.name in _of else None


def _draw() -> None:
    context = bpy.context
    space, target = context.space_data, context.scene
    if space.image is None or space.image.name != shot.IMAGE or not target.pavemark.overlay:
        return
    drawn = remembered(target)
    if drawn is None:
        return
    view = context.region.view2d

    def at(point) -> tuple[float, float]:
        return view.view_to_region(float(point[0]), float(point[1]), clip=False)

    gpu.state.blend_set("ALPHA")
    _lines([at(point) for line in drawn.entrances for point in line], LINE_COLOUR, 2.0)
    for shape, colour in (("T", T_COLOUR), ("L", L_COLOUR)):
        arms = [[at(point) for point in line] for mark, line in drawn.points if mark == shape]
        _lines([point for arm in arms for point in arm], colour, 3.0)
        _squares([arm[0] for arm in arms], colour)
    gpu.state.blend_set("NONE")
    font = 0
    blf.size(font, 16 * context.preferences.system.ui_scale)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 1.0)
    blf.color(font, 1.0, 1.0, 1.0, 1.0)
    for number, place in drawn.numbers:
        width, height = blf.dimensions(font, number)
        x, y = at(place)
        blf.position(font, x - width / 2, y - height / 2, 0)
        blf.draw(font, number)
    blf.disable(font, blf.SHADOW)


def _lines(points: list, colour: tuple, width: float) -> None:
    if not points:
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", colour)
    batch_for_shader(shader, "LINES", {"pos": [(x, y, 0.0) for x, y in points]}).draw(shader)


def _squares(points: list, colour: tuple) -> None:
    shader, half = gpu.shader.from_builtin("UNIFORM_COLOR"), 4.0
    corners = [
        (x + dx * half, y + dy * half, 0.0)
        for x, y in points
        for dx, dy in ((-1, -1), (1, -1), (1, 1), (-1, -1), (1, 1), (-1, 1))
    ]
    shader.uniform_float("color", colour)
    if corners:
        batch_for_shader(shader, "TRIS", {"pos": corners}).draw(shader)


_handle: list[object] = []


def register() -> None:
    """Draw it from now on."""
    _handle.append(bpy.types.SpaceImageEditor.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw it no more."""
    while _handle:
        bpy.types.SpaceImageEditor.draw_handler_remove(_handle.pop(), "WINDOW")
    _of.clear()
