"""A folder of plates that are made: their files, which hands may have mended, and what is known of each beside them."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from pathlib import Path

import attrs

from pavemark.background.index import Entry, listed
from pavemark.background.reading import read_flags, read_image
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.plate import Plate, Roadside
from pavemark.records import read_json, structure, within
from pavemark.scene import RGB

RECORD, ROWS = "plates.json", "plates.jsonl"
"""With what settings the plates were made; a line of JSON a plate."""

FOLDERS = ("plates", "masks", "ground")
"""Of the files of a plate: RGB; 1 = former marking; 1 = where paint may lie."""


@attrs.frozen(kw_only=True)
class Row:
    """What is known of a plate beside its pixels.

    Attributes
    ----------
    name : str
        Of its files, without extension.
    input : str
        File name of the image it was made from.
    sha256 : str
        Of that file.
    mask : str or None
        SHA-256 of the mask that was given with it, whether or not it was made of that.
    size : tuple of int
        Width and height in pixels.
    ratios, blur, roadside
        As `Plate` has them: measured on the image, in which the markings still were.
    files : dict
        SHA-256 of the plate's files as they were written, by their path in the folder.
    mended : bool
        Whether the plate was made of the folder's own masks, after hands had mended them.
    """

    name: str
    input: str
    sha256: str
    mask: str | None
    size: tuple[int, int]
    ratios: tuple[RGB, ...]
    blur: tuple[tuple[float, ...], ...]
    roadside: Roadside | None
    files: dict[str, str]
    mended: bool = False


def paths(folder: Path, name: str) -> dict[str, Path]:
    """The files of a plate, by the folder they lie in."""
    return {kind: folder / kind / f"{name}.png" for kind in FOLDERS}


def begun(folder: Path, name: str) -> Path:
    """Where the row of a plate lies while its files are written over, until the journal has it."""
    return folder / "plates" / f".{name}.begun"


def halves(folder: Path) -> set[str]:
    """Names of the plates whose files were being written over when a run was killed."""
    return {path.name.removeprefix(".").removesuffix(".begun") for path in (folder / "plates").glob(".*.begun")}


@attrs.frozen(eq=False)
class Stock:
    """A folder of plates.

    Attributes
    ----------
    folder : Path
    scale : float
        Pixels per metre.
    """

    folder: Path
    scale: float
    _rows: dict[str, tuple[int, int]]

    def index(self) -> tuple[tuple[Entry, ...], tuple[Path, ...]]:
        """List the plates, without opening any.

        Returns
        -------
        entries : tuple of Entry
            Plates and their masks of markings, sorted by name. Those that were taken out of the folder are not in it.
        unknown : tuple of Path
            Images among the plates of which no line tells. They are in no entry.

        Raises
        ------
        InputError
            When there is no plate.
        """
        found = listed(self.folder / "plates", (".png",), "plate")
        entries = tuple(
            Entry(name, found[name], paths(self.folder, name)["masks"]) for name in sorted(found) if name in self._rows
        )
        if not entries:
            raise InputError(self.folder / ROWS, "tells of no plate that is there: pavemark plates makes them")
        return entries, tuple(found[name] for name in sorted(found.keys() - self._rows.keys()))

    def plate(self, name: str) -> Plate:
        """A plate as its files are now; `source` is the plate itself.

        Raises
        ------
        InputError
            When one of its files is missing, damaged, of another size than the plate was made or, a mask, holds other
            values than 0, and 1 or 255.
        """
        row = self.row(name)
        files = paths(self.folder, name)
        pixels = read_image(files["plates"])
        size = (pixels.shape[1], pixels.shape[0])
        if size != row.size:
            now, then = (f"{width}×{height}" for width, height in (size, row.size))
            raise InputError(files["plates"], f"plate is {now} pixels: it was made {then}, for which its scale holds")
        markings, ground = (read_flags(files[kind], pixels.shape[:2]) for kind in ("masks", "ground"))
        for array in (pixels, markings, ground):
            array.setflags(write=False)
        return Plate(
            name=name,
            frame=Frame(*size, self.scale),
            image=pixels,
            ground=ground,
            markings=markings & ground,
            source=pixels,
            ratios=row.ratios,
            roadside=row.roadside,
            blur=row.blur,
        )

    def row(self, name: str) -> Row:
        """What is known of a plate.

        Raises
        ------
        InputError
            When no line tells of it, or not as it should.
        """
        path = self.folder / ROWS
        if name not in self._rows:
            raise InputError(path, f"has no line of {name}")
        start, end = self._rows[name]
        try:
            with path.open("rb") as stream:
                stream.seek(start)
                data = json.loads(stream.read(end - start))
        except OSError as error:
            raise InputError(path, f"cannot be read: {error.strerror}") from None
        except (ValueError, RecursionError) as error:
            raise InputError(path, f"the line of {name} is not JSON: {error}") from None
        return structure(Row, data, path)


def stock(folder: Path) -> Stock:
    """Open a folder of plates.

    Raises
    ------
    InputError
        When it is none, or its record or its rows cannot be read.
    """
    try:
        there = (folder / ROWS).stat()
    except OSError as error:
        raise InputError(
            folder / ROWS, f"cannot be read: {error.strerror}; pavemark plates writes it when it ends"
        ) from None
    return _opened(folder, (there.st_mtime_ns, there.st_size))


@attrs.frozen
class _Record:
    scale: float = attrs.field(validator=within(1.0, 10000.0))


# A name is the first field of its line, so that 40,000 lines need not be parsed to find one.
_LINE = re.compile(rb'\{"name": ("(?:[^"\\]|\\.)*"), ("refused": )?.*\}\n')


# Each image of a job asks for its plate. The stamp tells a folder to which plates have been added since.
@lru_cache(maxsize=1)
def _opened(folder: Path, stamp: tuple[int, int]) -> Stock:
    record, path = read_json(folder / RECORD), folder / ROWS
    scale = record.get("scale") if isinstance(record, dict) else None
    rows, start = {}, 0
    try:
        with path.open("rb") as stream:
            for number, line in enumerate(stream, 1):
                match = _LINE.fullmatch(line)
                if match is None:
                    raise InputError(path, f"line {number} does not tell of a plate: it is written by pavemark plates")
                if match[2] is None:
                    rows[json.loads(match[1])] = (start, start + len(line))
                start += len(line)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    return Stock(folder, structure(_Record, {"scale": scale}, folder / RECORD).scale, rows)
