"""The scores of a dataset, read for a selection: the embeddings stay on the disk until they are asked for."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark.errors import InputError
from pavemark.select import shards
from pavemark.select.candidate import Candidate
from pavemark.select.shards import Origin


@attrs.frozen(eq=False)
class Scores:
    """The scored images of a folder.

    Attributes
    ----------
    folder : Path
    origin : Origin
        Of all its shards.
    candidates : list of Candidate
        In the order of the dataset.
    """

    folder: Path
    origin: Origin
    candidates: list[Candidate]

    def losses(self) -> dict[str, float]:
        """Losses by name."""
        return {each.name: each.loss for each in self.candidates}

    def embeddings(self, names: Iterable[str]) -> np.ndarray:
        """What images look like to the detector that scored them.

        Parameters
        ----------
        names : iterable of str
            Scored images, each once.

        Returns
        -------
        ndarray (N, E) float32
            In the order of the names. Nothing else is held in memory but one shard.

        Raises
        ------
        ValueError
            For a name that has no score.
        """
        place = {name: number for number, name in enumerate(names)}
        found: np.ndarray | None = None
        lacking = len(place)
        for table, known in self._tables("embedding"):
            wanted = [(place[name], k) for k, name in enumerate(known) if name in place]
            seen = shards.matrix(table)
            if found is None:
                found = np.zeros((len(place), seen.shape[1]), np.float32)
            if wanted:
                to, at = np.array(wanted).T
                found[to] = seen[at]
                lacking -= len(wanted)
        if lacking:
            raise ValueError(f"{lacking} names that have no scores: scored images are allowed")
        return found

    def marks(self, names: Container[str]) -> dict[str, bytes]:
        """What some of the images were when they were scored, see `pavemark.select.origin.mark`, by name."""
        return {
            name: mark
            for table, known in self._tables("mark")
            for name, mark in zip(known, table.column("mark").to_pylist(), strict=True)
            if name in names
        }

    def _tables(self, column: str) -> Iterator[tuple[Any, list[str]]]:
        """The shards with this column, and the names of their rows."""
        for path in shards.there(self.folder).values():
            table = _read(path, ("name", column))
            yield table, table.column("name").to_pylist()


def read(folder: Path) -> Scores:
    """The scores of a folder.

    Raises
    ------
    InputError
        When there are none, a shard is broken, shards are of different detectors or datasets, or an image is scored
        twice.
    """
    found: list[Candidate] = []
    names: set[str] = set()
    origin = None
    for path in shards.there(folder).values():
        table = _read(path, ("name", "loss", "plate", "domain"))
        whose = _origin(path, table)
        origin = origin or whose
        if whose != origin:
            raise InputError(path, "holds scores of another detector, dataset or version than those before it")
        for name, loss, plate, domain in zip(*(column.to_pylist() for column in table.itercolumns()), strict=True):
            if name in names:
                raise InputError(path, f"{name}: is scored twice: once is allowed")
            if not np.isfinite(loss):
                raise InputError(path, f"{name}: loss = {loss}: a finite number is allowed")
            names.add(name)
            found.append(Candidate(name, loss + 0.0, plate, domain))
    if origin is None:
        raise InputError(folder, "holds no scores: a folder that pavemark score wrote is allowed")
    return Scores(folder, origin, found)


def _read(path: Path, columns: tuple[str, ...]):
    try:
        return shards.read(path, columns)
    except shards.Broken as fault:
        raise InputError(path, f"is no whole shard: pavemark score makes it anew ({fault})") from None


def _origin(path: Path, table) -> Origin:
    try:
        return shards.origin_of(path, table)
    except shards.Broken as fault:
        raise InputError(path, str(fault)) from None
