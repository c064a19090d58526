"""What tests of several folders share: a small folder of images with the job that is run on it, and one Blender."""

import os

import cv2
import numpy as np
import pytest


@pytest.fixture(scope="session")
def inputs(tmp_path_factory):
    """Three images of 96×64 pixels, 8 m × 5.3 m, with masks, in `images` and `masks`."""
    folder = tmp_path_factory.mktemp("inputs")
    os.environ["PAVEMARK_CACHE"] = str(folder / "cache")
    rng = np.random.default_rng(0)
    (folder / "images").mkdir()
    (folder / "masks").mkdir()
    for name, tone in (("a", 70), ("b", 110), ("c", 150)):
        mask = np.zeros((64, 96), np.uint8)
        mask[:, 40:42] = 1
        image = rng.normal(tone, 5, (64, 96, 3)) + 60 * mask[..., None]
        cv2.imwrite(str(folder / "images" / f"{name}.png"), image.clip(0, 255).astype(np.uint8))
        cv2.imwrite(str(folder / "masks" / f"{name}.png"), mask)
    return folder


@pytest.fixture
def arguments(inputs):
    """The arguments of a small job, without --out."""
    told = ["render", "--images", inputs / "images", "--masks", inputs / "masks", "--count", "10", "--seed", "7"]
    return [
        str(word)
        for word in (*told, "--scale", "12", "--inpainter", "navier-stokes", "--segmenter", "strokes", "--workers", "1")
    ]


@pytest.fixture(scope="session")
def renderer():
    """One Blender for all tests of the renderer; without the bpy wheel they are skipped, and say so."""
    pytest.importorskip("bpy", reason="the bpy wheel is not installed")
    from blender_addon.renderer import BlenderRenderer  # noqa: PLC0415 - needs bpy

    return BlenderRenderer(threads=1)
