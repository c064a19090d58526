"""The study file: real images and how their places are split, the synthetic pools, and the rows to train."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import attrs

from pavemark.errors import InputError
from pavemark.records import one_of, structure, within
from pavemark.select.choice import LIKE_REAL, STRATEGIES

LEARNABLE = "learnable"
"""The strategy that goes by both losses."""

ALL = "all"
"""Every image of the pools, as they are."""

LAST_SEED = 2**32 - 1

FINEST = 1000.0
"""Pixels per metre that a detector may look at."""

REFERENCE, LEARNER = "reference", "learner"

_share = within(0.0, 1.0)


@attrs.frozen
class Places:
    """Places of the real images: frames of one place are alike, so that no place is in two parts.

    Attributes
    ----------
    train, validation, test : tuple of str
        Validation chooses the confidence that counts as found; test is looked at for results alone.
    """

    train: tuple[str, ...]
    validation: tuple[str, ...]
    test: tuple[str, ...]

    def __attrs_post_init__(self) -> None:
        listed = [*self.train, *self.validation, *self.test]
        twice = sorted({place for place in listed if listed.count(place) > 1})
        if twice:
            raise ValueError(f"{twice[0]!r} is listed twice: a place is allowed in one part, once")
        for part in ("train", "validation", "test"):
            if not getattr(self, part):
                raise ValueError(f"{part} = []: at least one place is needed")


@attrs.frozen
class Training:
    """How every detector of the study is trained.

    Attributes
    ----------
    family : str
    steps, fine_tune_steps : int
        Of a row; and those that follow on real images where a row says so, at a tenth of the learning rate.
    batch : int
    """

    family: str = attrs.field(default="dmpr", validator=one_of("dmpr"))
    steps: int = attrs.field(default=1500, validator=within(1, 10**7))
    fine_tune_steps: int = attrs.field(default=500, validator=within(1, 10**7))
    batch: int = attrs.field(default=32, validator=within(2, 4096))


@attrs.frozen
class Row:
    """What a detector learns from; a training run for each of the seeds.

    Attributes
    ----------
    name : str
    table : str
        Heading of the table that it stands in.
    real : float
        Share of the real images of the train places.
    pools : tuple of str
        Synthetic images to choose from.
    strategy : str
        How: "all", or a strategy of `pavemark select`.
    keep : int or None
        How many.
    scored_by : str
        Whose losses the strategy goes by: the "reference" has learned from real images, the "learner" from synthetic
        ones at random, so that what it cannot tell is either rare or labelled otherwise than it looks.
    parts : int
        Detectors, each trained on its part of what was chosen; more than one vote.
    fine_tune : bool
        Whether training ends on the real images alone.
    cap_per_plate : int or None
        Most images of one plate.
    drop_hardest : float
        Share of the images, of the greatest loss, that are not chosen from.
    near_duplicates : float or None
        Cosine distance of embeddings below which an image is left out.
    seeds : tuple of int
    paper : str
        What the paper reports of the like: "precision / recall".
    """

    name: str
    table: str = "Strategies"
    real: float = attrs.field(default=0.0, validator=_share)
    pools: tuple[str, ...] = ()
    strategy: str = attrs.field(default=ALL, validator=one_of(ALL, *STRATEGIES))
    keep: int | None = attrs.field(default=None, validator=attrs.validators.optional(within(1, 10**9)))
    scored_by: str = attrs.field(default=REFERENCE, validator=one_of(REFERENCE, LEARNER))
    parts: int = attrs.field(default=1, validator=within(1, 1000))
    fine_tune: bool = False
    cap_per_plate: int | None = attrs.field(default=None, validator=attrs.validators.optional(within(1, 10**9)))
    drop_hardest: float = attrs.field(default=0.0, validator=within(0.0, 0.99))
    near_duplicates: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(0.0, 2.0)))
    seeds: tuple[int, ...] = (0,)
    paper: str = ""

    def __attrs_post_init__(self) -> None:
        if not (self.real or self.pools):
            raise ValueError(f"{self.name}: neither real nor pools: a row has to learn from something")
        if self.fine_tune and not (self.real and self.pools):
            raise ValueError(f"{self.name}: fine_tune: both pools, to begin with, and real, to end with, are needed")
        if self.fine_tune and self.parts > 1:
            raise ValueError(f"{self.name}: fine_tune: with parts = {self.parts} it is not allowed")
        if self.strategy == ALL and self.keep is not None:
            raise ValueError(f"{self.name}: keep = {self.keep}: with a strategy it is allowed, and {ALL} keeps all")
        if self.strategy != ALL and (self.keep is None or not self.pools):
            raise ValueError(f"{self.name}: strategy = {self.strategy!r}: pools and keep are needed")
        if self.scored_by == LEARNER and self.strategy in (ALL, LEARNABLE, LIKE_REAL):
            raise ValueError(f"{self.name}: scored_by = {LEARNER!r}: with {self.strategy!r} it is not allowed")
        if not self.seeds or len(set(self.seeds)) < len(self.seeds):
            raise ValueError(f"{self.name}: seeds = {list(self.seeds)}: at least one, and each once, are allowed")
        if min(self.seeds) < 0:
            raise ValueError(f"{self.name}: seeds = {list(self.seeds)}: 0 or more is allowed")
        if max(self.seeds) > LAST_SEED:
            raise ValueError(f"{self.name}: seeds = {list(self.seeds)}: up to {LAST_SEED} is allowed")

    @property
    def learner(self) -> Row | None:
        """Who has yet to learn, where the row goes by its losses: it has learned from as many images at random."""
        if self.strategy == LEARNABLE or self.scored_by == LEARNER:
            return Row(f"learner, {self.keep} at random", pools=self.pools, strategy="random", keep=self.keep)
        return None


@attrs.frozen
class Study:
    """A study.

    Attributes
    ----------
    real : str
        Folder of the real images, with a `labels.jsonl`; relative to the study file.
    height : float
        Metres that the height of a real picture spans.
    frame : tuple of int
        Width and height in pixels in which plates are made and detectors look.
    places : Places
    training : Training
    pools : dict
        Jobs by name, tables as in a job file. Their plates are those of the train places. With `like`, the name of a
        pool before it, one starts from that one's tables.
    every_pool : dict
        What all others start from.
    rows : tuple of Row
    judge : str
        The row whose first detector scores the pools: it has to have learned from real images alone.
    tolerance : float
        Pixels at 600 pixels for 10 m within which a point counts as found (Eq. 3).
    """

    real: str
    height: float = attrs.field(validator=within(0.1, 1000.0))
    frame: tuple[int, int]
    places: Places
    rows: tuple[Row, ...]
    judge: str
    training: Training = attrs.field(factory=Training)
    pools: dict[str, Any] = attrs.field(factory=dict)
    every_pool: dict[str, Any] = attrs.field(factory=dict)
    tolerance: float = attrs.field(default=10.0, validator=within(0.1, 1000.0))

    def __attrs_post_init__(self) -> None:
        if min(self.frame) < 1:
            raise ValueError(f"frame = {list(self.frame)}: width and height in pixels, 1 or more, are allowed")
        if not 1 <= self.scale <= FINEST:
            told = f"height = {self.height:g}: {self.scale:g} pixels a metre of frame = {list(self.frame)}"
            raise ValueError(f"{told}: 1 to {FINEST:g} are allowed")
        for pool, tables in self.pools.items():
            # It is the name of a folder, and begins those of the images in it.
            if pool in ("", ".", "..") or set(pool) & set("/\\:\0"):
                raise ValueError(f"pools: {pool!r}: the name of a folder is allowed")
            if not isinstance(tables, dict):
                raise ValueError(f"pools.{pool} = {tables!r}: a table is allowed")
        names = [row.name for row in self.rows]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"rows: {twice[0]!r} is there twice: one row a name is allowed")
        for row in self.rows:
            for pool in row.pools:
                if pool not in self.pools:
                    raise ValueError(f"{row.name}: pools: {pool!r}: allowed {', '.join(self.pools)}")
        judges = [row for row in self.rows if row.name == self.judge]
        if not judges or judges[0].pools or judges[0].parts > 1:
            raise ValueError(f"judge = {self.judge!r}: the name of a row of real images alone is allowed")

    @property
    def scale(self) -> float:
        """Pixels per metre of the frame."""
        return self.frame[1] / self.height


def read(path: Path, real: Path | None = None) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : Path
        TOML.
    real : Path or None
        Folder of the real images, in place of the file's own.

    Raises
    ------
    InputError
        For a file that cannot be read, an unknown field, or a value that is not allowed.
    """
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"not a TOML file: {error}") from None
    folder = real.absolute() if real is not None else path.parent / str(told.get("real", ""))
    return structure(Study, told | {"real": str(folder)}, path)


def only(study: Study, names: tuple[str, ...]) -> Study:
    """A study of some of its rows alone, and of the one that judges; of all of them where none is named.

    Raises
    ------
    InputError
        When there is no row of a name.
    """
    if not names:
        return study
    there = [row.name for row in study.rows]
    for name in names:
        if name not in there:
            raise InputError("--only", f"{name!r}: allowed {', '.join(there)}")
    return attrs.evolve(study, rows=tuple(row for row in study.rows if row.name in {*names, study.judge}))
