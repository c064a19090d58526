"""Intervals: from the definition, from theory, and the same whatever the order."""

import math

import numpy as np
import pytest

from pavemark.evaluate.bootstrap import FIGURES, interval, resampled
from pavemark.evaluate.curve import average_precision, rates
from pavemark.evaluate.results import result
from pavemark.evaluate.tally import Tally


def random_tally(seed, images=12):
    rng = np.random.default_rng(seed)
    found = int(rng.integers(1, 60))
    truths = rng.integers(0, 6, images)
    confidence = rng.integers(0, 8, found) / 8
    return Tally(confidence, rng.random(found) < 0.3, rng.integers(0, images, found), truths)


def repeated(tally, chosen):
    """The tally of images written down as often as they were drawn."""
    parts = [np.flatnonzero(tally.image == image) for image in chosen]
    rows = np.concatenate(parts).astype(int) if parts else np.empty(0, int)
    image = np.repeat(np.arange(len(chosen)), [len(part) for part in parts])
    return Tally(tally.confidence[rows], tally.hit[rows], image, tally.truths[chosen])


@pytest.mark.parametrize("seed", range(20))
def test_a_draw_is_the_figures_of_the_images_drawn(seed):
    tally = random_tally(seed)
    names = [f"{k:02d}" for k in range(12)]
    clusters = [name if seed % 2 else f"plate{k % 5}" for k, name in enumerate(names)]
    drawn = resampled(tally, 0.5, clusters, 30, seed)
    rng = np.random.Generator(np.random.PCG64(seed))
    kinds = sorted(set(clusters))
    for draw in range(30):
        kept = [kinds[k] for k in rng.integers(len(kinds), size=len(kinds))]
        chosen = np.array([k for kind in kept for k, cluster in enumerate(clusters) if cluster == kind])
        by_hand = repeated(tally, chosen)
        at = rates(by_hand, 0.5)
        wanted = at.precision, at.recall, at.f1, average_precision(by_hand)
        got = [drawn[name][draw] for name in FIGURES]
        assert got == pytest.approx(wanted, abs=1e-12, nan_ok=True)


def test_the_order_of_images_does_not_matter():
    tally, names = random_tally(5), [f"{k:02d}" for k in range(12)]
    order = np.random.default_rng(1).permutation(12)
    rows = np.random.default_rng(2).permutation(len(tally.confidence))
    place = np.argsort(order)
    mixed = Tally(tally.confidence[rows], tally.hit[rows], place[tally.image[rows]], tally.truths[order])
    one = resampled(tally, 0.5, names, 50)
    other = resampled(mixed, 0.5, [names[k] for k in order], 50)
    for name in FIGURES:
        np.testing.assert_array_equal(one[name], other[name])


def test_the_seed_tells_the_draws():
    tally, names = random_tally(5), [f"{k:02d}" for k in range(12)]
    one, same, other = (resampled(tally, 0.5, names, 50, seed)["recall"] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_two_detectors_are_drawn_alike():
    """Recall of what finds everything in half of the images is the share of things drawn there, of both."""
    truths = np.arange(1, 13)
    first = Tally(np.ones(6), np.ones(6, bool), np.arange(6), truths)
    second = Tally(np.ones(12), np.ones(12, bool), np.r_[np.arange(6), np.arange(6)], truths)
    names = [f"{k:02d}" for k in range(12)]
    one, two = (resampled(tally, 0.5, names, 100)["recall"] for tally in (first, second))
    np.testing.assert_allclose(two, 2 * one, atol=1e-15)


def test_as_wide_as_theory_says():
    """Of 400 images with one thing each, 300 found: a binomial share, whose standard error is √(p (1 − p) / n)."""
    tally = Tally(np.ones(300), np.ones(300, bool), np.arange(300), np.ones(400, int))
    low, high = interval(resampled(tally, 0.5, range(400), 2000)["recall"])
    half = 1.96 * math.sqrt(0.75 * 0.25 / 400)
    assert (low, high) == pytest.approx((0.75 - half, 0.75 + half), abs=0.006)


def test_images_that_are_alike_are_drawn_together():
    """Ten places of forty images, all of a place found or none: 400 images say no more than ten."""
    there = np.repeat(np.arange(10) < 7, 40)
    image = np.flatnonzero(there)
    tally = Tally(np.ones(len(image)), np.ones(len(image), bool), image, np.ones(400, int))
    apart = interval(resampled(tally, 0.5, range(400))["recall"])
    places = interval(resampled(tally, 0.5, np.repeat(np.arange(10), 40).tolist())["recall"])
    assert places[1] - places[0] > 4 * (apart[1] - apart[0])


def test_an_interval_is_that_of_percentiles_and_leaves_out_what_is_no_number():
    values = np.r_[np.arange(101.0), np.nan, np.nan]
    assert interval(values) == pytest.approx((2.5, 97.5))
    assert interval(values, 0.5) == pytest.approx((25.0, 75.0))
    assert interval(np.full(5, np.nan)) is None


def test_a_single_cluster_has_no_interval():
    tally = random_tally(3)
    assert set(result(tally, 0.5, ["same"] * 12).intervals.values()) == {None}
    whole = result(tally, 0.5, range(12), draws=200)
    assert all(low <= getattr(whole, name) <= high for name, (low, high) in whole.intervals.items())


def test_nothing_there_and_nothing_found():
    tally = Tally(np.empty(0), np.empty(0, bool), np.empty(0, int), np.zeros(4, int))
    empty = result(tally, 0.5, range(4), draws=20)
    assert set(empty.intervals.values()) == {None}
    assert math.isnan(empty.precision) and math.isnan(empty.average_precision)
