"""What the detectors of a row learn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.select.candidate import Candidate
from pavemark.select.choice import Wanted, chosen
from pavemark.select.scores import Scores
from pavemark.study.design import ALL, LEARNABLE, LEARNER, Row
from pavemark.study.places import share


@attrs.frozen(eq=False)
class Data:
    """All that rows learn from.

    Attributes
    ----------
    real : tuple of Example
        Of the train places.
    pools : dict of str to tuple of Example
        `Example.name` begins with that of its pool.
    scores : dict of str to Scores
        Of the pools, by a detector that has learned from real images.
    learners : dict of Row to dict of str to Scores
        The same by each `Row.learner`.
    seen : ndarray (R, E) or None
        What `real` looks like to who scored the pools; None where no row asks.
    """

    real: tuple[Example, ...]
    pools: Mapping[str, tuple[Example, ...]]
    scores: Mapping[str, Scores] = attrs.field(factory=dict)
    learners: Mapping[Row, Mapping[str, Scores]] = attrs.field(factory=dict)
    seen: np.ndarray | None = None


def synthetic(row: Row, data: Data, seed: int) -> list[Example]:
    """The synthetic images of a row, in the order in which they are chosen.

    Raises
    ------
    InputError
        When there are fewer than the row wants to keep.
    """
    examples = {example.name: example for pool in row.pools for example in data.pools[pool]}
    if row.strategy == ALL:
        return list(examples.values())
    wanted = Wanted(
        row.strategy,
        row.keep,
        seed,
        drop_hardest=row.drop_hardest,
        near_duplicates=row.near_duplicates,
        cap_per_plate=row.cap_per_plate,
    )
    scores = data.learners[row.learner] if row.scored_by == LEARNER else data.scores
    found = _candidates(row.pools, scores)
    learner = None
    if row.strategy == LEARNABLE:
        learner = {each.name: each.loss for each in _candidates(row.pools, data.learners[row.learner])}

    def embeddings(names: Sequence[str]) -> np.ndarray:
        return _embeddings(names, row.pools, scores)

    try:
        return [examples[each.name] for each in chosen(found, wanted, learner, embeddings, data.seen)]
    except InputError as error:
        raise InputError(f"rows: {row.name}", str(error)) from None


def real(row: Row, data: Data, seed: int) -> list[Example]:
    """The real images of a row."""
    return share(data.real, row.real, seed)


def _candidates(pools: Sequence[str], scores: Mapping[str, Scores]) -> list[Candidate]:
    """The candidates of pools; where there are several each is a domain."""
    return [
        attrs.evolve(each, name=f"{pool}/{each.name}", domain=pool if len(pools) > 1 else each.domain)
        for pool in pools
        for each in scores[pool].candidates
    ]


def _embeddings(wanted: Sequence[str], pools: Sequence[str], scores: Mapping[str, Scores]) -> np.ndarray:
    rows = {}
    for pool in pools:
        names = [name.removeprefix(f"{pool}/") for name in wanted if name.startswith(f"{pool}/")]
        rows |= {f"{pool}/{name}": seen for name, seen in zip(names, scores[pool].embeddings(names), strict=True)}
    return np.array([rows[name] for name in wanted])
