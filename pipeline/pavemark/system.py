"""What differs between Linux, Windows and macOS, and nothing else; no other module asks on which of them it runs."""

from __future__ import annotations

import errno
import os
import platform
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import psutil

WINDOWS = sys.platform == "win32"

MEMORY = Path("/dev/shm") if Path("/dev/shm").is_dir() else Path(tempfile.gettempdir())
"""A folder for what is read back at once: in memory where there is one."""

PATIENCE = 2.0
"""Seconds for which a file that Windows will not let go of is asked for again."""

_PAUSE = 0.05
_PART = 1 << 24


def apart() -> dict[str, Any]:
    """What `subprocess.Popen` is told for a process that Ctrl-C in the terminal of this one does not reach."""
    if WINDOWS:
        # A group alone would open a console of its own where this process has none, as Blender started by its icon.
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"process_group": 0}


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Entered to start a process that Ctrl-C does not reach from its first moment on.

    Windows has no such thing: there, a process ignores Ctrl-C once it has come to say so.
    """
    if WINDOWS:
        yield
        return
    # The new process inherits what is blocked, but no handler; other threads of this one still hear the signal.
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def alive(pid: int) -> bool:
    """Whether there is such a process on this host."""
    # os.kill(pid, 0), which only asks elsewhere, ends it on Windows.
    return psutil.pid_exists(pid)


def cores() -> int:
    """The processors that this process may use."""
    process = psutil.Process()
    # macOS knows no such choice.
    return len(process.cpu_affinity()) if hasattr(process, "cpu_affinity") else os.cpu_count() or 1


def load() -> float | None:
    """The processes that waited for a processor in the last minute; None where that is not counted."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def processor() -> str:
    """Its name, as its maker writes it where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def peak() -> float:
    """Most memory (resident, 10⁶ bytes) that this process has held; nan on macOS."""
    told = psutil.Process().memory_info()
    if hasattr(told, "peak_wset"):
        return told.peak_wset / 1e6
    # Of the process as it is since it began to run this program: getrusage counts what its parent held as well.
    try:
        status = Path("/proc/self/status").read_text(encoding="utf-8")
    except OSError:
        return float("nan")
    return int(status.partition("VmHWM:")[2].split()[0]) * 1024 / 1e6


def replace(source: Path, target: Path) -> None:
    """Rename a file, over another one if need be.

    Raises
    ------
    OSError
        When that is not to be.
    """
    # Windows refuses as long as someone has either open: another shard, the search index, a guard against viruses.
    for _ in range(round(PATIENCE / _PAUSE) if WINDOWS else 0):
        try:
            source.replace(target)
        except PermissionError:
            time.sleep(_PAUSE)
        else:
            return
    source.replace(target)


def reserve(stream: BinaryIO) -> None:
    """Have room on the disk for all that a file may hold as long as it is; what it holds stays.

    Raises
    ------
    OSError
        When there is too little.
    """
    size = os.fstat(stream.fileno()).st_size
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(stream.fileno(), 0, size)
        return
    # A hole in a file has no room yet; what was written has.
    for start in range(0, size, _PART):
        stream.seek(start)
        part = stream.read(_PART)
        stream.seek(start)
        stream.write(part)
    stream.flush()


def reader_gone(error: OSError) -> bool:
    """Whether writing to a pipe failed because nobody reads it any more."""
    return isinstance(error, BrokenPipeError) or (WINDOWS and error.errno == errno.EINVAL)
