"""The one place where a clock is read: how long things took is reported, and never decides what is made."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


def now() -> float:
    """Seconds from an arbitrary start."""
    return time.perf_counter()


class Timings:
    """Seconds spent by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time a stage of the work."""
        start = now()
        yield
        self.seconds[name] = round(now() - start, 4)
