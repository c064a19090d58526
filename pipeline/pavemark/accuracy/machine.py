"""On what it was measured: times compare within a run, not across machines."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Sequence

from pavemark import __version__, system
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
    waiting = system.load()
    load = "" if waiting is None else f", load {waiting:.1f}"
    versions = ", ".join(f"{name} {version}" for name in PACKAGES if (version := _installed(name)))
    threads = f"{THREADS} thread{'' if THREADS == 1 else 's'} a method"
    return (
        f"{system.processor()}, {system.cores()} cores{load}, {threads}. "
        f"Pavemark {__version__}, Python {platform.python_version()}, {versions}."
    )


def versions(methods: Sequence[str]) -> str:
    """The inpainters with their versions, hashes of networks among them, in one line."""
    return "Methods: " + "; ".join(f"{method}, version {inpainter(method).version}" for method in methods) + "."


def _installed(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
