"""The car park in Blender, and the light that its cameras see. The only file of the car park that imports bpy."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
from mathutils import Matrix

from blender_addon.carpark import car
from blender_addon.carpark.layout import Block, Parked
from blender_addon.carpark.pavement import FRAME, Surface
from blender_addon.versions import exr_layers
from pavemark import files
from pavemark.cameras.rig import Fisheye, Mount
from pavemark.colour import quantise
from pavemark.errors import InputError

SAMPLES = 16
"""Rays a pixel; the denoiser and then the sensor's own noise hide what is left."""


def clear(threads: int) -> None:
    """An empty scene, Cycles on the CPU.

    Raises
    ------
    InputError
        Under Blender 4.5, whose panoramic cameras are set up another way; the shipped images come from 5.2.
    """
    if bpy.app.version < (5, 0, 0):
        raise InputError(f"Blender {bpy.app.version_string}", "the car park is rendered with 5.0 or later")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = 4
    scene.cycles.diffuse_bounces = 2
    scene.cycles.caustics_reflective = False
    scene.cycles.caustics_refractive = False
    scene.cycles.sample_clamp_indirect = 4.0
    scene.render.threads_mode = "FIXED"
    scene.render.threads = threads
    scene.render.use_border = True
    scene.render.dither_intensity = 0.0
    exr_layers(scene.render.image_settings)
    aov = bpy.context.view_layer.aovs.add()
    aov.name, aov.type = "Ground", "VALUE"


def ground(surface: Surface, wavy: float, seed: float) -> None:
    """Lay the pavement at Z = 0.

    Parameters
    ----------
    surface : Surface
    wavy : float
        Metres of unevenness that bends the glare; 0 for matt ground.
    seed : float
        W of the noise.
    """
    plane = _mesh("ground", *_plane(FRAME.size[0] / 2))
    plane.data.uv_layers.new()
    plane.data.uv_layers[0].data.foreach_set("uv", np.array([0, 0, 1, 0, 1, 1, 0, 1], np.float32))
    material, nodes, link = _material("ground")
    shader = nodes["Principled BSDF"]
    albedo = _picture(
        nodes, np.where(surface.albedo > 0.0031308, 1.055 * surface.albedo ** (1 / 2.4) - 0.055, 0), "sRGB"
    )
    roughness = _picture(nodes, np.repeat(surface.roughness[..., None], 3, -1), "Non-Color")
    link(albedo.outputs["Color"], shader.inputs["Base Color"])
    link(roughness.outputs["Color"], shader.inputs["Roughness"])
    seen = nodes.new("ShaderNodeOutputAOV")
    seen.aov_name = "Ground"
    seen.inputs["Value"].default_value = 1.0
    if wavy:
        noise, bump = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeBump")
        noise.noise_dimensions = "4D"
        noise.inputs["W"].default_value = seed
        noise.inputs["Scale"].default_value = 30.0
        bump.inputs["Distance"].default_value = wavy
        link(noise.outputs[0], bump.inputs["Height"])
        link(bump.outputs["Normal"], shader.inputs["Normal"])
    plane.data.materials.append(material)
    far = _mesh("far", *_plane(60.0))
    far.location.z = -0.02
    far.data.materials.append(_plain("far", tuple(surface.albedo.mean((0, 1)).tolist()), 0.9))


def block(what: Block) -> None:
    """Stand a kerb, wall, pillar or verge on the ground."""
    along, across, up = what.size
    item = _box(what.kind, (along, across, up), 0.012)
    item.location = (*what.at, up / 2)
    item.rotation_euler.z = what.heading
    item.data.materials.append(
        {
            "kerb": lambda: _mottled("kerb", (0.34, 0.34, 0.34), (0.42, 0.41, 0.39), 2.0),
            "wall": lambda: _mottled("wall", (0.40, 0.40, 0.40), (0.50, 0.49, 0.47), 2.0),
            "pillar": lambda: _striped(0.62, below=1.1),
            "verge": lambda: _mottled("verge", (0.035, 0.07, 0.018), (0.09, 0.13, 0.04), 9.0),
        }[what.kind]()
    )


def parked(where: Parked, make: car.Make) -> None:
    """Stand a car on the ground."""
    whole = _car(where, make)
    _wheels(whole, make)
    _fittings(whole, make)


def ego(make: car.Make) -> None:
    """The car that carries the cameras, at the origin, without what would stand in their way."""
    _wheels(_car(Parked((0.0, 0.0), np.pi / 2), make), make)


