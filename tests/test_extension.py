"""The extension: its manifest, what it bundles, and that Blender's own tool takes it."""

import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MANIFEST = tomllib.loads((ROOT / "blender_addon/blender_manifest.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def extension():
    """The script that builds it."""
    spec = importlib.util.spec_from_file_location("extension", ROOT / ".ci/extension.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_manifest_says_what_the_project_says(extension):
    assert MANIFEST["version"] == extension.PROJECT["version"]
    assert MANIFEST["license"] == [f"SPDX:{extension.PROJECT['license']}"]
    assert MANIFEST["blender_version_min"] == "4.5.0"


def test_permissions_are_stated_and_there_is_no_network():
    assert set(MANIFEST["permissions"]) == {"files"}
    assert all(len(reason) <= 64 and not reason.endswith(".") for reason in MANIFEST["permissions"].values())


@pytest.mark.parametrize(("python", "held"), [("3.13", set()), ("3.11", {"numpy", "opencv-contrib-python-headless"})])
def test_what_is_bundled(extension, python, held):
    kept, limits = extension.requirements(python)
    names = {text.partition(">")[0] for text in kept}
    assert {"attrs", "cattrs", "scipy", "shapely", "opencv-contrib-python-headless", "OpenImageIO"} <= names
    assert {"filelock", "psutil"} <= names
    assert not names & {"numpy", "matplotlib", "pyamg", "pyarrow"}
    assert held <= {text.partition("<")[0] for text in limits}


def test_every_platform_that_is_announced_can_be_named(extension):
    assert {"linux-x64", "windows-x64", "macos-arm64"} == set(extension.PLATFORMS)
    assert extension.current_platform() in {"linux-x64", "linux-arm64", "windows-x64", "macos-arm64", "macos-x64"}


def test_blenders_tool_takes_it(extension, tmp_path):
    pytest.importorskip("bpy", reason="the bpy wheel is not installed")
    wheel = tmp_path / "pavemark-0.1.0-py3-none-any.whl"
    wheel.write_bytes(b"")
    folder = tmp_path / "pavemark"
    extension.lay_out(folder, [wheel], "linux-x64")
    told = tomllib.loads((folder / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert told["wheels"] == ["./wheels/pavemark-0.1.0-py3-none-any.whl"]
    assert told["platforms"] == ["linux-x64"]
    assert (folder / "render.py").exists() and not (folder / "carpark").exists()
    done = subprocess.run(
        [sys.executable, extension.blenders_tool(), "validate", folder], check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


INSTALL = """
import sys
from pathlib import Path
import bpy

before = set(dir(bpy.ops.pavemark))
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
name = "bl_ext.user_default.pavemark"
assert name in bpy.context.preferences.addons, "not enabled"
assert {"render", "batch", "remove_markings"} <= set(dir(bpy.ops.pavemark)), "no operators"
assert bpy.context.scene.pavemark.count.slots > 0
bpy.ops.preferences.addon_disable(module=name)
assert set(dir(bpy.ops.pavemark)) == before and not hasattr(bpy.types.Scene, "pavemark"), "something stays"
"""


@pytest.mark.slow
def test_the_zip_installs_into_the_blender_that_is_here_and_leaves_it_as_it_was(tmp_path):
    """With user files of its own, in the version of the bpy wheel: 5.2 here, 4.5 where that one is installed."""
    pytest.importorskip("bpy", reason="the bpy wheel is not installed")
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    built = [sys.executable, ROOT / ".ci/extension.py", "--python", python, "--out", tmp_path]
    done = subprocess.run(built, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.glob("*.zip")
    home = {"BLENDER_USER_RESOURCES": str(tmp_path / "user"), "PAVEMARK_CACHE": str(tmp_path / "cache")}
    installed = [sys.executable, "-c", INSTALL, path]
    done = subprocess.run(installed, check=False, capture_output=True, text=True, env=os.environ | home)
    assert done.returncode == 0, done.stdout + done.stderr
    assert list((tmp_path / "user/extensions/user_default/pavemark").glob("blender_manifest.toml"))
