"""A Blender program with the extension installed, in a folder of its own; skipped, visibly, where there is none.

$BLENDER names the program, else `blender` on PATH. A window needs $DISPLAY.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


class Blender:
    """The program, with user files of its own."""

    def __init__(self, program: str, home: Path) -> None:
        self.program = program
        self.environment = {
            **os.environ,
            "BLENDER_USER_RESOURCES": str(home),
            "PAVEMARK_CACHE": str(home / "cache"),
        }

    def run(self, *arguments, **more) -> str:
        """Run it to its end; what it printed."""
        done = subprocess.run(
            [self.program, *map(str, arguments)],
            check=False,
            env={**self.environment, **more},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=600,
        )
        assert done.returncode == 0, done.stdout[-4000:]
        return done.stdout


@pytest.fixture(scope="session")
def bare(tmp_path_factory):
    """The program as it comes."""
    program = os.environ.get("BLENDER") or shutil.which("blender")
    if program is None:
        pytest.skip("no Blender program: $BLENDER is not set and `blender` is not on PATH")
    return Blender(program, tmp_path_factory.mktemp("blender"))


@pytest.fixture(scope="session")
def blender(bare, tmp_path_factory):
    """The program with the built extension installed and enabled."""
    told = bare.run("-b", "--python-expr", "import sys; print('python', *sys.version_info[:2])")
    python = ".".join(re.search(r"^python (\d+) (\d+)", told, re.MULTILINE).groups())
    dist = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, ROOT / ".ci/extension.py", "--python", python, "--out", dist], check=True)
    (path,) = dist.glob("*.zip")
    bare.run("--command", "extension", "install-file", "-r", "user_default", "-e", path)
    return bare


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """Our own demo images, with a small job on them."""
    folder = tmp_path_factory.mktemp("demo")
    for name in ("images", "masks"):
        shutil.copytree(ROOT / "assets/demo" / name, folder / name)
    job = (ROOT / "assets/demo/job.toml").read_text()
    (folder / "job.toml").write_text(re.sub(r"count = \d+", "count = 4", job))
    return folder
