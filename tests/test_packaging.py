"""A new user's first minutes: what is declared, what a wheel holds, what the set-up says when it cannot go on."""

import importlib.metadata
import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement

import pavemark
from pavemark.job.config import read

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PYTHON = shlex.quote(sys.executable)
SETUP_NEEDS = ("bash", "cat", "cut", "dirname", "grep", "mkdir", "rm", "sha256sum", "tail")


def requirements(extra: str, python: str) -> dict[str, Requirement]:
    """What an extra asks for on a Python, by name."""
    environment = {**default_environment(), "python_version": python}
    wanted = map(Requirement, PROJECT["project"]["optional-dependencies"][extra])
    return {one.name: one for one in wanted if one.marker is None or one.marker.evaluate(environment)}


def test_version_is_told_once():
    assert PROJECT["project"]["version"] == pavemark.__version__


@pytest.mark.parametrize(
    ("python", "bpy", "numpy_2_fits"), [("3.11", "4.5.15", False), ("3.13", "5.2.3", True)], ids=["3.11", "3.13"]
)
def test_blender_fits_the_python(python, bpy, numpy_2_fits):
    wanted = requirements("blender", python)
    assert wanted["bpy"].specifier.contains(bpy)
    assert ("numpy" not in wanted or wanted["numpy"].specifier.contains("2.0.0")) is numpy_2_fits


def test_every_package_is_listed():
    found = {
        ".".join(file.parent.relative_to(root).parts)
        for root, top in ((ROOT / "pipeline", "pavemark"), (ROOT, "blender_addon"))
        for file in (root / top).rglob("__init__.py")
    }
    assert set(PROJECT["tool"]["setuptools"]["packages"]) - {"pavemark.shipped"} == found


def test_the_renderer_is_found_where_it_is_announced():
    (entry,) = importlib.metadata.entry_points(group="pavemark.renderers", name="blender")
    module = importlib.util.find_spec(entry.module)
    assert f"class {entry.attr}" in Path(module.origin).read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_wheel_brings_code_and_assets(tmp_path):
    tree = tmp_path / "tree"
    ours = ("pipeline", "blender_addon", "assets", "pyproject.toml", "README.md", "LICENSE")
    tree.mkdir()
    for name in ours:
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, tree / name)
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        tmp_path,
        tree,
    ]
    subprocess.run(command, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)

    assert (site / "blender_addon/renderer.py").exists()
    for asset in (*ROOT.glob("assets/*.json"), *ROOT.glob("assets/presets/*.toml")):
        found = subprocess.run(
            [
                sys.executable,
                "-c",
                f"from pavemark import assets; print(assets.path('{asset.relative_to(ROOT / 'assets')}'))",
            ],
            env={**os.environ, "PYTHONPATH": str(site)},
            cwd=tmp_path,
            check=True,
            capture_output=True,
            text=True,
        )
        assert Path(found.stdout.strip()) == site / "pavemark/shipped" / asset.relative_to(ROOT / "assets")


def executable(path: Path, script: str) -> None:
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)


@pytest.fixture
def machine(tmp_path):
    """A checkout on a machine that has the shell's tools and nothing else; returns its bin folder and a set-up run."""
    programs, project, home = tmp_path / "bin", tmp_path / "a project", tmp_path / "home"
    for folder in (programs, project / ".ci", home):
        folder.mkdir(parents=True)
    for name in SETUP_NEEDS:
        (programs / name).symlink_to(shutil.which(name))
    shutil.copy(ROOT / ".ci/setup", project / ".ci")
    shutil.copy(ROOT / "pyproject.toml", project)

    def run(**environment):
        clean = {"PATH": str(programs), "HOME": str(home), **environment}
        return subprocess.run([project / ".ci/setup"], check=False, env=clean, capture_output=True, text=True)

    return programs, run


def one_line(done: subprocess.CompletedProcess) -> str:
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("setup: ")
    return line


def test_no_python_is_told_in_one_line(machine):
    _, run = machine
    line = one_line(run())
    assert "no Python 3.13 or 3.11" in line
    assert "apt-get install python3 python3-venv" in line


def test_an_unsuitable_python_is_passed_over(machine):
    programs, run = machine
    executable(programs / "python3", f'exec {PYTHON} -c "import sys; sys.version_info = (3, 9, 2); $2"')
    executable(programs / "python3.13", 'echo "pyenv: python3.13: command not found" >&2; exit 127')
    assert "no Python 3.13 or 3.11" in one_line(run())


def test_a_chosen_python_is_named_when_it_does_not_suit(machine):
    _, run = machine
    assert "PYTHON=/bin/false" in one_line(run(PYTHON="/bin/false"))


def test_missing_libraries_are_installed_by_root_and_named_to_others(machine):
    programs, run = machine
    executable(programs / "python3", f'[ "$1" = - ] && echo libx11-6 && exit\nexec {PYTHON} "$@"')
    executable(programs / "apt-get", 'echo "E: Unable to locate package $*"; exit 100')
    done = run()
    command = "apt-get install --no-install-recommends libx11-6"
    if os.geteuid() == 0:
        assert done.stdout == f"setup: {command}\n"
        assert "apt-get failed: E: Unable to locate" in one_line(done)
    else:
        assert one_line(done).endswith(f"sudo {command}")


@pytest.mark.slow
def test_no_network_is_told_in_one_line(machine):
    programs, run = machine
    executable(programs / "python3", f'[ "$1" = - ] && exit\nexec {PYTHON} "$@"')
    nowhere = {"PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_CONFIG_FILE": os.devnull, "PIP_RETRIES": "1"}
    assert "the package index cannot be reached" in one_line(run(**nowhere))


def test_the_commands_of_the_readme_are_targets():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    targets = set(re.findall(r"\bmake ([a-z-]+)", readme)) & {
        "demo",
        "test",
        "lint",
        "format",
        "bench",
        "demo-images",
        "clean",
    }
    assert len(targets) == 7
    for target in targets:
        subprocess.run(["make", "--dry-run", target], cwd=ROOT, check=True, capture_output=True)


def test_the_job_file_of_the_readme_is_one(tmp_path):
    (text,) = re.findall(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "job.toml"
    path.write_text(text)
    job = read(path, {})
    assert (job.count, job.noise.rate, job.blend.method) == (2000, 0.5, "normal")
