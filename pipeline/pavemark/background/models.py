"""Networks that users bring: which file, of which kind, under which licence. Nothing is ever downloaded.

A model is recorded, not copied: a line of JSON holds where its file lies and the hash by which it is known again.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from pathlib import Path

import attrs

from pavemark import assets, files, onnx
from pavemark.background.contracts import CONTRACTS, measured_white, recognised
from pavemark.errors import InputError, one_line
from pavemark.records import from_json, one_of, to_json, within

SHIPPED = "pavemark"
"""Name of our own network."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


@attrs.frozen(kw_only=True)
class Model:
    """A recorded model.

    Attributes
    ----------
    name : str
        As a job calls it.
    file : str
        Absolute path.
    sha256 : str
        Of the file when it was recorded.
    bytes : int
    contract : str
        Name of its `Contract`.
    white : float
        White in its output.
    licence : str
        As the user told it, or as it is known of that hash.
    """

    name: str
    file: str
    sha256: str
    bytes: int
    contract: str = attrs.field(validator=one_of(*CONTRACTS))
    white: float = attrs.field(validator=within(1, 255))
    licence: str = ""


@attrs.frozen
class Known:
    """A published file, known by its hash."""

    what: str
    source: str
    licence: str


KNOWN = {
    "1faef5301d78db7dda502fe59966957ec4b79dd64e16f03ed96913c7a4eb68d6": Known(
        "LaMa, lama_fp32.onnx", "huggingface.co/Carve/LaMa-ONNX", "Apache-2.0"
    ),
    "7df918ac3921d3daf0aae1d219776cf0dc4e4935f035af81841b40adcf74fdf2": Known(
        "LaMa, inpainting_lama_2025jan.onnx", "github.com/opencv/opencv_zoo, models/inpainting_lama", "Apache-2.0"
    ),
    "de31ffa5ba26916b8ea35319f6c12151ff9654d4261bccf0583a69bb095315f9": Known(
        "LaMa for drawings, lama-manga-dynamic.onnx",
        "huggingface.co/ogkalu/lama-manga-onnx-dynamic",
        "not confirmed: ask its author",
    ),
    "6f1f3530a1a2324b19752018ce756088b07973cda8d7d890034ace5c8a48c40b": Known(
        "MI-GAN, migan_pipeline_v2.onnx",
        "huggingface.co/andraniksargsyan/migan, of github.com/Picsart-AI-Research/MI-GAN",
        "MIT",
    ),
}
"""Published files by their sha256."""


def folder() -> Path:
    """Where models are recorded: $PAVEMARK_MODELS, else $XDG_DATA_HOME/pavemark/models, else below ~/.local/share."""
    own, general = os.environ.get("PAVEMARK_MODELS"), os.environ.get("XDG_DATA_HOME")
    if own:
        return Path(own)
    return (Path(general) if general else Path("~/.local/share").expanduser()) / "pavemark" / "models"


def names() -> tuple[str, ...]:
    """Names of the recorded models, sorted."""
    return tuple(sorted(path.stem for path in folder().glob("*.json") if _NAME.fullmatch(path.stem)))


def read(name: str) -> Model:
    """A recorded model.

    Raises
    ------
    InputError
        When there is none of that name, or its record is damaged.
    """
    path = _path(name)
    model = from_json(Model, path)
    if model.name != name:
        raise InputError(path, f"name = {model.name!r}: allowed is {name!r}, as the file is called")
    return model


def shipped() -> Model:
    """Our own network.

    Raises
    ------
    InputError
        When its file is missing.
    """
    path = assets.path("models/inpainter.onnx")
    white = CONTRACTS["pavemark"].white
    return Model(
        name=SHIPPED,
        file=str(path),
        sha256=onnx.sha256(path),
        bytes=path.stat().st_size,
        contract="pavemark",
        white=white,
        licence="GPL-3.0-or-later",
    )


def add(file: Path, name: str | None, licence: str | None, reserved: Collection[str]) -> Model:
    """Record a model, once it was opened and has shown that it does what its kind does.

    Parameters
    ----------
    file : Path
    name : str or None
        None takes the file's, without its extension.
    licence : str or None
        A note; None takes what is known of a published file.
    reserved : collection of str
        Names that are not to be had.

    Raises
    ------
    InputError
        When the file is of no known kind, or the name is taken or none.
    """
    file = Path(file).absolute()
    name = file.stem if name is None else name
    if not _NAME.fullmatch(name):
        raise InputError("--name", f"{name!r}: allowed are up to 64 letters, digits, '.', '_' and '-', no sign first")
    if name in reserved or name in names():
        raise InputError("--name", f"{name!r} is taken: another one is allowed")
    if licence is not None and licence != one_line(licence):
        raise InputError("--licence", f"{one_line(licence)}: a line of printable text is allowed")
    network = onnx.opened(file)
    contract = recognised(network)
    known = KNOWN.get(network.sha256)
    model = Model(
        name=name,
        file=str(file),
        sha256=network.sha256,
        bytes=file.stat().st_size,
        contract=contract.name,
        white=measured_white(network, contract),
        licence=licence if licence is not None else known.licence if known else "",
    )
    files.write(folder() / f"{name}.json", to_json(model))
    return model


def remove(name: str) -> None:
    """Forget a model; its file stays where it is.

    Raises
    ------
    InputError
        When there is none of that name, or its record cannot be removed.
    """
    path = _path(name)
    try:
        path.unlink()
    except OSError as error:
        raise InputError(path, f"cannot be removed: {error.strerror}") from None


def verify(model: Model) -> None:
    """Hold a model's file against its record.

    Raises
    ------
    InputError
        When the file has gone or has changed.
    """
    again = f"model {model.name!r} was recorded from it; pavemark models remove {model.name}, then add its file anew"
    if not Path(model.file).is_file():
        raise InputError(model.file, f"is missing: {again}")
    now = onnx.sha256(Path(model.file))
    if now != model.sha256:
        raise InputError(model.file, f"has changed, sha256 was {model.sha256[:12]}… and is {now[:12]}…: {again}")


def checked(model: Model) -> onnx.Network:
    """The network of a model, its file held against the record.

    Raises
    ------
    InputError
        As `verify`, or when it is not of the kind that the record says.
    """
    verify(model)
    network = onnx.opened(Path(model.file))
    if recognised(network).name != model.contract:
        raise InputError(model.file, f"is of the kind {recognised(network).name}: {model.contract} is recorded")
    return network


def _path(name: str) -> Path:
    if name not in names():
        known = ", ".join(names()) or "none, as long as pavemark models add FILE has recorded none"
        raise InputError(f"model {name!r}", f"is not recorded: allowed {known}")
    return folder() / f"{name}.json"
