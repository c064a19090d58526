"""What the detectors of a row learn from."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence

import attrs
import numpy as np

from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.select import modifiers, near_duplicates, strategies
from pavemark.select.scores import Candidate, Scores
from pavemark.study.design import ALL, Row
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
    learner : dict of str to Scores
        The same by one that has learned from synthetic images at random; empty where no row asks.
    """

    real: tuple[Example, ...]
    pools: Mapping[str, tuple[Example, ...]]
    scores: Mapping[str, Scores] = attrs.field(factory=dict)
    learner: Mapping[str, Scores] = attrs.field(factory=dict)


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
    order = _ordered(row, data, seed)
    names = [each.name for each in itertools.islice(order, row.keep)]
    if len(names) < row.keep:
        raise InputError(f"rows: {row.name}", f"keep = {row.keep}: there are {len(names)} to keep")
    return [examples[name] for name in names]


def real(row: Row, data: Data, seed: int) -> list[Example]:
    """The real images of a row."""
    return share(data.real, row.real, seed)


def _ordered(row: Row, data: Data, seed: int) -> Iterator[Candidate]:
    found = [each for pool in row.pools for each in _candidates(pool, data.scores[pool], len(row.pools) > 1)]
    found = modifiers.without_hardest(found, row.drop_hardest) if row.drop_hardest else found
    if row.strategy == "learnable":
        learned = [each for pool in row.pools for each in _candidates(pool, data.learner[pool], False)]
        ordered = strategies.learnable(found, {each.name: each.loss for each in learned})
    elif row.strategy in strategies.SEEDED:
        ordered = strategies.STRATEGIES[row.strategy](found, seed)
    else:
        ordered = strategies.STRATEGIES[row.strategy](found)
    order: Iterator[Candidate] = iter(ordered)
    if row.near_duplicates:
        order = near_duplicates.distinct(ordered, _embeddings(ordered, row.pools, data.scores), row.near_duplicates)
    return modifiers.capped(order, row.cap_per_plate) if row.cap_per_plate else order


def _candidates(pool: str, scores: Scores, several: bool) -> list[Candidate]:
    """The candidates of a pool; where there are several pools each is a domain."""
    return [
        attrs.evolve(each, name=f"{pool}/{each.name}", domain=pool if several else each.domain)
        for each in scores.candidates
    ]


def _embeddings(ordered: Sequence[Candidate], pools: Sequence[str], scores: Mapping[str, Scores]) -> np.ndarray:
    rows = {}
    for pool in pools:
        names = [each.name.removeprefix(f"{pool}/") for each in ordered if each.name.startswith(f"{pool}/")]
        rows |= {f"{pool}/{name}": seen for name, seen in zip(names, scores[pool].embeddings(names), strict=True)}
    return np.array([rows[each.name] for each in ordered])
