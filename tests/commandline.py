"""The command line with a renderer that needs no Blender, and what is needed to watch it."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

PROGRAM = [sys.executable, str(Path(__file__).with_name("flat_renderer.py"))]


def pavemark(*words, **environment):
    """Run the command line to its end."""
    command = [*PROGRAM, *map(str, words)]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, **environment}, timeout=120
    )


def start(*words, **environment):
    """Start the command line in a process group of its own."""
    return subprocess.Popen(
        [*PROGRAM, *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
        start_new_session=True,
    )


def contents(out):
    """Bytes of every file of a dataset but the journals and the timings in the manifest."""
    found = {}
    for path in sorted(Path(out).rglob("*")):
        name = path.relative_to(out).as_posix()
        if path.is_file() and not name.startswith("journal/") and name != "manifest.jsonl":
            found[name] = path.read_bytes()
    return found


def workers_of(pid, called=""):
    """Process ids of the children of a process that are called so: libraries ask lscpu and fc-list as they load."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    found = [int(word) for word in children.read_text().split()] if children.exists() else []
    return [child for child in found if called in _called(child)]


def _called(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def gone(pid):
    """Whether a process has ended, its entry in the process table aside."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def wait_until(condition, seconds=30.0):
    """Wait until something is so; whether it came to be."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


def kill(pid):
    """Kill -9, if it is still there."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
