"""Nothing is learned from what is judged by: no picture, and no plate that was made of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from pavemark.detect.example import Example
from pavemark.detect.reading import manifest
from pavemark.errors import InputError
from pavemark.study.runs import picture_hash


def hold_apart(parts: Mapping[str, Iterable[Example]]) -> None:
    """Hold that no picture is in two parts, be it under another name or a copy.

    Parameters
    ----------
    parts : dict of str to iterable of Example
        By what a part is called.

    Raises
    ------
    InputError
        When one is, or cannot be read.
    """
    seen: dict[str, tuple[str, Path]] = {}
    for part, examples in parts.items():
        for example in examples:
            there, other = seen.setdefault(picture_hash(example.image), (part, example.image))
            if there != part:
                raise InputError(
                    example.image, f"is of {part}, and the same picture as {other}, of {there}: one part is allowed"
                )


def hold_no_plate(dataset: Path, judged: Iterable[Example]) -> None:
    """Hold that no image of a dataset is on a plate that was made of an image that is judged by.

    A plate is called as the image it was made of. Where an image that is judged by was painted on a plate itself, it is
    that plate that counts.

    Parameters
    ----------
    dataset : Path
    judged : iterable of Example

    Raises
    ------
    InputError
        When one is.
    """
    plates = {Path(str(line.get("input", ""))).stem: name for name, line in manifest(dataset)}
    for example in judged:
        plate = Path(example.groups.get("plate") or example.image).stem
        if plate in plates:
            raise InputError(
                dataset,
                f"{plates[plate]}: its plate, {plate}, is that of {example.image}, which is judged by: others may be",
            )
