"""Opening ONNX files, and running them so that nothing but a checked array comes out.

Every session has the same number of threads, whatever the number of workers: sums over threads differ in the last bit.
"""

from __future__ import annotations

import hashlib
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark.errors import InputError

THREADS = 1
"""Threads of a session: a job has a worker a core already."""

FATAL = 4
"""Log severity below which onnxruntime keeps quiet: what goes wrong is raised too."""


@attrs.frozen
class Port:
    """An input or an output of a graph.

    Attributes
    ----------
    name : str
    type : str
        Element type as onnxruntime writes it, such as "float" or "uint8".
    shape : tuple of int or None
        None where a side is free.
    """

    name: str
    type: str
    shape: tuple[int | None, ...]

    def __str__(self) -> str:
        sides = ", ".join("?" if side is None else str(side) for side in self.shape)
        return f"{self.name} {self.type} [{sides}]"


@attrs.frozen(eq=False)
class Network:
    """An ONNX file that was opened.

    Attributes
    ----------
    path : Path
    sha256 : str
        Of the file.
    inputs, outputs : tuple of Port
    metadata : dict of str to str
        What the file says of itself (`metadata_props`).
    """

    path: Path
    sha256: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    metadata: dict[str, str]
    _session: Any

    def run(self, feeds: dict[str, np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
        """The graph's first output.

        Parameters
        ----------
        feeds : dict of str to ndarray
            An array for every input, of its type.
        shape : tuple of int
            What the output has to look like.

        Returns
        -------
        ndarray of that shape
            Finite.

        Raises
        ------
        InputError
            Naming the file, when the graph fails, or its output has another shape, NaN or infinite values.
        """
        return self.run_all(feeds, {self.outputs[0].name: shape})[0]

    def run_all(self, feeds: dict[str, np.ndarray], shapes: dict[str, tuple[int, ...]]) -> list[np.ndarray]:
        """Several outputs of the graph.

        Parameters
        ----------
        feeds : dict of str to ndarray
            As in `run`.
        shapes : dict of str to tuple of int
            The outputs asked for, and what each has to look like.

        Returns
        -------
        list of ndarray
            Finite, in the order of `shapes`.

        Raises
        ------
        InputError
            As `run`.
        """
        try:
            results = self._session.run(list(shapes), feeds)
        except Exception as error:  # onnxruntime's errors have no common base
            raise InputError(self.path, f"fails on an input of {_sizes(feeds)}: {_said(error)}") from None
        for (name, shape), result in zip(shapes.items(), results, strict=True):
            if result.shape != shape:
                raise InputError(self.path, f"{name} has the shape {list(result.shape)}: {list(shape)} is allowed")
            if not np.isfinite(result).all():
                raise InputError(self.path, f"{name} holds values that are no finite numbers: the model is of no use")
        return results


def opened(path: Path, threads: int = THREADS) -> Network:
    """Open an ONNX file; the same file is opened once a process.

    Parameters
    ----------
    path : Path
    threads : int
        Threads within an operator. The results depend on it in the last bits, so jobs leave it alone.

    Raises
    ------
    InputError
        When the file cannot be read, is no ONNX model or needs what onnxruntime does not have.
    """
    path = Path(path)
    return _opened(path, sha256(path), threads)


@lru_cache(maxsize=4)
def _opened(path: Path, digest: str, threads: int) -> Network:
    runtime = _library()
    options = runtime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    options.log_severity_level = FATAL
    options.use_deterministic_compute = True
    # Weights in other files are covered by no hash: they are looked for where no file can be.
    options.add_session_config_entry("session.model_external_initializers_file_folder_path", os.devnull)
    try:
        session = runtime.InferenceSession(_bytes(path), options, providers=["CPUExecutionProvider"])
    except InputError:
        raise
    except Exception as error:  # onnxruntime's errors have no common base
        raise InputError(path, f"is not an ONNX model that can be opened: {_said(error)}") from None
    inputs, outputs = (
        tuple(Port(port.name, _type(port.type), _shape(port.shape)) for port in ports)
        for ports in (session.get_inputs(), session.get_outputs())
    )
    return Network(path, digest, inputs, outputs, dict(session.get_modelmeta().custom_metadata_map), session)


def sha256(path: Path) -> str:
    """The hash of a file, read again only when the file has changed.

    Raises
    ------
    InputError
        When there is no such file, it is empty or cannot be read.
    """
    path = Path(path)
    try:
        status = path.stat()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    if status.st_size == 0:
        raise InputError(path, "is empty: an ONNX model is allowed")
    return _sha256(path, (status.st_ino, status.st_size, status.st_mtime_ns))


@lru_cache(maxsize=16)
def _sha256(path: Path, stamp: tuple[int, ...]) -> str:
    return hashlib.sha256(_bytes(path)).hexdigest()


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None


def _library() -> Any:
    # A Blender program's Python may have no wheel of it: the classical methods are to work there all the same.
    try:
        import onnxruntime  # noqa: PLC0415
    except ImportError:
        raise InputError(
            "onnxruntime",
            "the package is missing, and networks need it; these do without: "
            'segmenter = "strokes", inpainter = "patchmatch"',
        ) from None
    return onnxruntime


def _type(written: str) -> str:
    return written.removeprefix("tensor(").removesuffix(")")


def _shape(sides: list[int | str | None]) -> tuple[int | None, ...]:
    return tuple(side if isinstance(side, int) else None for side in sides)


def _sizes(feeds: dict[str, np.ndarray]) -> str:
    return ", ".join(f"{name} {list(array.shape)}" for name, array in feeds.items())


def _said(error: Exception) -> str:
    """What onnxruntime says, on one line and without "[ONNXRuntimeError] : 7 : INVALID_PROTOBUF : " before it."""
    return " ".join(str(error).split()).split(" : ", 3)[-1][:300] or type(error).__name__
