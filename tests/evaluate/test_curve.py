"""Precision, recall and the area under them against their definitions; images are matched anew at every threshold."""

import math

import numpy as np
import plainly
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from labelled import example

from pavemark.evaluate.curve import MOST, average_precision, best_threshold, curve, rates, thinned
from pavemark.evaluate.found import Found, Marks
from pavemark.evaluate.judge import of_found
from pavemark.evaluate.tally import Tally

NEAR = 6.0


def tally(images):
    """The tally of points of (found, truth) images, by the code that is tested."""
    none = Marks(np.empty((0, 4)), np.empty(0))
    pairs = []
    for k, (found, truth) in enumerate(images):
        places = np.array([place for _, place in found], float).reshape(-1, 2)
        marks = Marks(places, np.array([confidence for confidence, _ in found], float))
        pairs.append((example(f"{k}", truth), Found(marks, none)))
    return of_found(pairs, NEAR).points


places = st.tuples(*[st.integers(0, 6).map(lambda k: 4.0 * k)] * 2)
found = st.lists(st.tuples(st.sampled_from([0.0, 0.1, 0.3, 0.5, 0.9, 1.0]), places), max_size=6)
sets = st.lists(st.tuples(found, st.lists(places, max_size=5)), min_size=1, max_size=4)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(images=sets, threshold=st.sampled_from([0.0, 0.1, 0.2, 0.5, 1.0]))
def test_as_by_definition(images, threshold):
    got = tally(images)
    at = rates(got, threshold)
    assert (at.hits, at.false_positives, at.misses) == plainly.counts(images, threshold, NEAR)
    assert average_precision(got) == pytest.approx(plainly.average_precision(images, NEAR), abs=1e-12, nan_ok=True)
    if any(truth for _, truth in images) or any(found for found, _ in images):
        assert best_threshold(got) == plainly.best_threshold(images, NEAR)
    along = curve(got)
    assert along.confidence.tolist() == sorted({c for each, _ in images for c, _ in each}, reverse=True)
    for row, confidence in enumerate(along.confidence):
        same = rates(got, confidence)
        assert (along.precision[row], along.f1[row]) == pytest.approx((same.precision, same.f1), abs=1e-15)
        assert along.recall[row] == pytest.approx(same.recall, abs=1e-15, nan_ok=True)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(images=sets, data=st.data())
def test_the_order_of_images_and_of_what_was_found_does_not_matter(images, data):
    mixed = [
        (data.draw(st.permutations(found)), data.draw(st.permutations(truth)))
        for found, truth in data.draw(st.permutations(images))
    ]
    one, other = tally(images), tally(mixed)
    assert rates(one, 0.3) == rates(other, 0.3)
    np.testing.assert_array_equal(average_precision(one), average_precision(other))


def tallied(confidence, hit, truths):
    count = len(confidence)
    return Tally(np.array(confidence, float), np.array(hit, bool), np.zeros(count, int), np.array([truths]))


def test_a_curve_worked_out_by_hand():
    # Found 1, 2, 3, 4: right, wrong, right, right of 4; recall 1/4, 1/4, 2/4, 3/4 and precision 1, 1/2, 2/3, 3/4.
    got = tallied([0.9, 0.8, 0.7, 0.6], [1, 0, 1, 1], 4)
    np.testing.assert_allclose(curve(got).precision, [1, 1 / 2, 2 / 3, 3 / 4])
    np.testing.assert_allclose(curve(got).recall, [1 / 4, 1 / 4, 2 / 4, 3 / 4])
    # Interpolated: 1 up to recall 1/4, 3/4 up to 3/4, nought beyond.
    assert average_precision(got) == pytest.approx(1 / 4 + 3 / 4 * 2 / 4)
    assert best_threshold(got) == 0.6


def test_equally_confident_ones_are_found_at_once():
    one, other = tallied([0.5, 0.5], [1, 0], 1), tallied([0.5, 0.5], [0, 1], 1)
    assert average_precision(one) == average_precision(other) == 0.5


def test_of_equally_good_thresholds_the_greatest():
    # F1 is 2/3 with one of two found right, and with both there is one wrong more: 2·2/(4 + 1 + 1) the second time.
    assert best_threshold(tallied([0.9, 0.8, 0.7, 0.6], [1, 0, 0, 1], 2)) == 0.9


def test_nothing_there():
    at = rates(tallied([0.9], [0], 0), 0.5)
    assert at.precision == 0 and math.isnan(at.recall) and at.f1 == 0
    assert math.isnan(average_precision(tallied([0.9], [0], 0)))


def test_nothing_found():
    got = tallied([], [], 3)
    at = rates(got, 0.5)
    assert math.isnan(at.precision) and at.recall == 0 and at.f1 == 0 and at.misses == 3
    assert average_precision(got) == 0 and best_threshold(got) == 1.0 and len(curve(got).recall) == 0


def test_all_below_the_threshold():
    at = rates(tallied([0.4, 0.2], [1, 1], 2), 0.5)
    assert (at.hits, at.false_positives, at.misses) == (0, 0, 2)
    assert math.isnan(at.precision)
    # Average precision knows no threshold.
    assert average_precision(tallied([0.4, 0.2], [1, 1], 2)) == 1


def test_nothing_found_and_nothing_there():
    assert math.isnan(rates(tallied([], [], 0), 0.5).f1)


def test_a_confidence_that_is_the_threshold_counts():
    assert rates(tallied([0.5], [1], 1), 0.5).hits == 1
    assert rates(tallied([0.5], [1], 1), np.nextafter(0.5, 1)).hits == 0


def test_a_long_curve_is_thinned_and_keeps_its_ends():
    whole = curve(tallied(np.linspace(1, 0, 5000), np.ones(5000), 5000))
    few = thinned(whole)
    assert len(few.recall) == MOST
    assert (few.recall[0], few.recall[-1]) == (whole.recall[0], whole.recall[-1])
    assert len(thinned(curve(tallied([0.5], [1], 1))).recall) == 1
    assert len(thinned(curve(tallied([], [], 1))).recall) == 0
