"""F1 at a tolerance: what is near counts, what is far does not."""

import numpy as np
import pytest

from pavemark.accuracy.markings import Found, compare


def _lines(*rows):
    mask = np.zeros((40, 40), bool)
    mask[list(rows), 5:35] = True
    return mask


@pytest.mark.parametrize(("shift", "f1"), [(0, 1.0), (3, 1.0), (4, 0.0)])
def test_the_tolerance_is_three_pixels(shift, f1):
    assert compare(_lines(10 + shift), _lines(10)).f1 == f1


def test_precision_and_recall_count_pixels():
    found = compare(_lines(10, 30), _lines(10, 20))
    assert (found.precision, found.recall, found.f1) == (0.5, 0.5, 0.5)
    assert compare(_lines(10, 20, 30), _lines(10)) == Found(pytest.approx(1 / 3), 1.0)


def test_distance_is_euclidean():
    point, other = np.zeros((9, 9), bool), np.zeros((9, 9), bool)
    point[4, 4] = True
    other[7, 7] = True
    assert compare(point, other).f1 == 0.0


def test_nothing_found_and_nothing_there():
    none = np.zeros((9, 9), bool)
    assert compare(none, none).f1 == 1.0
    assert compare(none, _lines(3)[:9, :9]).f1 == 0.0
    assert compare(_lines(3)[:9, :9], none).f1 == 0.0


def test_what_is_not_seen_counts_for_nothing():
    seen = np.ones((40, 40), bool)
    seen[25:] = False
    assert compare(_lines(10, 30), _lines(10), seen).f1 == 1.0
