"""Images and masks from files, each kind of bad file refused with a line of its own.

OpenImageIO judges a file by its header, so that nothing large is decoded before it is known to be wanted.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import attrs
import numpy as np
import OpenImageIO as oiio

from pavemark.errors import InputError
from pavemark.records import within

SMALLEST, LARGEST = 8, 16384
"""Pixels a side, as `Frame` allows them."""

_PNG = b"\x89PNG\r\n\x1a\n"


@attrs.frozen
class MaskTable:
    """What the values of a mask mean: the job file's `[mask]` table.

    Without a table 1 is a marking, 0 is ground, and any other value is a mistake that is reported. Masks that know
    more need a table. In a mask of 0 = everything else, 1 = slot line, 3 = lane line, both lines are markings::

        [mask]
        marking = [1, 3]

    In a mask of 0 = ground, 1 = marking, 2 = cars and walls, paint may lie on 0 (and 1) only::

        [mask]
        ground = [0]

    Attributes
    ----------
    marking : tuple of int
        Values (0–255) of the markings, which are taken off the ground.
    ground : tuple of int or None
        Values of the bare ground. Where they are listed the mask is believed: every value in neither list is not
        ground, and the ego car is not looked for. None stands for 0 where everything in the picture, except the
        ego car that is looked for, is ground; a value that is neither 0 nor a marking is then refused.
    """

    marking: tuple[int, ...] = attrs.field(default=(1,), validator=within(0, 255))
    ground: tuple[int, ...] | None = attrs.field(default=None)

    @ground.validator
    def _apart(self, attribute: attrs.Attribute, value: tuple[int, ...] | None) -> None:
        within(0, 255)(self, attribute, value or ())
        both = sorted(set(self.marking) & set((0,) if value is None else value))
        if both:
            raise ValueError(f"ground = {both[0]} is a marking too: a value is allowed in one list only")


@attrs.frozen(eq=False)
class Classes:
    """A mask, read.

    Attributes
    ----------
    marking : ndarray (H, W) bool
    ground : ndarray (H, W) bool
        Bare ground or marking: where paint may lie.
    """

    marking: np.ndarray
    ground: np.ndarray


def read_image(path: Path) -> np.ndarray:
    """Read an image.

    Returns
    -------
    ndarray (H, W, 3) uint8
        Display sRGB, channels R, G, B, pixels as stored: no colour profile, no orientation tag is applied.

    Raises
    ------
    InputError
        When the file is missing, not an image, damaged, not 8-bit RGB, or not 8 to 16384 pixels a side.
    """
    pixels = _pixels(path)
    if pixels.shape[2] != 3:
        kind = {1: "grey", 2: "grey with alpha", 4: "with alpha"}.get(pixels.shape[2], f"{pixels.shape[2]} channels")
        raise InputError(path, f"image is {kind}: 8-bit RGB is allowed")
    return pixels


def read_mask(path: Path, table: MaskTable, shape: tuple[int, int]) -> Classes:
    """Read a mask.

    Parameters
    ----------
    path : Path
        An 8-bit PNG, grey or with three equal channels. Formats with losses would blur the values.
    table : MaskTable
        What its values mean.
    shape : tuple of int
        (H, W) of its image.

    Raises
    ------
    InputError
        When it cannot be read, is not such a PNG, is of another size or holds a value the table does not know.
    """
    values = _values(path, shape)
    marking = np.isin(values, table.marking)
    ground = marking | np.isin(values, (0,) if table.ground is None else table.ground)
    if table.ground is None and not ground.all():
        known = ", ".join(map(str, table.marking))
        other = values[~ground].min()
        raise InputError(
            path,
            f"mask value {other}: allowed are 0 (ground), {known} (marking); "
            f"others need a [mask] table in the job file, such as marking = [{other}] or ground = [0]",
        )
    return Classes(marking, ground)


def read_flags(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """Read a mask of 0 and 1, or 255, the white of an editor, for 1.

    Parameters
    ----------
    path : Path
        As for `read_mask`.
    shape : tuple of int
        (H, W) of its image.

    Returns
    -------
    ndarray (H, W) bool

    Raises
    ------
    InputError
        When it cannot be read, is not such a PNG, is of another size or holds another value.
    """
    values = _values(path, shape)
    flags = values > 0
    others = values[flags & (values != 1) & (values != 255)]
    if len(others):
        raise InputError(path, f"mask value {others.min()}: allowed are 0, and 1 or 255")
    return flags


def _values(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """The values (H, W) uint8 of a mask."""
    data = _bytes(path)
    if not data.startswith(_PNG):
        raise InputError(path, "mask is not a PNG: an 8-bit grey PNG is allowed")
    if data[25:26] == b"\x03":
        raise InputError(path, "mask is a PNG with a palette, which hides its values: an 8-bit grey PNG is allowed")
    if data[24:25] != b"\x08":
        raise InputError(path, f"mask has {data[24] if len(data) > 24 else 0} bits a value: 8 bits are allowed")
    pixels = _pixels(path)
    values = pixels[..., 0]
    if pixels.shape[2] not in (1, 3) or (pixels != values[..., None]).any():
        raise InputError(path, "mask has colours or alpha: an 8-bit grey PNG is allowed")
    if values.shape != tuple(shape):
        given, wanted = (f"{width}×{height}" for height, width in (values.shape, shape))
        raise InputError(path, f"mask is {given} pixels: its image is {wanted}")
    return values


def _pixels(path: Path) -> np.ndarray:
    """Pixels (H, W, C) uint8 of a file that is whole and of an allowed size."""
    # libpng reports a damaged file on stderr by itself; one that is judged beforehand costs the user no second line.
    data = _bytes(path)
    if data.startswith(_PNG) and not _whole(data):
        raise InputError(path, "image is truncated or damaged: a whole file is allowed")
    try:
        source = oiio.ImageInput.open(str(path))
    except TypeError:
        raise InputError(path, "its name is not UTF-8, which OpenImageIO asks for") from None
    if source is None:
        raise InputError(path, f"not an image: {_line(oiio.geterror())}")
    spec = source.spec()
    if not (SMALLEST <= spec.width <= LARGEST and SMALLEST <= spec.height <= LARGEST):
        raise InputError(
            path, f"image is {spec.width}×{spec.height} pixels: {SMALLEST} to {LARGEST} pixels a side are allowed"
        )
    if spec.format != oiio.UINT8:
        raise InputError(path, f"image has {spec.format} values: 8 bits a channel are allowed")
    pixels = source.read_image(0, 0, 0, spec.nchannels, oiio.UINT8)
    fault = source.geterror()
    source.close()
    if pixels is None or fault:
        raise InputError(path, f"image is truncated or damaged: {_line(fault)}")
    return pixels.reshape(spec.height, spec.width, spec.nchannels)


def _bytes(path: Path) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None


def _whole(data: bytes) -> bool:
    """Whether a PNG has all its chunks, undamaged, to the last."""
    at, kind = len(_PNG), b""
    while kind != b"IEND":
        if at + 12 > len(data):
            return False
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 8 + length
        if end + 4 > len(data) or zlib.crc32(data[at + 4 : end]) != struct.unpack_from(">I", data, end)[0]:
            return False
        at = end + 4
    return True


def _line(fault: str) -> str:
    return fault.strip().splitlines()[0] if fault.strip() else "no reason is given"
