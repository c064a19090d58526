"""The stage: a scene of Pavemark as objects of Blender. The add-on and render.py share it."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from pavemark.colour import to_linear
from pavemark.geometry.outline import outline
from pavemark.geometry.sheet import COVERAGE, sheet
from pavemark.ground import Frame
from pavemark.plan import Plan
from pavemark.plate import Plate
from pavemark.scene import Marking, Paint, Scene

from . import curves, decals, paint, sheets, versions
from .nodes import node, output
from .settings import Window

CAMERA_HEIGHT = 10.0


class Stage:
    """The objects of one scene, in a collection of their own.

    Parameters
    ----------
    target : bpy.types.Scene
        Blender's scene that the collection is linked to; its camera is set.
    name : str
        Of the collection.

    Attributes
    ----------
    made : tuple of bpy.types.ID
        All that is on the stage.
    """

    def __init__(self, target: bpy.types.Scene, name: str = "Pavemark") -> None:
        self.target = target
        self.collection = bpy.data.collections.new(name)
        target.collection.children.link(self.collection)
        self._data: list[bpy.types.ID] = []

    @property
    def made(self) -> tuple[bpy.types.ID, ...]:
        return (self.collection, *self._data)

    def camera(self, frame: Frame) -> None:
        """An orthographic camera that sees exactly the frame."""
        camera = bpy.data.cameras.new("Pavemark")
        camera.type = "ORTHO"
        camera.sensor_fit = "HORIZONTAL"
        camera.ortho_scale = frame.size[0]
        camera.clip_end = 2 * CAMERA_HEIGHT
        seen = self.add("Pavemark camera", camera)
        seen.location = (0.0, 0.0, CAMERA_HEIGHT)
        self.target.camera = seen

    def ground(self, plate: Plate) -> None:
        """The plate on the ground plane, at true size, showing its own colours."""
        frame = plate.frame
        linear = np.ones((frame.height, frame.width, 4), np.float32)
        linear[..., :3] = to_linear(plate.image)
        texture = self.keep(sheets.load("Pavemark plate", linear, frame).image)
        material, tree = versions.material("Pavemark ground")
        self.keep(material)
        coordinates = node(tree, "ShaderNodeTexCoord")
        picture = node(
            tree, "ShaderNodeTexImage", {"Vector": output(coordinates, "Generated")}, interpolation="Closest"
        )
        picture.image = texture
        emission = node(tree, "ShaderNodeEmission", {"Color": output(picture, "Color")})
        node(tree, "ShaderNodeOutputMaterial", {"Surface": output(emission)})
        self.floor(frame, material)

    def floor(self, frame: Frame, material: bpy.types.Material) -> None:
        """The ground plane of a frame."""
        mesh = _plane(frame)
        mesh.materials.append(material)
        self.add("Pavemark ground", mesh)

    def lit_by(self, name: str, source: tuple[bpy.types.Light, Matrix]) -> None:
        """A light where it belongs."""
        light, placed = source
        self.add(name, light).matrix_world = placed

    def markings(self, scene: Scene, plan: Plan, hard: bool) -> Window | None:
        """Every marking as curves to edit and a decal that shows them; see `curves` and `decals`."""
        for number, marking in enumerate(scene.markings):
            self.curves(number, marking)
        return self.decals(scene, plan, hard)

    def curves(self, number: int, marking: Marking) -> tuple[bpy.types.Object, ...]:
        """A marking as curves, on the height of its decal: its strokes, its areas, whichever it has."""
        made = []
        for make, parts in ((curves.strokes, marking.strokes), (curves.areas, marking.areas)):
            if parts:
                shown = self.add(_name(number, marking), make(_name(number, marking), marking, _height(number)))
                shown.hide_render = True
                made.append(shown)
        return tuple(made)

    def decals(self, scene: Scene, plan: Plan, hard: bool) -> Window | None:
        """Every marking as a decal, later ones above earlier ones.

        Parameters
        ----------
        hard : bool
            Whether rays find the edges; see `pavemark.plan.Pass.hard`.

        Returns
        -------
        Window or None
            The pixels with any decal; None when no decal touches the frame.
        """
        painted = np.zeros((scene.plate.frame.height, scene.plate.frame.width), bool)
        for number, marking in enumerate(scene.markings):
            painted |= self._decal(marking, scene, plan.colour, plan.nodes[number], hard, number)
        rows, columns = (np.flatnonzero(painted.any(axis)) for axis in (1, 0))
        if not len(rows):
            return None
        return Window(int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1)

    def clear(self) -> None:
        """Remove all that this stage has made."""
        bpy.data.batch_remove(self._data)
        bpy.data.collections.remove(self.collection)

    def _decal(
        self, marking: Marking, scene: Scene, colour: str, effects: tuple[str, ...], hard: bool, number: int
    ) -> np.ndarray:
        frame, name, height = scene.plate.frame, _name(number, marking), _height(number)
        shape = outline(marking, scene.curvature)
        values = sheet(shape, frame, scene.tyres if {"wear", "dirt"} & set(effects) else None, "wear" in effects)
        painted = values[..., COVERAGE] > 0
        if hard:
            mesh = decals.hard(name, shape, frame, height)
            values[..., COVERAGE] = 1.0
        else:
            mesh = decals.pixels(name, values[..., COVERAGE], frame, height)
        image = sheets.load(name, values, frame)
        self.keep(image.image)
        shown = marking.paint.ratio if colour == "ratio" else _emitted(marking.paint)
        mesh.materials.append(self.keep(paint.material(name, marking.paint, shown, effects, image)))
        self.add(name, mesh)
        return painted

    def add(self, name: str, data: bpy.types.ID) -> bpy.types.Object:
        """An object of that data, which this stage will remove."""
        made = bpy.data.objects.new(name, self.keep(data))
        self.collection.objects.link(self.keep(made))
        return made

    def keep(self, data: bpy.types.ID) -> bpy.types.ID:
        """Have this stage remove some data."""
        self._data.append(data)
        return data


def _name(number: int, marking: Marking) -> str:
    return f"Marking {number} {marking.kind}"


def _height(number: int) -> float:
    return decals.LIFT * (number + 1)


def _emitted(paint: Paint) -> tuple[float, float, float]:
    red, green, blue = to_linear(np.asarray(paint.rgb))
    return float(red), float(green), float(blue)


def _plane(frame: Frame) -> bpy.types.Mesh:
    width, height = frame.size
    mesh = bpy.data.meshes.new("Pavemark ground")
    corners = [(x * width / 2, y * height / 2, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    return mesh
