"""Builds the Blender extension: dist/pavemark-VERSION-PLATFORM-pyTAG.zip, with the wheels that it needs.

    python .ci/extension.py [--python 3.13] [--platform linux-x64] [--out dist] [--list]

The Python is that of the Blender it is for: 3.13 for 5.2 LTS, 3.11 for 4.5 LTS. Validating and building is done by
Blender's own tool, which the bpy wheel brings.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import platform
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

PLATFORMS = {
    "linux-x64": [f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 17)] + ["manylinux2014_x86_64"],
    "windows-x64": ["win_amd64"],
    "macos-arm64": [f"macosx_{major}_0_arm64" for major in (14, 13, 12, 11)],
}
"""Blender's names of platforms, and pip's of what runs on them."""

NOT_BUNDLED = {"numpy"}
"""Blender's own is used: another one beside it would crash."""

NO_PANEL_CALLS = {"matplotlib", "pyamg", "pyarrow"}
"""For reports and scores alone, which no panel asks for."""


def current_platform() -> str:
    """Blender's name of this platform."""
    machine = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.get(platform.machine().lower(), "arm64")
    return f"{ {'linux': 'linux', 'win32': 'windows', 'darwin': 'macos'}[sys.platform] }-{machine}"


def requirements(python: str) -> tuple[list[str], list[str]]:
    """What is bundled, and what holds versions back: pip's requirements and constraints for a Python."""
    environment = {**default_environment(), "python_version": python}
    wanted = [Requirement(text) for text in PROJECT["dependencies"]]
    limits = [Requirement(text) for text in PROJECT["optional-dependencies"]["blender"]]
    kept = [f"{one.name}{one.specifier}" for one in wanted if one.name not in NOT_BUNDLED | NO_PANEL_CALLS]
    held = [
        f"{one.name}{one.specifier}"
        for one in limits
        if one.name != "bpy" and (one.marker is None or one.marker.evaluate(environment))
    ]
    return kept, held


def gather(folder: Path, python: str, target: str) -> list[Path]:
    """Fetch the wheels for a Python and a platform, and build Pavemark's own."""
    kept, held = requirements(python)
    (folder / "constraints.txt").write_text("\n".join(held) + "\n")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    tags = [word for tag in PLATFORMS[target] for word in ("--platform", tag)]
    where = ["--python-version", python, "--implementation", "cp", "--only-binary", ":all:", *tags]
    wheels = folder / "wheels"
    run([*pip, "download", *where, "--constraint", folder / "constraints.txt", "--dest", wheels, *kept])
    tree = folder / "tree"
    tree.mkdir()
    for name in ("pipeline", "blender_addon", "assets", "pyproject.toml", "README.md", "LICENSE"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    run([*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", wheels, tree])
    return sorted(path for path in wheels.glob("*.whl") if path.name.split("-")[0] not in NOT_BUNDLED)


def lay_out(folder: Path, wheels: list[Path], target: str) -> None:
    """The extension's folder: the add-on, its manifest with the wheels, and the headless entry that a batch runs."""
    shutil.copytree(
        ROOT / "blender_addon", folder, ignore=shutil.ignore_patterns("__pycache__", "carpark", "blender_manifest.toml")
    )
    shutil.copy(ROOT / "render.py", folder)
    shutil.copy(ROOT / "LICENSE", folder)
    (folder / "wheels").mkdir()
    for wheel in wheels:
        shutil.copy(wheel, folder / "wheels")
    manifest = (ROOT / "blender_addon" / "blender_manifest.toml").read_text(encoding="utf-8")
    listed = "".join(f'  "./wheels/{wheel.name}",\n' for wheel in wheels)
    added = f"platforms = {json.dumps([target])}\nwheels = [\n{listed}]\n\n[permissions]"
    (folder / "blender_manifest.toml").write_text(manifest.replace("[permissions]", added), encoding="utf-8")


def blenders_tool() -> Path:
    """The script that validates and builds extensions."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        sys.exit("extension: the bpy wheel is not installed: it brings the tool that builds extensions")
    (found,) = Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    return found


def run(command: list) -> None:
    """Run a command; when it fails, what it said is all there is to say."""
    done = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True)
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines() or ["it said nothing"]
        sys.exit("extension: {}: {}".format(Path(command[0]).name, "\n".join(said[-10:])))


def build(python: str, target: str, out: Path) -> Path:
    """Validate and build; the zip."""
    tag = python.replace(".", "")
    path = out / f"pavemark-{PROJECT['version']}-{target}-py{tag}.zip"
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "pavemark"
        lay_out(folder, gather(Path(scratch), python, target), target)
        out.mkdir(parents=True, exist_ok=True)
        tool = [sys.executable, blenders_tool()]
        run([*tool, "validate", folder])
        run([*tool, "build", "--source-dir", folder, "--output-filepath", path])
        run([*tool, "validate", path])
    return path


def main() -> None:
    """Build what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--python", default=f"{sys.version_info[0]}.{sys.version_info[1]}", help="Python of the Blender"
    )
    parser.add_argument("--platform", default=current_platform(), choices=PLATFORMS)
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--list", action="store_true", help="say what would be bundled, and build nothing")
    told = parser.parse_args()
    if told.list:
        kept, held = requirements(told.python)
        print("\n".join([*kept, *(f"held back: {one}" for one in held)]))
        return
    path = build(told.python, told.platform, told.out)
    print(f"{path}: {path.stat().st_size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
