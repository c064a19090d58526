"""Where the files that ship with Pavemark are: presets, palettes, the fitted layout."""

from __future__ import annotations

from pathlib import Path

from pavemark.errors import InputError

_FOLDER = Path(__file__).parents[2] / "assets"


def path(name: str) -> Path:
    """The path of a shipped file, given relative to the assets folder, such as "presets/default.toml".

    Raises
    ------
    InputError
        When there is no such file.
    """
    found = _FOLDER / name
    if not found.is_file():
        raise InputError(found, "is missing: it ships in the assets folder beside the source of Pavemark")
    return found