def _car(where: Parked, make: car.Make) -> bpy.types.Object:
    """The body alone."""
    whole = bpy.data.objects.new("car", None)
    bpy.context.collection.objects.link(whole)
    whole.location = (*where.at, 0.0)
    whole.rotation_euler.z = where.heading
    vertices, faces, materials = car.body(make)
    shell = _mesh("body", vertices, faces)
    shell.parent = whole
    paint = _plain("paint", make.colour, 0.25)
    paint.node_tree.nodes["Principled BSDF"].inputs["Coat Weight"].default_value = 1.0
    for material in (paint, _plain("glass", (0.01, 0.012, 0.014), 0.04), _plain("plastic", (0.012,) * 3, 0.5)):
        shell.data.materials.append(material)
    shell.data.polygons.foreach_set("material_index", np.array(materials, np.int32))
    shell.data.polygons.foreach_set("use_smooth", np.ones(len(materials), bool))
    smooth = shell.modifiers.new("smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 2
    return whole


def _wheels(whole: bpy.types.Object, make: car.Make) -> None:
    """Wheels in dark arches."""
    length, half = make.length, make.width / 2
    rubber, rim = _plain("rubber", (0.012,) * 3, 0.8), _plain("rim", (0.5, 0.5, 0.52), 0.3)
    dark, hub = _plain("dark", (0.004,) * 3, 0.9), _plain("hub", (0.01,) * 3, 0.3)
    for x in (0.31 * length, -0.29 * length):
        for side in (-1, 1):
            # Each ring lies a little further out than the one that it is set in.
            for radius, out, material in (
                (0.40, 0.000, dark),
                (0.335, 0.015, rubber),
                (0.235, 0.02, rim),
                (0.06, 0.03, hub),
            ):
                disc = _disc(radius, 0.24)
                disc.location = (x, side * (half * 0.985 - 0.12 + out), 0.335 if radius < 0.4 else 0.37)
                disc.rotation_euler.x = np.pi / 2
                disc.data.materials.append(material)
                disc.parent = whole
            for spoke in range(5):
                gap = _box("gap", (0.13, 0.01, 0.065), 0.01)
                angle = spoke * 2 * np.pi / 5 + 0.3
                gap.location = (x + 0.14 * np.cos(angle), side * (half * 0.985 + 0.021), 0.335 + 0.14 * np.sin(angle))
                gap.rotation_euler.y = -angle
                gap.data.materials.append(dark)
                gap.parent = whole


def _fittings(whole: bpy.types.Object, make: car.Make) -> None:
    """Lamps, grilles, number plates and mirrors."""
    length, half = make.length, make.width / 2
    trim = _plain("trim", (0.01,) * 3, 0.3)
    tall = 0.12 if make.body == "estate" else 0.0
    lamp, red = _plain("lamp", (0.8, 0.82, 0.85), 0.08), _plain("red", (0.35, 0.01, 0.01), 0.1)
    plate = _plain("plate", (0.03, 0.08, 0.42), 0.4)
    for x, y, z, size, material in (
        (0.468, 0.70, 0.68 + tall, (0.14, 0.34, 0.13), lamp),
        (0.468, -0.70, 0.68 + tall, (0.14, 0.34, 0.13), lamp),
        (-0.478, 0.72, 0.84 + tall, (0.12, 0.34, 0.14), red),
        (-0.478, -0.72, 0.84 + tall, (0.12, 0.34, 0.14), red),
        (0.492, 0.0, 0.56 + tall, (0.07, 0.95, 0.16), trim),
        (0.487, 0.0, 0.34 + tall / 2, (0.08, 1.2, 0.13), trim),
        (0.506, 0.0, 0.47 + tall, (0.03, 0.44, 0.14), plate),
        (-0.502, 0.0, 0.62 + tall, (0.03, 0.44, 0.14), plate),
        (-0.492, 0.0, 0.36 + tall / 2, (0.06, 1.2, 0.16), trim),
    ):
        fitting = _box("fitting", size, 0.03 if material in (lamp, red) else 0.008)
        fitting.location = (x * length, y * half, z)
        fitting.data.materials.append(material)
        fitting.parent = whole
    for side in (-1, 1):
        mirror = _box("mirror", (0.16, 0.2, 0.13), 0.04)
        mirror.location = (0.13 * length, side * (half + 0.08), 1.0 + tall)
        mirror.data.materials.append(trim)
        mirror.parent = whole


def sun(azimuth: float, elevation: float, strength: float, sky: float) -> None:
    """Sunlight from `azimuth` (anticlockwise from +X) under a blue sky; radians, sky relative to a white world."""
    light = _lamp("SUN", strength, (1.0, 0.93, 0.82))
    light.data.angle = np.radians(0.6)
    light.rotation_euler = (0.0, np.pi / 2 - elevation, azimuth)
    _world((0.55 * sky, 0.75 * sky, 1.0 * sky))


def overcast(sky: float) -> None:
    """Light from a grey sky, a little more from one side."""
    light = _lamp("SUN", sky, (1.0, 1.0, 1.0))
    light.data.angle = np.radians(70)
    light.rotation_euler = (0.3, 0.35, 0.0)
    _world((0.92 * sky, 0.97 * sky, 1.0 * sky))


def tree(at: tuple[float, float], rng: np.random.Generator) -> None:
    """A crown of leaves, 3 m across and 5 to 8 m up, for its dappled shade."""
    centres = np.array([*at, 6.5]) + rng.normal(size=(1400, 3)) * (1.3, 1.3, 0.7)
    spread = rng.normal(size=(1400, 4, 3)) * rng.uniform(0.08, 0.2, (1400, 1, 1))
    vertices = (centres[:, None] + spread).reshape(-1, 3)
    crown = _mesh("tree", vertices, [tuple(range(4 * k, 4 * k + 4)) for k in range(len(centres))])
    crown.data.materials.append(_plain("leaf", (0.04, 0.09, 0.02), 0.6))


def garage(lamps: Iterable[tuple[float, float, float]], power: float, tint: tuple[float, float, float]) -> None:
    """A ceiling and walls, lit by tube lamps alone.

    Parameters
    ----------
    lamps : iterable of (x, y, heading)
        Middles of the tubes in metres, and their direction in radians.
    power : float
        Watts of light of each tube.
    tint : tuple of float
    """
    ceiling = _mesh("ceiling", *_plane(16.0))
    ceiling.location.z = 3.0
    ceiling.data.materials.append(_plain("ceiling", (0.45,) * 3, 0.9))
    for k in range(4):
        wall = _box("hall", (34.0, 0.3, 3.0), 0.01)
        wall.location = (15.0 * np.cos(k * np.pi / 2), 15.0 * np.sin(k * np.pi / 2), 1.5)
        wall.rotation_euler.z = (k + 1) * np.pi / 2
        wall.data.materials.append(_plain("hall", (0.5,) * 3, 0.9))
    for x, y, heading in lamps:
        tube = _lamp("AREA", power, tint)
        tube.data.shape = "RECTANGLE"
        tube.data.size, tube.data.size_y = 1.3, 0.10
        tube.location = (x, y, 2.6)
        tube.rotation_euler.z = heading
    _world((0.002,) * 3)


def look(fisheye: Fisheye, mount: Mount, window: tuple[int, int, int, int]) -> dict[str, np.ndarray]:
    """Render what a camera sees.

    Parameters
    ----------
    fisheye : Fisheye
    mount : Mount
    window : tuple of int
        Left, top, right, bottom in pixels; outside of it nothing is rendered.

    Returns
    -------
    dict of ndarray (size, size[, 3]), float32
        "light": linear RGB. "ground": share of the pixel that is ground.
    """
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = fisheye.size
    render = scene.render
    render.border_min_x, render.border_max_x = window[0] / fisheye.size, window[2] / fisheye.size
    render.border_min_y, render.border_max_y = 1 - window[3] / fisheye.size, 1 - window[1] / fisheye.size
    data = bpy.data.cameras.new("fisheye")
    data.type = "PANO"
    data.panorama_type = "FISHEYE_EQUIDISTANT"
    data.fisheye_fov = fisheye.fov
    data.clip_start = 0.005
    camera = bpy.data.objects.new("fisheye", data)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = mount.rotation, mount.position
    camera.matrix_world = Matrix(pose.tolist())
    bpy.context.collection.objects.link(camera)
    scene.camera = camera
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "seen.exr")
        render.filepath = path
        bpy.ops.render.render(write_still=True)
        layers = _layers(path)
    return layers


