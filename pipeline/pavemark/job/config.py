"""The job file: what is to be made. Preset, then job file, then command line; the later one counts."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import attrs

from pavemark.background import inpainting
from pavemark.background.finding import SEGMENTERS
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError
from pavemark.randomize.domains import Domains, preset
from pavemark.records import one_of, structure, within

FORMATS = ("dmpr", "ps2", "coco", "yolo")
PRESETS = ("default", "paper")
PIXELS_PER_METRE = 60.0
FOLDERS = ("images", "masks", "plates")
PATHS = (*FOLDERS, "calibration")
COMMAND_LINE = "command line"

_SCALE = {"scale", "metres_per_pixel"}
_MADE_FROM = {"images", "masks", "mask", "inpainter", "segmenter"}
_OTHER_WAYS = ((_SCALE, _SCALE), ({"plates"}, _MADE_FROM), ({"images"}, {"plates"}))
"""Fields of the command line, and those of the job file that say the same another way and then count no more."""


def _distinct(instance: Any, attribute: attrs.Attribute, value: tuple[str, ...]) -> None:
    if len(set(value)) < len(value):
        raise ValueError(f"{attribute.name} = {list(value)}: each format once is allowed")


def _usable(instance: Any, attribute: attrs.Attribute, name: str) -> None:
    # The file of a model is held against its record here, before any image is opened.
    try:
        inpainting.inpainter(name)
    except InputError as error:
        raise ValueError(str(error)) from None


# Beside `Domains` a record has room for one more parent that lays its fields out in a fixed order.
@attrs.frozen(kw_only=True, slots=False)
class Inputs:
    """Real AVM images, and how plates are made of them.

    Attributes
    ----------
    images : str or None
        Their folder. None where the plates are made already.
    masks : str or None
        Folder of their marking masks, PNGs of the same names; None finds the markings in the images.
    scale : float or None
        Pixels per metre of the images. Neither this nor `metres_per_pixel`: 60, so that 600 px are 10 m.
    metres_per_pixel : float or None
        The same the other way round.
    inpainter : str
        What fills the ground where markings were.
    segmenter : str
        What finds the markings, and the ground, of images without masks.
    mask : MaskTable
        What the values of a mask mean.
    """

    images: str | None = None
    masks: str | None = None
    scale: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(1.0, 10000.0)))
    metres_per_pixel: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(0.0001, 1.0)))
    inpainter: str = attrs.field(default="patchmatch", validator=_usable)
    segmenter: str = attrs.field(default="network", validator=one_of(*SEGMENTERS))
    mask: MaskTable = attrs.field(factory=MaskTable)

    def __attrs_post_init__(self) -> None:
        if self.scale is not None and self.metres_per_pixel is not None:
            raise ValueError("scale and metres_per_pixel are both given: one of them is allowed")

    @property
    def pixels_per_metre(self) -> float:
        """The scale, however it was given."""
        if self.metres_per_pixel is not None:
            return 1 / self.metres_per_pixel
        return PIXELS_PER_METRE if self.scale is None else self.scale


@attrs.frozen(kw_only=True)
class Job(Domains, Inputs):
    """A job: what it starts from, how many images it makes of that, and the domains it draws from.

    Attributes
    ----------
    plates : str or None
        Folder of plates that are made already, in place of `images`.
    count : int
        Synthetic images to make.
    seed : int
        Everything random follows from it.
    preset : str
        Settings of the domains to start from.
    formats : tuple of str
        Label formats to write.
    max_error : float or None
        Most that edges of markings may be off in an image, in 8-bit levels: each image is rendered with the fewest
        rays that a table promises this of, see `pavemark.calibration`. None: one ray a pixel. Light has its own.
    calibration : str or None
        File of that table. None: the one that ships.
    """

    plates: str | None = None
    count: int = attrs.field(default=200, validator=within(1, 10**9))
    seed: int = attrs.field(default=0, validator=within(0, 2**63 - 1))
    preset: str = attrs.field(default="default", validator=one_of(*PRESETS))
    formats: tuple[str, ...] = attrs.field(default=FORMATS, validator=[one_of(*FORMATS), _distinct])
    max_error: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(0.0, 255.0)))
    calibration: str | None = None


def read_inputs(options: dict[str, Any]) -> Inputs:
    """Read what plates are made of, and how.

    Parameters
    ----------
    options : dict
        What the command line says, as a job file would say it. Its folders are relative to the working directory.

    Raises
    ------
    InputError
        For an unknown field, or a value that is not allowed.
    """
    return structure(Inputs, _absolute(options, Path.cwd()), COMMAND_LINE)


def read(path: Path | None, options: dict[str, Any]) -> Job:
    """Read a job.

    Parameters
    ----------
    path : Path or None
        The job file, TOML. The folders it names are relative to it.
    options : dict
        What the command line says, as the job file would say it. Its folders are relative to the working directory.

    Raises
    ------
    InputError
        For a file that cannot be read, an unknown field, or a value that is not allowed.
    """
    # Alone first, so that a bad option is not blamed on the job file.
    _hold_apart(options, COMMAND_LINE)
    structure(Job, options, COMMAND_LINE)
    told = {} if path is None else _absolute(_toml(path), path.parent)
    where = path or COMMAND_LINE
    _hold_apart(told, where)
    for one, others in _OTHER_WAYS:
        if options.keys() & one:
            told = {name: value for name, value in told.items() if name not in others}
    chosen = merge(told, _absolute(options, Path.cwd()))
    _hold_apart(chosen, where)
    if not chosen.keys() & {"images", "plates"}:
        raise InputError(where, "images is missing: a folder of AVM images is needed (--images DIR)")
    name = chosen.get("preset", "default")
    if name not in PRESETS:
        raise InputError(where, f"preset = {name!r}: allowed {', '.join(PRESETS)}")
    return structure(Job, merge(preset(name), chosen), where)


def _hold_apart(data: dict[str, Any], where: object) -> None:
    made = sorted(data.keys() & _MADE_FROM) if "plates" in data else []
    if made:
        raise InputError(where, f"{', '.join(made)} and plates are given: plates are made already, they stand alone")


def merge(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Tables merged field by field, however deep; where both name a value, the upper one counts."""
    merged = dict(below)
    for name, value in above.items():
        under = merged.get(name)
        merged[name] = merge(under, value) if isinstance(under, dict) and isinstance(value, dict) else value
    return merged


def toml(data: dict[str, Any], above: str = "") -> str:
    """Tables of a job file as its text, a line a field.

    Examples
    --------
    >>> print(toml({"count": 3, "noise": {"rate": 0.5}}), end="")
    count = 3
    noise.rate = 0.5
    """
    # What JSON writes of words, numbers and lists is TOML too.
    return "".join(
        toml(value, f"{above}{name}.") if isinstance(value, dict) else f"{above}{name} = {json.dumps(value)}\n"
        for name, value in data.items()
        if value is not None
    )


def setting(text: str) -> dict[str, Any]:
    """A setting as a job file would hold it: ``noise.rate = 0.2``.

    Examples
    --------
    >>> setting("noise.rate = 0.2")
    {'noise': {'rate': 0.2}}
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(
            "--set", f"{text!r}: allowed is a line of a job file, like 'noise.rate = 0.2' ({error})"
        ) from None


def _toml(path: Path) -> dict[str, Any]:
    try:
        # Editors of some systems put a byte order mark before the text.
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"not a TOML file: {error}") from None


def _absolute(data: dict[str, Any], base: Path) -> dict[str, Any]:
    paths = {name: str((base / data[name]).absolute()) for name in PATHS if isinstance(data.get(name), str)}
    return {**data, **paths}
