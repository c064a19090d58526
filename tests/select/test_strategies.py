"""Each strategy against another implementation of what its docstring says, on tables full of ties."""

import hashlib
import math

import numpy as np
import pytest
from scored import table

from pavemark.errors import InputError
from pavemark.select import modifiers, strategies
from pavemark.select.candidate import Candidate
from pavemark.select.choice import STRATEGIES, Wanted, chosen


def names(candidates):
    return [each.name for each in candidates]


def easiest_first(candidates):
    left, found = list(candidates), []
    while left:
        least = left[0]
        for each in left[1:]:
            if each.loss < least.loss or (each.loss == least.loss and each.name < least.name):
                least = each
        left.remove(least)
        found.append(least)
    return found


def by_domain(candidates):
    means = []
    for domain in {each.domain or "" for each in candidates}:
        of = [each for each in candidates if (each.domain or "") == domain]
        means.append((math.fsum(each.loss for each in of) / len(of), domain, of))
    return [each for _, _, of in sorted(means, key=lambda mean: mean[:2]) for each in easiest_first(of)]


def draw(*words):
    return hashlib.sha256("\0".join(map(str, words)).encode()).hexdigest()


def shuffled(candidates, seed):
    return sorted(candidates, key=lambda each: draw(seed, each.name))


def evenly(candidates, seed, quantiles):
    """Rounds are played: in each, turn after turn, every cell's next plate gives an image if it has one."""
    order = easiest_first(candidates)
    cells = {}
    for k, each in enumerate(order):
        cells.setdefault((k * quantiles // len(order), each.domain or ""), {}).setdefault(each.plate or "", []).append(
            each
        )
    queues = {
        cell: [shuffled(plates[plate], seed) for plate in sorted(plates, key=lambda plate: draw(seed, *cell, plate))]
        for cell, plates in cells.items()
    }
    found = []
    while len(found) < len(order):
        for turn in range(max(map(len, queues.values()))):
            for cell in sorted(queues):
                if turn < len(queues[cell]) and queues[cell][turn]:
                    found.append(queues[cell][turn].pop(0))
    return found


def reducible(candidates, learner, quantile):
    order = easiest_first(candidates)
    order = order[: math.ceil(round(quantile * len(order), 9))]
    found = []
    while order:
        best = max(learner[each.name] - each.loss for each in order)
        first = next(each for each in order if learner[each.name] - each.loss == best)
        order.remove(first)
        found.append(first)
    return found


def learner_of(rng, candidates):
    return {each.name: float(rng.integers(0, 5) / 7) for each in candidates}


@pytest.mark.parametrize("seed", range(25))
def test_orders(seed):
    rng = np.random.default_rng(seed)
    candidates = table(rng, int(rng.integers(1, 60)), tied=seed % 2 == 0)
    if not any(each.domain for each in candidates):
        candidates.append(Candidate("x", 0.1, "p0", "a"))
    learner = learner_of(rng, candidates)
    assert names(strategies.cfds(candidates)) == names(easiest_first(candidates))
    assert names(strategies.ehds(candidates)) == names(by_domain(candidates))
    assert names(strategies.random(candidates, seed)) == names(shuffled(candidates, seed))
    for quantiles in (1, 4):
        assert names(strategies.coverage(candidates, seed, quantiles)) == names(evenly(candidates, seed, quantiles))
    for quantile in (0.3, 0.75, 1.0):
        expected = names(reducible(candidates, learner, quantile))
        assert names(strategies.learnable(candidates, learner, quantile)) == expected


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_no_order_of_the_input_matters(strategy):
    rng = np.random.default_rng(3)
    candidates = table(rng, 80, unknown=False)
    learner = learner_of(rng, candidates)
    embedding = {each.name: rng.integers(0, 3, 2).astype(np.float32) for each in candidates}
    wanted = Wanted(strategy, 5, seed=2, drop_hardest=0.1, near_duplicates=0.01, cap_per_plate=6)

    def kept(order):
        real = np.array([[1.0, 0.1], [0.2, 1.0]], np.float32)
        return names(chosen(order, wanted, learner, lambda of: np.array([embedding[name] for name in of]), real))

    first = kept(candidates)
    assert len(set(first)) == 5
    for _ in range(5):
        assert kept([candidates[k] for k in rng.permutation(len(candidates))]) == first


def test_coverage_is_even_over_strata_of_unequal_size():
    sizes = {"p0": 50, "p1": 3, "p2": 1}
    candidates = [Candidate(f"{plate}-{k}", 0.5, plate, "a") for plate, size in sizes.items() for k in range(size)]
    kept = strategies.coverage(candidates, quantiles=1)[:9]
    assert {plate: sum(each.plate == plate for each in kept) for plate in sizes} == {"p0": 5, "p1": 3, "p2": 1}


def test_coverage_that_is_cut_short_has_every_quantile_and_domain_and_not_one_plate():
    rng = np.random.default_rng(0)
    candidates = [Candidate(f"{k:04d}", float(rng.random()), f"p{k % 100}", "ab"[k // 100 % 2]) for k in range(4000)]
    rank = {each.name: k for k, each in enumerate(strategies.cfds(candidates))}
    kept = strategies.coverage(candidates)[:16]
    assert sorted((rank[each.name] // 1000, each.domain) for each in kept) == sorted(
        [(part, domain) for part in range(4) for domain in "ab"] * 2
    )
    assert len({each.plate for each in kept}) > 8


def test_seeds_differ_and_a_larger_dataset_keeps_the_order_of_a_smaller():
    candidates = table(np.random.default_rng(1), 50)
    assert names(strategies.random(candidates, 0)) != names(strategies.random(candidates, 1))
    some = candidates[:20]
    assert names(strategies.random(some, 0)) == [
        name for name in names(strategies.random(candidates, 0)) if name in names(some)
    ]


def test_easy_domains_are_whole():
    candidates = [Candidate(f"a{k}", 0.1 * k, domain="a") for k in range(5)]
    candidates += [Candidate(f"b{k}", 0.19, domain="b") for k in range(5)]
    assert names(strategies.ehds(candidates)) == ["b0", "b1", "b2", "b3", "b4", "a0", "a1", "a2", "a3", "a4"]


def test_no_domain_at_all():
    with pytest.raises(InputError, match="tells its domain"):
        strategies.ehds([Candidate("a", 0.1)])


def test_a_learner_that_has_not_seen_all():
    with pytest.raises(InputError, match="lacks 2 images, the first is b"):
        strategies.learnable([Candidate(name, 0.1) for name in "abc"], {"a": 0.1})


@pytest.mark.parametrize("order", [strategies.cfds, strategies.coverage, strategies.random])
def test_nothing_from_nothing(order):
    assert order([]) == []


@pytest.mark.parametrize("loss", [math.nan, math.inf])
def test_a_loss_that_is_none(loss):
    with pytest.raises(ValueError, match="finite"):
        strategies.cfds([Candidate("a", loss)])


def test_a_name_that_stands_twice():
    with pytest.raises(ValueError, match="twice"):
        strategies.cfds([Candidate("a", 0.1), Candidate("a", 0.2)])


@pytest.mark.parametrize(("share", "left"), [(0, 100), (0.29, 71), (0.295, 71), (1, 0)])
def test_the_hardest_are_dropped(share, left):
    """0.29 · 100 is 28.999999999999996 in binary."""
    candidates = table(np.random.default_rng(5), 100)
    kept = modifiers.without_hardest(candidates, share)
    assert names(kept) == [
        each.name for each in candidates if each.name in set(names(easiest_first(candidates)[:left]))
    ]


@pytest.mark.parametrize("most", [1, 3, 1000])
def test_a_cap_on_plates(most):
    candidates = table(np.random.default_rng(6), 60)
    given, expected = {}, []
    for each in candidates:
        given[each.plate] = given.get(each.plate, 0) + 1
        if given[each.plate] <= most:
            expected.append(each)
    assert list(modifiers.capped(candidates, most)) == expected


def test_a_cap_where_a_plate_is_not_known():
    with pytest.raises(InputError, match="the plate of a is not known"):
        list(modifiers.capped([Candidate("a", 0.1)], 3))


def test_more_than_there_are():
    candidates = table(np.random.default_rng(7), 40)
    plates = len({each.plate for each in candidates})
    with pytest.raises(InputError, match=r"--keep: 41: 40 of 40 images are left to choose from"):
        chosen(candidates, Wanted("cfds", 41))
    with pytest.raises(InputError, match=rf"--keep: 20: {2 * plates} of 40 images"):
        chosen(candidates, Wanted("random", 20, cap_per_plate=2))
    with pytest.raises(InputError, match=r"--keep: 1: 0 of 40"):
        chosen(candidates, Wanted("coverage", 1, drop_hardest=1.0))
    assert len(chosen(candidates, Wanted("cfds", 40))) == 40


def test_coverage_is_even_whatever_was_capped():
    """Two of three images of plate p look alike: of what is left the strata are dealt anew."""
    candidates = [Candidate(f"{plate}{k}", 0.5, plate, "a") for plate in "pq" for k in range(4)]
    alike = {f"p{k}": (1.0, 0.0) for k in range(3)} | {"p3": (0.0, 1.0)}
    seen = {each.name: alike.get(each.name, (1.0, 2.0 + int(each.name[1]))) for each in candidates}
    wanted = Wanted("coverage", 4, quantiles=1, near_duplicates=1e-4)
    kept = chosen(candidates, wanted, None, lambda of: np.array([seen[name] for name in of], np.float32))
    assert sorted(each.plate for each in kept) == ["p", "p", "q", "q"]
    assert "p3" in names(kept)


@pytest.mark.parametrize(
    "wrong",
    [{"strategy": "best"}, {"keep": 0}, {"cap_per_plate": 0}, {"drop_hardest": 1.1}, {"near_duplicates": float("nan")}],
)
def test_what_cannot_be_wanted(wrong):
    with pytest.raises(ValueError):
        Wanted(**{"strategy": "cfds", "keep": 3, **wrong})