def _layers(path: str) -> dict[str, np.ndarray]:
    """The passes of a multilayer EXR, which Blender writes as one part a pass."""
    image = oiio.ImageInput.open(path)
    parts = {}
    while image.seek_subimage(len(parts), 0):
        spec = image.spec()
        pixels = np.asarray(image.read_image("float")).reshape(spec.height, spec.width, spec.nchannels)
        parts[spec.channelnames[0].split(".")[1]] = pixels
    image.close()
    return {"light": parts["Combined"][..., :3], "ground": parts["Ground"][..., 0]}


def _mesh(name: str, vertices: np.ndarray, faces: list[tuple[int, ...]]) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], faces)
    item = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(item)
    return item


def _plane(half: float) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    return np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]), [(0, 1, 2, 3)]


def _box(name: str, size: tuple[float, float, float], rounded: float) -> bpy.types.Object:
    corners = np.array([(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]) * size
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    item = _mesh(name, corners, faces)
    bevel = item.modifiers.new("rounded", "BEVEL")
    bevel.width, bevel.segments = rounded, 3
    return item


def _disc(radius: float, thick: float) -> bpy.types.Object:
    around = np.arange(40) * 2 * np.pi / 40
    rim = np.stack([radius * np.cos(around), radius * np.sin(around)], -1)
    vertices = np.concatenate([np.insert(rim, 2, z, 1) for z in (-thick / 2, thick / 2)])
    sides = [(k, (k + 1) % 40, 40 + (k + 1) % 40, 40 + k) for k in range(40)]
    return _mesh("disc", vertices, [*sides, tuple(range(40))[::-1], tuple(range(40, 80))])


def _lamp(kind: str, power: float, colour: tuple[float, float, float]) -> bpy.types.Object:
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", kind))
    light.data.energy, light.data.color = power, colour
    bpy.context.collection.objects.link(light)
    return light


def _world(colour: tuple[float, float, float]) -> None:
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*colour, 1.0)
    bpy.context.scene.world = world


