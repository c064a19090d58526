"""On what it was measured: times compare within a run, not across machines."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Sequence
from pathlib import Path

from pavemark import __version__
from pavemark.accuracy.apart import THREADS
from pavemark.background.inpainting import inpainter

PACKAGES = (
    "numpy",
    "scipy",
    "opencv-contrib-python-headless",
    "shapely",
    "pyamg",
    "PyPatchMatch",
    "onnxruntime",
    "OpenImageIO",
)


def machine() -> str:
    """Processor, cores, load, threads a method, and versions, in one line."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    versions = ", ".join(f"{name} {version}" for name in PACKAGES if (version := _installed(name)))
    threads = f"{THREADS} thread{'' if THREADS == 1 else 's'} a method"
    return (
        f"{_processor()}, {cores} cores{load}, {threads}. "
        f"Pavemark {__version__}, Python {platform.python_version()}, {versions}."
    )


def versions(methods: Sequence[str]) -> str:
    """The inpainters with their versions, hashes of networks among them, in one line."""
    return "Methods: " + "; ".join(f"{method}, version {inpainter(method).version}" for method in methods) + "."


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _installed(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
