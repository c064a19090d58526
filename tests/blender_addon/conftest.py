"""The panel in an open file, on the small images that all tests share."""

import os
import tempfile

import pytest

# Presets and the like go among a user's own files: not among those of who runs the tests.
os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="pavemark-blender-"))


@pytest.fixture(scope="session")
def registered():
    """The extension, registered as Blender registers it."""
    pytest.importorskip("bpy", reason="the bpy wheel is not installed")
    import blender_addon  # noqa: PLC0415 - needs bpy

    blender_addon.register()
    yield
    blender_addon.unregister()


@pytest.fixture
def opened(registered, renderer):
    """An empty file with the panel; afterwards the renderer has its scene again."""
    import bpy  # noqa: PLC0415

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield bpy.context.scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    renderer.target = bpy.context.scene


def choose(scene, inputs, name="a"):
    """Choose the small images as the background, all on."""
    told = scene.pavemark.background
    told.segmenter, told.inpainter = "strokes", "navier-stokes"
    told.metres_per_pixel = 1 / 12
    told.masks = str(inputs / "masks")
    told.images = str(inputs / "images")
    assert scene.pavemark.trouble == ""
    assert told.name == name


@pytest.fixture
def chosen(opened, inputs):
    """The file with an image whose markings are still on it."""
    choose(opened, inputs)
    return opened


@pytest.fixture
def clean(chosen):
    """The file with an image whose markings have been removed."""
    from blender_addon import backdrop, document  # noqa: PLC0415
    from pavemark.background import plates  # noqa: PLC0415
    from pavemark.job.inputs import read_plate  # noqa: PLC0415

    # Another test's cache may have it, and memory then: it is to be in this one's.
    plates._plate.cache_clear()
    entry, job = backdrop.chosen(chosen), backdrop.job(chosen)
    read_plate(entry.image, entry.mask, job)
    document.look(chosen)
    assert chosen.pavemark.background.clean
    return chosen


@pytest.fixture
def drawn(clean):
    """The file with slots on it."""
    import bpy  # noqa: PLC0415

    from blender_addon import document  # noqa: PLC0415

    for seed in range(20):
        clean.pavemark.seed = seed
        scene = document.current(clean)
        if scene is not None and len(scene.slots) >= 2:
            break
    assert len(document.current(clean).slots) >= 2
    bpy.ops.ed.undo_push(message="drawn")
    return clean
