"""The orders in which images are kept, each a plain function from images in any order to images in its own.

The first to be kept comes first; how many are kept is for the caller to say: ``cfds(candidates)[:24_000]``.
"""

from __future__ import annotations

import hashlib
import math
from collections import defaultdict
from collections.abc import Iterable, Sequence

from pavemark.errors import InputError
from pavemark.select.candidate import Candidate
from pavemark.select.modifiers import exact
from pavemark.select.ranking import ranked


def cfds(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Close to far, as the paper has it (Zhang, Liu, Gao 2026): least loss first, of equal losses by name.

    Examples
    --------
    >>> [each.name for each in cfds([Candidate("b", 0.1), Candidate("c", 0.0), Candidate("a", 0.1)])]
    ['c', 'a', 'b']
    """
    return _by_loss(candidates)


def ehds(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Easy to hard by domain: whole domains, that of the least mean loss first; within one as `cfds`.

    Images of no known domain are a domain of their own. Domains of equal means follow each other by name.

    Raises
    ------
    InputError
        When no image has a domain.
    """
    domains: dict[str, list[Candidate]] = defaultdict(list)
    for each in _by_loss(candidates):
        domains[each.domain or ""].append(each)
    if set(domains) == {""}:
        raise InputError("--strategy ehds", "no image tells its domain: another strategy is allowed")

    def mean(domain: str) -> float:
        return math.fsum(each.loss for each in domains[domain]) / len(domains[domain])

    return [each for domain in sorted(domains, key=lambda domain: (mean(domain), domain)) for each in domains[domain]]


def random(candidates: Sequence[Candidate], seed: int = 0) -> list[Candidate]:
    """Any order: that of a hash of seed and name, so that an image's place depends on no other image."""
    return sorted(candidates, key=lambda each: (_drawn(seed, each.name), each.name))


def coverage(candidates: Sequence[Candidate], seed: int = 0, quantiles: int = 4) -> list[Candidate]:
    """Evenly over how hard images are, their domains and their plates.

    A stratum holds the images of one quantile of the loss, one domain and one plate, in the order of `random`. Round
    after round each stratum that has some left gives one. Within a round, first one stratum of each quantile and
    domain gives, then a second one of each, plates in the order of a hash: where the number to be kept cuts a round
    short, quantiles and domains are even all the same, and no plate comes first everywhere.

    Parameters
    ----------
    candidates : sequence of Candidate
    seed : int
    quantiles : int
        Parts of equal numbers into which the order of `cfds` is cut.
    """
    order = _by_loss(candidates)
    quantile = {each.name: rank * quantiles // len(order) for rank, each in enumerate(order)}
    strata: dict[tuple[int, str, str], list[Candidate]] = defaultdict(list)
    for each in random(order, seed):
        strata[quantile[each.name], each.domain or "", each.plate or ""].append(each)
    plates: dict[tuple[int, str], list[str]] = defaultdict(list)
    for part, domain, plate in strata:
        plates[part, domain].append(plate)
    turn = {
        (*cell, plate): number
        for cell, of in plates.items()
        for number, plate in enumerate(sorted(of, key=lambda plate: (_drawn(seed, *map(str, cell), plate), plate)))
    }
    dealt = [(number, turn[stratum], stratum, each) for stratum, of in strata.items() for number, each in enumerate(of)]
    return [each for *_, each in sorted(dealt, key=lambda deal: deal[:3])]


def learnable(candidates: Sequence[Candidate], learner: dict[str, float], quantile: float = 0.75) -> list[Candidate]:
    """What can be learned and is not learned yet (RHO-loss; Mindermann et al., 2022): most reducible loss first.

    The reducible loss is the learner's less that of the reference, which was trained on real images. Of equal ones
    the lesser loss of the reference comes first, then the name.

    Parameters
    ----------
    candidates : sequence of Candidate
        Their loss is that of the reference.
    learner : dict of str to float
        By name, the loss of the detector that is to learn.
    quantile : float
        Images whose loss under the reference lies beyond this quantile are left out: not even who knows real images
        can tell what is in them.

    Raises
    ------
    InputError
        When the learner has not scored an image.
    """
    lacking = [each.name for each in candidates if each.name not in learner]
    if lacking:
        raise InputError("--scores-learner", f"lacks {len(lacking)} images, the first is {lacking[0]}")
    order = _by_loss(candidates)
    return sorted(order[: math.ceil(exact(quantile) * len(order))], key=lambda each: each.loss - learner[each.name])


def _by_loss(candidates: Iterable[Candidate]) -> list[Candidate]:
    candidates = list(candidates)
    order = ranked([[(each.loss, each.name) for each in candidates]])
    by_name = {each.name: each for each in candidates}
    return [by_name[name] for _, name in order]


def _drawn(seed: int, *words: str) -> bytes:
    """Bits that depend on the seed and the words alone."""
    return hashlib.sha256("\0".join([str(seed), *words]).encode()).digest()
