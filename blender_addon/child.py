"""A command of Pavemark in a process of its own, so that Blender stays usable; its end is in our hands."""

from __future__ import annotations

import atexit
import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Sequence
from pathlib import Path

import attrs
import bpy

import pavemark
from pavemark import system
from pavemark.errors import one_line

_PROGRESS = re.compile(r"(\d+)/(\d+)  ([\d.]+) \w+/s  (\S+) left(?:  (\d+) lacking)?")
_SUMMARY = re.compile(r"(part \S+ )?\d+ of \d+ ")
_BESIDE, _ABOVE = Path(__file__).with_name("render.py"), Path(__file__).parents[1] / "render.py"
_PYTHON = {"PYTHONUNBUFFERED": "1", "PYTHONUTF8": "1"}
_KEPT = 50
"""Lines of its errors that are kept."""


def render_command() -> list[str]:
    """What starts `pavemark render` with this Blender, program or module, as its renderer."""
    script = str(_BESIDE if _BESIDE.is_file() else _ABOVE)
    if not bpy.app.binary_path:
        return [sys.executable, script]
    return [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P", script, "--"]


def plates_command() -> list[str]:
    """What starts `pavemark plates`, which needs no Blender."""
    return [sys.executable, "-m", "pavemark", "plates"]


@attrs.define
class Child:
    """A process that tells how far it is.

    Attributes
    ----------
    what : str
        What it makes.
    done, total : int
        Of what it makes; a total of 0 is not known yet.
    rate : str
        How many a second.
    left : str
        Time that it will still take.
    said : str
        The last line it said.
    """

    what: str
    done: int = 0
    total: int = 0
    rate: str = ""
    left: str = ""
    said: str = ""
    _stopping: bool = False
    _errors: deque = attrs.field(factory=lambda: deque(maxlen=_KEPT))
    _process: subprocess.Popen | None = None
    _threads: list = attrs.field(factory=list)

    def start(self, command: Sequence[str], environment: dict[str, str] | None = None) -> None:
        """Start it. It ends when this process does, however that comes about: it watches its stdin.

        Raises
        ------
        OSError
            When it cannot be started.
        """
        # Python alone does not know where an extension's packages are; Blender finds them itself.
        packages = str(Path(pavemark.__file__).parents[1])
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            env={**os.environ, **_PYTHON, "PYTHONPATH": packages, **(environment or {})},
            **system.apart(),
        )
        for stream, take in ((self._process.stdout, self._take), (self._process.stderr, self._errors.append)):
            thread = threading.Thread(target=_listen, args=(stream, take), daemon=True)
            thread.start()
            self._threads.append(thread)
        atexit.register(self.end)

    def _take(self, line: str) -> None:
        if told := _PROGRESS.search(line):
            self.done, self.total = int(told[1]), int(told[2])
            self.rate, self.left = told[3], told[4]
        elif _SUMMARY.match(line):
            self.said = line.strip()

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    @property
    def part(self) -> float:
        """How much of it is done, 0 to 1."""
        return self.done / self.total if self.total else 0.0

    def stop(self) -> None:
        """Ask it to stop: what is finished stays, and the same command goes on from there."""
        self._stopping = True
        with contextlib.suppress(OSError):
            self._process.stdin.close()

    def end(self, patience: float = 20.0) -> None:
        """Have it gone when this returns."""
        atexit.unregister(self.end)
        if self.running:
            self.stop()
            try:
                self._process.wait(patience)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self._process.wait()
        for thread in self._threads:
            thread.join(1.0)
        for stream in (self._process.stdout, self._process.stderr):
            stream.close()

    def outcome(self) -> tuple[str, str]:
        """What came of it once it has ended: "INFO", "WARNING" or "ERROR", and a line."""
        code = self._process.returncode
        if self._stopping or code == 128 + signal.SIGINT:
            return "WARNING", f"{self.what}: stopped; what is finished stays, the same again goes on from there"
        told = [line for line in self._errors if line.strip()]
        errors = [line.removeprefix("error: ") for line in told if line.startswith("error: ")]
        if code == 0:
            return "INFO", one_line(self.said or f"{self.what}: done")
        if errors:
            return "ERROR", one_line(errors[-1].strip())
        if code < 0:
            return "ERROR", f"{self.what}: its process was killed by signal {-code}; what is finished stays"
        if code == 1 and self.said:
            lacking = f" ({one_line(told[-1].strip())})" if told else ""
            return "WARNING", one_line(self.said) + lacking
        return "ERROR", one_line(told[-1].strip()) if told else f"{self.what}: ended with exit code {code}"


def _listen(stream, take) -> None:
    with contextlib.suppress(ValueError):  # closed under it
        for line in stream:
            take(line.rstrip("\n"))
