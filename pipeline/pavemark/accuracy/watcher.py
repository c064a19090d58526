"""Who is told how a stage goes."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Protocol


class Watcher(Protocol):
    """`pavemark.job.progress.Progress` is one."""

    def of(self, total: int) -> AbstractContextManager:
        """Entered while so many are worked on."""
        ...

    def step(self, lacking: bool) -> None:
        """One is done, or something of it will be lacking."""
        ...

    def tell(self, line: str) -> None:
        """Report what went wrong."""
        ...
