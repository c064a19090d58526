"""Which images are kept: the order of a strategy, and what is left out whatever the strategy."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence

import attrs
import numpy as np

from pavemark.errors import InputError
from pavemark.records import within
from pavemark.select import modifiers, strategies
from pavemark.select.candidate import Candidate
from pavemark.select.like_real import like_real
from pavemark.select.near_duplicates import distinct

LIKE_REAL = "like-real"

STRATEGIES = ("cfds", "ehds", "random", "coverage", "learnable", LIKE_REAL)


@attrs.frozen
class Wanted:
    """What is asked for.

    Attributes
    ----------
    strategy : str
        One of `STRATEGIES`, each a function of `pavemark.select.strategies` or, "like-real", of a module of its own.
    keep : int
        Images.
    seed : int
        What is random in "random" and "coverage" follows from it.
    quantiles : int
        Of the loss, for "coverage".
    learnable : float
        Quantile of the reference's loss beyond which "learnable" keeps nothing.
    drop_hardest : float
        Share of all images, those of most loss, that are not kept whatever the strategy.
    near_duplicates : float or None
        Cosine distance of embeddings below which only the first in the strategy's order is kept.
    cap_per_plate : int or None
        Most images of a plate.
    """

    strategy: str = attrs.field(validator=attrs.validators.in_(STRATEGIES))
    keep: int = attrs.field(validator=attrs.validators.ge(1))
    seed: int = 0
    quantiles: int = attrs.field(default=4, validator=attrs.validators.ge(1))
    learnable: float = attrs.field(default=0.75, validator=within(0, 1))
    drop_hardest: float = attrs.field(default=0.0, validator=within(0, 1))
    near_duplicates: float | None = attrs.field(default=None, validator=attrs.validators.optional(within(0, 2)))
    cap_per_plate: int | None = attrs.field(default=None, validator=attrs.validators.optional(attrs.validators.ge(1)))


def chosen(
    candidates: Sequence[Candidate],
    wanted: Wanted,
    learner: dict[str, float] | None = None,
    embeddings: Callable[[Sequence[str]], np.ndarray] | None = None,
    real: np.ndarray | None = None,
) -> list[Candidate]:
    """The images that are kept, the first to be kept first.

    The hardest are dropped, the strategy orders the rest, and along its order near-duplicates go and plates are
    capped. What is left is dealt anew by "coverage", which is to be even whatever went; then the first are kept.

    Parameters
    ----------
    candidates : sequence of Candidate
        In any order.
    wanted : Wanted
    learner : dict of str to float or None
        Losses under the detector that is to learn, by name: "learnable" needs them.
    embeddings : callable or None
        From names to an array (N, E) float32; `near_duplicates` and "like-real" need it.
    real : ndarray (R, E) float32, or None
        Embeddings of real images by the same detector: "like-real" needs them.

    Raises
    ------
    InputError
        When fewer images are left than are to be kept, or the strategy cannot order them.
    """
    left = modifiers.without_hardest(candidates, wanted.drop_hardest)
    order = _ordered(left, wanted, learner, embeddings, real)
    walk: Iterable[Candidate] = order
    if wanted.near_duplicates is not None:
        order = list(order)
        walk = distinct(order, embeddings([each.name for each in order]), wanted.near_duplicates)
    if wanted.cap_per_plate is not None:
        walk = modifiers.capped(walk, wanted.cap_per_plate)
    if wanted.strategy == "coverage" and walk is not order:
        walk = _ordered(list(walk), wanted, learner, embeddings, real)
    kept = list(itertools.islice(walk, wanted.keep))
    if len(kept) < wanted.keep:
        left = f"{len(kept)} of {len(candidates)} images are left to choose from"
        raise InputError("--keep", f"{wanted.keep}: {left}: at most so many are allowed")
    return kept


def _ordered(
    candidates: Sequence[Candidate],
    wanted: Wanted,
    learner: dict[str, float] | None,
    embeddings: Callable[[Sequence[str]], np.ndarray] | None,
    real: np.ndarray | None,
) -> Iterable[Candidate]:
    orders = {
        "cfds": lambda: strategies.cfds(candidates),
        "ehds": lambda: strategies.ehds(candidates),
        "random": lambda: strategies.random(candidates, wanted.seed),
        "coverage": lambda: strategies.coverage(candidates, wanted.seed, wanted.quantiles),
        "learnable": lambda: strategies.learnable(candidates, learner or {}, wanted.learnable),
        LIKE_REAL: lambda: like_real(
            candidates,
            embeddings([each.name for each in candidates]),
            real,
            # Of a plate near-duplicates go first, and the others may be kept.
            wanted.cap_per_plate if wanted.near_duplicates is None else None,
        ),
    }
    return orders[wanted.strategy]() if candidates else []