def _material(name: str):
    """A new material, its nodes, and the function that links two sockets."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    return material, material.node_tree.nodes, material.node_tree.links.new


def _plain(name: str, colour: tuple[float, float, float], roughness: float) -> bpy.types.Material:
    material, nodes, _ = _material(name)
    nodes["Principled BSDF"].inputs["Base Color"].default_value = (*colour, 1.0)
    nodes["Principled BSDF"].inputs["Roughness"].default_value = roughness
    return material


def _mottled(name: str, dark: tuple[float, ...], light: tuple[float, ...], scale: float) -> bpy.types.Material:
    """Noise between two colours, `scale` spots a metre."""
    material, nodes, link = _material(name)
    place, noise, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "TexNoise", "ValToRGB"))
    noise.inputs["Scale"].default_value = scale
    noise.inputs["Detail"].default_value = 8.0
    for element, at, colour in zip(ramp.color_ramp.elements, (0.35, 0.65), (dark, light), strict=True):
        element.position, element.color = at, (*colour, 1.0)
    link(place.outputs["Position"], noise.inputs["Vector"])
    link(noise.outputs[0], ramp.inputs[0])
    link(ramp.outputs[0], nodes["Principled BSDF"].inputs["Base Color"])
    nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.9
    return material


def _striped(grey: float, below: float) -> bpy.types.Material:
    """Yellow and black warning stripes up to `below` metres, grey above."""
    material, nodes, link = _material("striped")
    place, split, wave, ramp = (
        nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "SeparateXYZ", "TexWave", "ValToRGB")
    )
    wave.bands_direction = "DIAGONAL"
    wave.inputs["Scale"].default_value = 0.8
    ramp.color_ramp.interpolation = "CONSTANT"
    ramp.color_ramp.elements[0].color = (0.02, 0.02, 0.02, 1)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.5, (0.6, 0.38, 0.02, 1)
    above, mix = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeMixRGB")
    above.operation, above.inputs[1].default_value = "GREATER_THAN", below
    mix.inputs[2].default_value = (grey, grey, grey, 1)
    link(place.outputs["Position"], wave.inputs["Vector"])
    link(place.outputs["Position"], split.inputs[0])
    link(split.outputs[2], above.inputs[0])
    link(wave.outputs[0], ramp.inputs[0])
    link(above.outputs[0], mix.inputs[0])
    link(ramp.outputs[0], mix.inputs[1])
    link(mix.outputs[0], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def _picture(nodes, pixels: np.ndarray, space: str):
    """An image texture of an array (N, N, 3), 0 to 1, its first row at the ground's far edge."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.png"
        path.write_bytes(files.png(quantise(pixels * 255)))
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = space
        image.pack()
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    return node
