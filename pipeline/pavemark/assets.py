"""Where the files that ship with Pavemark are: presets, palettes, the fitted layout."""

from __future__ import annotations

from pathlib import Path

from pavemark.errors import InputError

_WHEEL, _CHECKOUT = Path(__file__).with_name("shipped"), Path(__file__).parents[2] / "assets"
_FOLDER = _WHEEL if _WHEEL.is_dir() else _CHECKOUT


def path(name: str) -> Path:
    """The path of a shipped file, given relative to the assets folder, such as "presets/default.toml".

    Raises
    ------
    InputError
        When there is no such file.
    """
    found = _FOLDER / name
    if not found.is_file():
        raise InputError(found, "is missing: it ships with Pavemark")
    return found
