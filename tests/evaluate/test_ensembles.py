"""Votes against loops over lists, whatever the order of detectors and of what each found."""

import numpy as np
import plainly
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pavemark.evaluate.ensembles import VOTES, groups, voted
from pavemark.evaluate.found import Found, Marks

NEEDED = {"affirmative": lambda k: 1, "unanimous": lambda k: k, "consensus": lambda k: k // 2 + 1}


def marks(things, width):
    return Marks(
        np.array([place for _, place in things], float).reshape(-1, width),
        np.array([confidence for confidence, _ in things], float),
    )


def together(points, slots, vote, near):
    found = [Found(marks(p, 2), marks(s, 4)) for p, s in zip(points, slots, strict=True)]
    return voted(found, vote, near)


def things(width):
    places = st.tuples(*[st.integers(0, 4).map(lambda k: 4.0 * k)] * width)
    return st.lists(st.tuples(st.sampled_from([0.0, 0.25, 0.5, 1.0]), places), max_size=5)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(data=st.data())
def test_as_by_lists_and_loops_whatever_the_order(data):
    count = data.draw(st.integers(1, 5))
    points = data.draw(st.lists(things(2), min_size=count, max_size=count))
    slots = data.draw(st.lists(things(4), min_size=count, max_size=count))
    vote, near = data.draw(st.sampled_from(list(VOTES))), data.draw(st.sampled_from([3.0, 6.0, 9.0]))
    got = together(points, slots, vote, near)
    for kind, said in ((got.points, points), (got.slots, slots)):
        by_hand = plainly.voted(said, NEEDED[vote](count), near)
        assert kind.confidence.tolist() == sorted(kind.confidence, reverse=True)
        rows = [(confidence, *place) for confidence, place in by_hand]
        _same_rows(np.column_stack([kind.confidence, kind.places]), np.reshape(rows, (-1, 1 + kind.places.shape[1])))
    order = data.draw(st.permutations(range(count)))
    mixed = [[data.draw(st.permutations(said[k])) for k in order] for said in (points, slots)]
    again = together(*mixed, vote, near)
    for one, other in ((got.points, again.points), (got.slots, again.slots)):
        np.testing.assert_array_equal(one.places, other.places)
        np.testing.assert_array_equal(one.confidence, other.confidence)


def _same_rows(one, other):
    """Hold that rows are the same in some order, but for rounding."""
    assert one.shape == other.shape
    ordered = [np.array(sorted(np.round(rows, 9).tolist())) for rows in (one, other)]
    np.testing.assert_allclose(*ordered, atol=1e-8)


@pytest.mark.parametrize(
    ("vote", "kept"),
    [("affirmative", [3, 2, 1]), ("unanimous", [3]), ("consensus", [3, 2])],
)
def test_any_all_and_more_than_half_of_three(vote, kept):
    # A place that all three found, one that two found, one that one found.
    said = [[(0.9, (0.0, 0.0)), (0.6, (50.0, 0.0)), (0.3, (90.0, 0.0))], [(0.9, (0.0, 1.0)), (0.6, (50.0, 1.0))]]
    said.append([(0.9, (0.0, 2.0))])
    got = together(said, [[]] * 3, vote, 10.0).points
    where = {3: [0.0, 1.0], 2: [50.0, 0.5], 1: [90.0, 0.0]}
    np.testing.assert_allclose(got.places, [where[k] for k in kept], atol=1e-12)


def test_half_is_not_more_than_half():
    said = [[(0.9, (0.0, 0.0))], [(0.9, (0.0, 0.0))], [], []]
    assert len(together(said, [[]] * 4, "consensus", 10.0).points.confidence) == 0


def test_places_are_weighted_by_confidence_and_confidence_is_the_mean():
    got = together([[], []], [[(0.9, (0, 0, 50, 0))], [(0.3, (4, 0, 50, 4))]], "unanimous", 10.0).slots
    np.testing.assert_allclose(got.places, [[1, 0, 50, 1]])
    np.testing.assert_allclose(got.confidence, [0.6])


def test_of_confidences_that_are_all_nought_the_plain_mean():
    got = together([[(0.0, (0.0, 0.0))], [(0.0, (2.0, 4.0))]], [[]] * 2, "unanimous", 10.0).points
    assert got.places.tolist() == [[1.0, 2.0]] and got.confidence.tolist() == [0.0]


def test_just_the_tolerance_apart_is_not_the_same():
    said = [[(0.9, (0.0, 0.0))], [(0.5, (6.0, 8.0))]]
    assert len(together(said, [[]] * 2, "affirmative", 10.0).points.confidence) == 2
    assert len(together(said, [[]] * 2, "affirmative", 10.01).points.confidence) == 1


def test_a_slot_the_other_way_round_is_another():
    slots = [[(0.9, (0, 0, 50, 0))], [(0.9, (50, 0, 0, 0))]]
    assert len(together([[], []], slots, "unanimous", 10.0).slots.confidence) == 0


def test_at_most_one_of_a_detector_in_a_group():
    said = [marks([(0.9, (0.0, 0.0)), (0.8, (1.0, 0.0))], 2), marks([(0.7, (3.0, 0.0)), (0.95, (-2.0, 0.0))], 2)]
    got = [sorted(group.places[:, 0].tolist()) for group in groups(said, 10.0)]
    # The founder is at −2 and takes 0, the nearest of the other's; what is left founds the second.
    assert got == [[-2.0, 0.0], [1.0, 3.0]]


def test_members_are_near_the_founder_and_not_one_another():
    said = [[(0.9, (0.0, 0.0))], [(0.8, (8.0, 0.0))], [(0.7, (-8.0, 0.0))], [(0.6, (16.0, 0.0))]]
    got = [sorted(group.places[:, 0].tolist()) for group in groups([marks(each, 2) for each in said], 10.0)]
    assert got == [[-8.0, 0.0, 8.0], [16.0]]


@pytest.mark.parametrize("vote", list(VOTES))
def test_one_detector_alone_says_what_it_says(vote):
    said = [(0.7, (10.0, 20.0)), (0.2, (11.0, 20.0))]
    got = together([said], [[]], vote, 10.0).points
    np.testing.assert_allclose(got.places, [place for _, place in said])
    assert got.confidence.tolist() == [0.7, 0.2]


@pytest.mark.parametrize("vote", list(VOTES))
def test_nothing_found(vote):
    got = together([[], []], [[], []], vote, 10.0)
    assert got.points.places.shape == (0, 2) and got.slots.places.shape == (0, 4)
