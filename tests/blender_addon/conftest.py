"""One Blender for all tests of the renderer; without the bpy wheel they are skipped, and say so."""

import pytest


@pytest.fixture(scope="session")
def renderer():
    pytest.importorskip("bpy", reason="the bpy wheel is not installed")
    from blender_addon.renderer import BlenderRenderer  # noqa: PLC0415 - needs bpy

    return BlenderRenderer(threads=1)
