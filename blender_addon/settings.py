"""Render settings, plain values applied in one place."""

from __future__ import annotations

import attrs
import bpy

from pavemark.ground import Frame
from pavemark.plan import Pass, Sampling

from . import versions


@attrs.frozen
class Cycles:
    """Cycles on the CPU, set for exact colours: no view transform, no dither.

    Attributes
    ----------
    samples : int
        Rays a pixel. With one, the ray goes through the pixel's centre.
    transparent : int
        How many decals may lie on top of each other.
    threads : int
        0 takes all cores.
    sampling : Sampling
    """

    samples: int = 1
    transparent: int = 8
    threads: int = 0
    sampling: Sampling = attrs.field(factory=Sampling)

    def apply(self, scene: bpy.types.Scene) -> None:
        """Set them on a scene."""
        _exact(scene, self.threads)
        scene.render.engine = "CYCLES"
        cycles, sampling = scene.cycles, self.sampling
        cycles.device = "CPU"
        cycles.samples = self.samples
        cycles.use_adaptive_sampling = sampling.threshold > 0
        if sampling.threshold:
            cycles.adaptive_threshold = sampling.threshold
        cycles.use_denoising = sampling.denoise
        cycles.pixel_filter_type = sampling.filter.upper().replace("-", "_")
        # A box of almost no width is the pixel's centre; more samples are spread over the whole pixel.
        cycles.filter_width = 0.01 if self.samples == 1 else sampling.width
        cycles.max_bounces = 0
        cycles.transparent_max_bounces = self.transparent
        cycles.min_transparent_bounces = self.transparent  # below it, Russian roulette would end rays in a stack
        cycles.seed = sampling.seed


@attrs.frozen
class Eevee:
    """EEVEE, which needs a GPU or a program that plays one.

    Attributes
    ----------
    samples : int
        Positions in the pixel.
    width : float
        Pixels across of the filter.
    """

    samples: int
    width: float

    def apply(self, scene: bpy.types.Scene) -> None:
        """Set it on a scene."""
        _exact(scene, threads=0)
        scene.render.engine = versions.EEVEE
        scene.render.filter_size = self.width
        scene.eevee.taa_render_samples = self.samples


def engine(made: Pass, transparent: int, threads: int) -> Cycles | Eevee:
    """The engine that a pass calls for, with its settings; see `Cycles`."""
    if made.sampling.engine == "eevee":
        return Eevee(made.samples, made.sampling.width)
    return Cycles(made.samples, transparent, threads, made.sampling)


def _exact(scene: bpy.types.Scene, threads: int) -> None:
    """Colours as they are, over transparency."""
    render = scene.render
    render.film_transparent = True
    render.dither_intensity = 0.0
    render.use_compositing = False
    render.use_sequencer = False
    render.threads_mode = "FIXED" if threads else "AUTO"
    if threads:
        render.threads = threads
    scene.view_settings.view_transform = "Raw"
    scene.display_settings.display_device = "sRGB"


@attrs.frozen
class Window:
    """The pixels of a frame that are rendered: columns left … right - 1, rows top … bottom - 1 from the top."""

    left: int
    top: int
    right: int
    bottom: int


@attrs.frozen
class Output:
    """A window of one frame of ground into a multilayer EXR of the window's size.

    Empty ground costs almost as much as paint (53 ms of 65 at 600×600 on one thread), so only what holds decals is
    rendered.
    """

    frame: Frame
    window: Window
    path: str

    def apply(self, scene: bpy.types.Scene) -> None:
        """Set it on a scene."""
        render, (width, height) = scene.render, (self.frame.width, self.frame.height)
        render.resolution_x, render.resolution_y = width, height
        render.resolution_percentage = 100
        render.pixel_aspect_x = render.pixel_aspect_y = 1.0
        render.use_border = render.use_crop_to_border = True
        # Blender rounds border times size down to whole pixels; a hundredth keeps it from falling short.
        render.border_min_x = (self.window.left + 0.01) / width
        render.border_max_x = (self.window.right + 0.01) / width
        render.border_min_y = (height - self.window.bottom + 0.01) / height
        render.border_max_y = (height - self.window.top + 0.01) / height
        render.use_file_extension = False
        render.filepath = self.path
        versions.exr_layers(render.image_settings)
