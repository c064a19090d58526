"""The order of images by their loss: the same whatever the shards, the order and the platform."""

from __future__ import annotations

import math
from collections.abc import Iterable

Scored = tuple[float, str]
"""An image's loss, and its name."""


def ranked(shards: Iterable[Iterable[Scored]]) -> list[Scored]:
    """All images of all shards, least loss first; of equal losses by name, compared code point by code point.

    Parameters
    ----------
    shards : iterable of iterable of (loss, name)

    Raises
    ------
    ValueError
        When a loss is not finite, or a name stands twice: an image scored by two shards would count twice.
    """
    order: list[Scored] = []
    names: set[str] = set()
    for loss, name in (each for shard in shards for each in shard):
        if not math.isfinite(loss):
            raise ValueError(f"{name}: loss = {loss}: a finite number is allowed")
        if name in names:
            raise ValueError(f"{name}: is scored twice: once is allowed")
        names.add(name)
        # Nought has two signs, which are equal and yet two texts.
        order.append((loss + 0.0, name))
    return sorted(order)
