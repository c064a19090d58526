"""Which images there are, and which mask belongs to which: matched by stem, without opening any."""

from __future__ import annotations

import os
from pathlib import Path

import attrs

from pavemark.errors import InputError

EXTENSIONS = (".png", ".jpg", ".jpeg", ".bmp", ".webp", ".tif", ".tiff")


@attrs.frozen
class Entry:
    """An image to work from.

    Attributes
    ----------
    name : str
        The file's stem.
    image : Path
    mask : Path or None
        None where no masks are given: the markings are looked for.
    """

    name: str
    image: Path
    mask: Path | None = None


def index(images: Path, masks: Path | None = None) -> tuple[tuple[Entry, ...], tuple[Path, ...]]:
    """List a folder of images with the masks of another.

    Parameters
    ----------
    images : Path
        Folder; the files directly in it count, not those of its subfolders. Hidden files and files that are not
        images by their extension are passed over. Or one image alone, for which other masks are nothing amiss.
    masks : Path or None
        Folder of PNG masks, each of its image's name.

    Returns
    -------
    entries : tuple of Entry
        Sorted by name, in the order of code points, the same on every file system.
    unmatched : tuple of Path
        With masks given: images without a mask, then masks without an image. They are in no entry.

    Raises
    ------
    InputError
        When a folder is missing, unreadable, no folder or holds no image (no mask), when two images share a stem,
        or when no mask has the name of an image.
    """
    one = images.is_file() and images.suffix.lower() in EXTENSIONS
    found = {images.stem: images} if one else listed(images, EXTENSIONS, "image")
    if masks is None:
        return tuple(Entry(name, found[name]) for name in sorted(found)), ()
    known = listed(masks, (".png",), "PNG mask")
    entries = tuple(Entry(name, found[name], known[name]) for name in sorted(found.keys() & known.keys()))
    if not entries:
        raise InputError(
            masks, f"no mask has the name of an image in {images}: equal names without extension are allowed"
        )
    alone = [found[name] for name in sorted(found.keys() - known.keys())]
    alone += [] if one else [known[name] for name in sorted(known.keys() - found.keys())]
    return entries, tuple(alone)


def listed(folder: Path, extensions: tuple[str, ...], what: str) -> dict[str, Path]:
    """The files of a folder that end in one of the extensions, by stem; `what` they are is told in errors.

    Raises
    ------
    InputError
        When the folder is missing, unreadable, no folder or holds none, or when two share a stem.
    """
    folder = Path(folder)
    try:
        with os.scandir(folder) as entries:
            # A link that leads nowhere is told of when it is read: what it led to may be on a drive that is away.
            names = sorted(
                entry.name
                for entry in entries
                if not entry.name.startswith(".") and (entry.is_file() or (entry.is_symlink() and not entry.is_dir()))
            )
    except OSError as error:
        raise InputError(folder, f"cannot be listed: {error.strerror}; a folder of {what}s is allowed") from None
    found: dict[str, Path] = {}
    for path in (folder / name for name in names):
        if path.suffix.lower() not in extensions:
            continue
        if path.stem in found:
            raise InputError(path, f"{what} has the name of {found[path.stem].name}: one {what} a name is allowed")
        found[path.stem] = path
    if not found:
        raise InputError(folder, f"holds no {what}: files ending in {', '.join(extensions)} are allowed")
    return found
