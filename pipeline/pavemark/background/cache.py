"""What was worked out once is kept: arrays in files named by the hash of all they depend on, libraries included."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import io
import os
import zipfile
import zlib
from pathlib import Path

import cv2
import numpy as np
import OpenImageIO as oiio
import scipy

from pavemark.errors import InputError
from pavemark.files import write


def folder() -> Path:
    """Where the cache lies: $PAVEMARK_CACHE, else $XDG_CACHE_HOME/pavemark, else ~/.cache/pavemark."""
    own, general = os.environ.get("PAVEMARK_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if own:
        return Path(own)
    return (Path(general) if general else Path("~/.cache").expanduser()) / "pavemark"


def load(key: str) -> dict[str, np.ndarray] | None:
    """The arrays kept under a key; None where there are none, or where they cannot be read or are damaged."""
    try:
        with np.load(_path(key), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError):
        return None


def holds(key: str) -> bool:
    """Whether something is kept under a key."""
    return _path(key).exists()


def store(key: str, **arrays: np.ndarray) -> None:
    """Keep arrays under a key. A cache that cannot be written costs time the next time, and nothing else."""
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    with contextlib.suppress(InputError):
        write(_path(key), stream.getvalue())


def _installed(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


LIBRARIES = {
    "opencv": cv2.__version__,
    "PyPatchMatch": _installed("PyPatchMatch"),
    "scipy": scipy.__version__,
    "numpy": np.__version__,
    "OpenImageIO": oiio.VERSION_STRING,
}
"""Versions of what plates are made with."""

_SHELF = hashlib.sha256(repr(tuple(LIBRARIES.values())).encode()).hexdigest()[:12]
"""Folder of what these versions of the libraries made: others may differ in the last bit."""


def _path(key: str) -> Path:
    return folder() / _SHELF / key[:2] / f"{key}.npz"
