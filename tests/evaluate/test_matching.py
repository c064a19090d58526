"""Eq. 3 against loops over lists, and the cases in which a judge goes wrong first."""

import numpy as np
import plainly
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pavemark.evaluate.found import Marks
from pavemark.evaluate.matching import NONE, matched, radius
from pavemark.ground import Frame


def marks(places, confidence, width=2):
    return Marks(np.array(places, float).reshape(-1, width), np.array(confidence, float))


def match(places, confidence, truth, near=10.0, width=2):
    return matched(marks(places, confidence, width), np.array(truth, float).reshape(-1, width), near).tolist()


def things(width, size=7):
    # Few places and few confidences, so that ties and duplicates are the rule.
    places = st.tuples(*[st.integers(0, 5).map(lambda k: 4.0 * k)] * width)
    return st.lists(st.tuples(st.sampled_from([0.0, 0.25, 0.5, 0.75, 1.0]), places), max_size=size)


@pytest.mark.parametrize("width", [2, 4])
@settings(max_examples=300, deadline=None, derandomize=True)
@given(data=st.data())
def test_as_by_lists_and_loops_whatever_the_order(width, data):
    found, truth = data.draw(things(width)), [place for _, place in data.draw(things(width))]
    near = data.draw(st.sampled_from([4.0, 6.0, 8.0, 10.0]))
    got = match([place for _, place in found], [c for c, _ in found], truth, near, width)
    by_hand = plainly.matches(found, truth, near)
    key = {"key": lambda pair: (pair[0], pair[1] or ())}
    assert sorted(_pairs(found, truth, got), **key) == sorted(_pairs(found, truth, by_hand), **key)
    turned = data.draw(st.permutations(range(len(found)))), data.draw(st.permutations(range(len(truth))))
    mixed, truth_mixed = [found[k] for k in turned[0]], [truth[k] for k in turned[1]]
    again = match([place for _, place in mixed], [c for c, _ in mixed], truth_mixed, near, width)
    assert sorted(_pairs(mixed, truth_mixed, again), **key) == sorted(_pairs(found, truth, got), **key)


def _pairs(found, truth, given):
    return [(found[k], None if t in (None, NONE) else truth[t]) for k, t in enumerate(given)]


def test_random_places_as_by_lists_and_loops():
    rng = np.random.default_rng(3)
    for _ in range(100):
        truth = rng.uniform(0, 60, (rng.integers(0, 9), 4))
        near = rng.normal(0, 5, truth.shape) + truth
        places = np.concatenate([near, near[: len(near) // 2] + 1, rng.uniform(0, 60, (3, 4))])
        confidence = rng.uniform(size=len(places))
        got = matched(Marks(places, confidence), truth, 10.0)
        found = list(zip(confidence.tolist(), map(tuple, places.tolist()), strict=True))
        by_hand = plainly.matches(found, [tuple(row) for row in truth.tolist()], 10.0)
        assert got.tolist() == [NONE if t is None else t for t in by_hand]


@pytest.mark.parametrize(
    ("apart", "right"),
    [((10.0, 0.0), False), ((np.nextafter(10.0, 0), 0.0), True), ((6.0, 8.0), False), ((7, 7), True)],
)
def test_ten_pixels_are_too_far(apart, right):
    assert match([apart], [1], [(0, 0)]) == [0 if right else NONE]


def test_both_ends_together_count():
    # 7.2 px at each end are 10.2 together; 7 are 9.9.
    assert match([(7.2, 0, 57.2, 0)], [1], [(0, 0, 50, 0)], width=4) == [NONE]
    assert match([(7, 0, 57, 0)], [1], [(0, 0, 50, 0)], width=4) == [0]


def test_slots_have_a_direction():
    assert match([(50, 0, 0, 0)], [1], [(0, 0, 50, 0)], width=4) == [NONE]


def test_the_most_confident_chooses_first_and_what_is_found_twice_is_wrong_once():
    assert match([(1, 0), (0, 0)], [0.9, 0.8], [(0, 0)]) == [0, NONE]
    assert match([(1, 0), (0, 0)], [0.8, 0.9], [(0, 0)]) == [NONE, 0]


def test_it_is_not_the_assignment_that_matches_most():
    # The confident one takes its nearest, and nothing near is left to the other; an optimal assignment has both.
    assert match([(4, 0), (-4, 0)], [0.9, 0.8], [(3, 0), (13.5, 0)]) == [0, NONE]


def test_of_truths_as_near_the_leftmost_then_the_uppermost():
    assert match([(5, 5)], [1], [(9, 5), (1, 5)]) == [1]
    assert match([(5, 5)], [1], [(5, 9), (5, 1)]) == [1]


def test_of_equally_confident_the_leftmost_chooses_first():
    assert match([(6, 0), (4, 0)], [0.5, 0.5], [(5, 0)]) == [NONE, 0]


@pytest.mark.parametrize(("found", "truth"), [([], []), ([(1, 1)], []), ([], [(1, 1)])])
def test_nothing_found_or_nothing_there(found, truth):
    assert match(found, [0.5] * len(found), truth) == [NONE] * len(found)


@pytest.mark.parametrize(("scale", "pixels"), [(60.0, 10.0), (22.7, 22.7 / 6), (150.0, 25.0)])
def test_the_tolerance_is_as_many_metres_at_every_scale(scale, pixels):
    assert radius(Frame(96, 300, scale)) == pytest.approx(pixels, rel=1e-15)
    assert radius(Frame(96, 300, scale), 5.0) == pytest.approx(pixels / 2, rel=1e-15)
