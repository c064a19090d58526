"""What is left out whatever the strategy: the hardest images, near-duplicates, and more than so many of a plate."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from pavemark.errors import InputError
from pavemark.select.candidate import Candidate
from pavemark.select.ranking import ranked


def exact(share: float) -> Fraction:
    """A share as the decimal number that it is written as: 0.29 of 100 are 29, and not a little less."""
    return Fraction(repr(float(share)))


def without_hardest(candidates: Sequence[Candidate], share: float) -> list[Candidate]:
    """Candidates, in their order, less the share of most loss, rounded down; of equal losses the last names go."""
    order = ranked([[(each.loss, each.name) for each in candidates]])
    gone = {name for _, name in order[len(order) - math.floor(exact(share) * len(order)) :]}
    return [each for each in candidates if each.name not in gone]


def capped(candidates: Iterable[Candidate], most: int) -> Iterator[Candidate]:
    """Candidates, in their order, less those whose plate has given `most` already.

    Raises
    ------
    InputError
        For an image of which no plate is known.
    """
    given: Counter[str] = Counter()
    for each in candidates:
        if each.plate is None:
            raise InputError("--cap-per-plate", f"the plate of {each.name} is not known: scores with plates are needed")
        given[each.plate] += 1
        if given[each.plate] <= most:
            yield each
