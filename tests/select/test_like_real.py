"""Images like the real ones: against a choice that looks at every image anew each time, in exact fractions."""

import itertools
import tracemalloc
from fractions import Fraction

import numpy as np
import pytest

from pavemark.errors import InputError
from pavemark.select import like_real as module
from pavemark.select.candidate import Candidate
from pavemark.select.choice import Wanted, chosen
from pavemark.select.like_real import like_real

# Of these the cosines are fractions, and many of them equal.
DIRECTIONS = [(3, 4), (4, 3), (-3, 4), (3, -4), (-4, -3), (5, 0), (0, 5), (0, -5), (6, 8), (0, 0)]


def cosine(one, other):
    lengths = [{0: 1, 25: 5, 100: 10}[x * x + y * y] for x, y in (one, other)]
    return Fraction(one[0] * other[0] + one[1] * other[1], lengths[0] * lengths[1])


def by_hand(seen, real):
    """Names in order: whatever adds most, in rounds."""
    left, found = sorted(seen), []
    while left:
        best = [Fraction(-2)] * len(real)
        while left:
            pairs = list(zip(real, best, strict=True))
            gains = [sum(max(cosine(seen[name], each) - most, 0) for each, most in pairs) for name in left]
            if not max(gains):
                break
            first = left.pop(gains.index(max(gains)))
            best = [max(most, cosine(seen[first], each)) for each, most in pairs]
            found.append(first)
    return found


def named(names):
    return [Candidate(name, 0.0) for name in names]


@pytest.mark.parametrize("seed", range(30))
def test_each_is_the_one_that_adds_most(seed, monkeypatch):
    monkeypatch.setattr(module, "BLOCK", 4)
    rng = np.random.default_rng(seed)
    seen = {f"{k:02d}": DIRECTIONS[rng.integers(len(DIRECTIONS))] for k in range(rng.integers(1, 15))}
    real = [DIRECTIONS[rng.integers(len(DIRECTIONS) - 1)] for _ in range(rng.integers(1, 6))]
    order = [str(name) for name in rng.permutation(list(seen))]
    got = like_real(named(order), np.array([seen[name] for name in order], np.float32), np.array(real, np.float32))
    assert [each.name for each in got] == by_hand(seen, real)


def test_who_stands_for_most_comes_first_and_each_real_image_has_its_own():
    """Two streets, one seen three times: first what is like it, then what is like the other, then like them again."""
    real = np.array([(1, 0.1), (1, 0.0), (1, -0.1), (0.0, 1)])
    seen = {"a": (0.1, 1), "b": (0.7, 0.7), "c": (1, 0.0), "d": (1, -0.05), "e": (-1, 0.0)}
    got = [each.name for each in like_real(named(seen), np.array([*seen.values()]), real)]
    assert got[0] == "c" and got[1] == "a" and got[-1] == "e"


def test_what_the_cap_leaves_out_stands_for_no_real_image():
    """b looks like the third, but its plate has given its one image: c, of another plate, is the next best."""
    seen = {"a": (1.0, 0.0, "p"), "b": (0.0, 1.0, "p"), "c": (-0.05, 1.0, "q"), "d": (1.0, -0.2, "r")}
    candidates = [Candidate(name, 0.0, plate) for name, (_, _, plate) in seen.items()]
    looks, real = np.array([each[:2] for each in seen.values()]), np.array([(1, 0), (1, 0), (0, 1)])
    wanted = Wanted("like-real", 2, cap_per_plate=1)
    assert [each.name for each in chosen(candidates, wanted, None, lambda names: looks, real)] == ["a", "c"]
    assert [each.name for each in like_real(candidates, looks, real, 1)] == ["a", "c", "d"]


def test_a_part_of_the_order_is_its_beginning():
    rng = np.random.default_rng(0)
    candidates, seen, real = (
        named([f"{k:04d}" for k in range(300)]),
        rng.normal(size=(300, 5)),
        rng.normal(size=(40, 5)),
    )
    order = list(like_real(candidates, seen, real))
    assert sorted(order, key=lambda each: each.name) == candidates
    place = {each.name: k for k, each in enumerate(candidates)}
    kept = chosen(candidates, Wanted("like-real", 70), None, lambda names: seen[[place[name] for name in names]], real)
    assert kept == order[:70]


def test_memory_does_not_grow_with_both():
    """20,000 images and 500 real ones: their cosines alone would take 80 MB."""
    rng = np.random.default_rng(1)
    seen, real = rng.normal(size=(20_000, 8)).astype(np.float32), rng.normal(size=(500, 8)).astype(np.float32)
    candidates = named([f"{k:05d}" for k in range(len(seen))])
    tracemalloc.start()
    kept = list(itertools.islice(like_real(candidates, seen, real), 20))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(set(kept)) == 20 and peak < 40e6


def test_no_real_image():
    with pytest.raises(InputError, match="--scores-real: holds no image"):
        next(like_real(named("a"), np.ones((1, 2)), np.empty((0, 2))))
