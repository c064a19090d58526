"""Render settings, plain values applied in one place."""

from __future__ import annotations

import attrs
import bpy

from pavemark.ground import Frame

from . import versions


@attrs.frozen
class Cycles:
    """Cycles on the CPU, set for exact colours: no view transform, no dither, no denoising.

    Attributes
    ----------
    samples : int
        Rays a pixel. With one, the ray goes through the pixel's centre.
    transparent : int
        How many decals may lie on top of each other.
    threads : int
        0 takes all cores.
    """

    samples: int = 1
    transparent: int = 8
    threads: int = 0

    def apply(self, scene: bpy.types.Scene) -> None:
        """Set them on a scene."""
        render, cycles = scene.render, scene.cycles
        render.engine = "CYCLES"
        render.film_transparent = True
        render.dither_intensity = 0.0
        render.use_compositing = False
        render.use_sequencer = False
        render.threads_mode = "FIXED" if self.threads else "AUTO"
        if self.threads:
            render.threads = self.threads
        cycles.device = "CPU"
        cycles.samples = self.samples
        cycles.use_adaptive_sampling = False
        cycles.use_denoising = False
        cycles.pixel_filter_type = "BOX"
        # A box of almost no width is the pixel's centre; more samples are spread over the whole pixel.
        cycles.filter_width = 0.01 if self.samples == 1 else 1.0
        cycles.max_bounces = 0
        cycles.transparent_max_bounces = self.transparent
        cycles.min_transparent_bounces = self.transparent  # below it, Russian roulette would end rays in a stack
        cycles.seed = 0
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
