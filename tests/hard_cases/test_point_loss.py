"""The family "point loss and ranking": numbers that are none, ties, empty truth, points on borders, order."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pavemark.select.point_loss import point_loss
from pavemark.select.ranking import ranked

SIZE = (600, 300)


def grid(rows=3, columns=6, confidence=0.0):
    predicted = np.zeros((rows, columns, 3))
    predicted[..., 0] = confidence
    return predicted


def exact(points, size, predicted):
    """Eq. 2 in fractions, for points no two of which share a cell."""
    rows, columns, _ = predicted.shape
    total = Fraction(0)
    for row in range(rows):
        for column in range(columns):
            confidence, x, y = (Fraction(float(value)) for value in predicted[row, column])
            inside = []
            for u, v in points:
                px, py = Fraction(float(u)) / size[0] * columns, Fraction(float(v)) / size[1] * rows
                if (min(int(py), rows - 1), min(int(px), columns - 1)) == (row, column):
                    inside.append((px - column, py - row))
            if inside:
                ((px, py),) = inside
                total += (1 - confidence) ** 2 + (px - x) ** 2 + (py - y) ** 2
            else:
                total += confidence**2
    return total / (rows * columns)


def test_empty_truth_counts_false_confidence_only():
    assert point_loss(np.empty((0, 2)), SIZE, grid(confidence=0.5)) == 0.25
    assert point_loss([], SIZE, grid()) == 0.0


def test_a_perfect_detector_has_no_loss():
    predicted = grid()
    predicted[1, 2] = 1.0, 0.25, 0.5
    assert point_loss([(225.0, 150.0)], SIZE, predicted) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("channel", [0, 1, 2])
def test_a_prediction_that_is_no_number_is_refused_with_its_cell(bad, channel):
    predicted = grid()
    predicted[2, 4, channel] = bad
    with pytest.raises(ValueError, match=r"cell \(2, 4\) is not finite"):
        point_loss([], SIZE, predicted)


@pytest.mark.parametrize("point", [(np.nan, 1.0), (np.inf, 1.0), (-1e-9, 0.0), (600.0001, 0.0), (0.0, 301.0)])
def test_a_point_outside_the_picture_is_refused(point):
    with pytest.raises(ValueError, match="within the picture of 600×300 is allowed"):
        point_loss([point], SIZE, grid())


@pytest.mark.parametrize("shape", [(0, 6, 3), (3, 6, 2), (3, 6)])
def test_another_shape_is_refused(shape):
    with pytest.raises(ValueError, match=r"\(rows, columns, 3\) is allowed"):
        point_loss([], SIZE, np.zeros(shape))


@pytest.mark.parametrize(
    ("point", "cell", "place"),
    [
        ((0.0, 0.0), (0, 0), (0.0, 0.0)),
        ((100.0, 100.0), (1, 1), (0.0, 0.0)),
        ((np.nextafter(100.0, 0), 50.0), (0, 0), (1.0, 0.5)),
        ((600.0, 300.0), (2, 5), (1.0, 1.0)),
        ((600.0, 0.0), (0, 5), (1.0, 0.0)),
        ((0.0, 300.0), (2, 0), (0.0, 1.0)),
    ],
)
def test_points_on_borders_belong_to_one_cell(point, cell, place):
    predicted = grid()
    predicted[cell] = 1.0, *place
    assert point_loss([point], SIZE, predicted) == pytest.approx(0.0, abs=1e-25)
    predicted[cell] = 0.0
    assert point_loss([point], SIZE, predicted) == pytest.approx((1 + np.sum(np.square(place))) / 18, rel=1e-12)


def test_of_two_points_in_a_cell_one_counts_whatever_their_order():
    points = [(40.0, 50.0), (45.0, 50.0), (60.0, 50.0), (40.0, 50.0)]
    losses = {
        point_loss([points[k] for k in order], SIZE, grid()) for order in ((0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1))
    }
    assert len(losses) == 1
    (loss,) = losses
    assert loss == point_loss([(45.0, 50.0)], SIZE, grid())
    # As near to the middle: the left one.
    assert point_loss([(60.0, 50.0), (40.0, 50.0)], SIZE, grid()) == point_loss([(40.0, 50.0)], SIZE, grid())


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_it_is_eq_2_to_the_last_bit_but_one_and_knows_no_order(data):
    rows, columns = data.draw(st.integers(1, 6)), data.draw(st.integers(1, 6))
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    predicted = rng.random((rows, columns, 3)) * 10.0 ** rng.integers(-8, 2, (rows, columns, 3))
    cells = [(r, c) for r in range(rows) for c in range(columns) if rng.random() < 0.4]
    points = [((c + rng.random()) * SIZE[0] / columns, (r + rng.random()) * SIZE[1] / rows) for r, c in cells]
    loss = point_loss(points, SIZE, predicted)
    # Places are rounded once and squares once: some units in the last place of the largest term.
    assert loss == pytest.approx(float(exact(points, SIZE, predicted)), rel=1e-12)
    assert loss == point_loss(points[::-1], SIZE, predicted)


def test_ties_go_by_name_and_shards_do_not_matter():
    rng = np.random.default_rng(0)
    scored = [(float(rng.integers(5)) / 4, f"{k:03d}") for k in range(200)]
    whole = ranked([scored])
    assert [loss for loss, _ in whole] == sorted(loss for loss, _ in scored)
    assert all(a[1] < b[1] for a, b in pairwise(whole) if a[0] == b[0])
    for parts in (2, 7, 200):
        mixed = [scored[k] for k in rng.permutation(200)]
        assert ranked([mixed[k::parts] for k in range(parts)]) == whole


def test_two_noughts_are_one():
    assert ranked([[(0.0, "b"), (-0.0, "a")]]) == [(0.0, "a"), (0.0, "b")]
    assert str(ranked([[(-0.0, "a")]])) == "[(0.0, 'a')]"


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_loss_that_is_no_number_is_refused(bad):
    with pytest.raises(ValueError, match=r"000017: loss = -?(nan|inf)"):
        ranked([[(1.0, "000016")], [(bad, "000017")]])


def test_an_image_that_two_shards_scored_is_refused():
    with pytest.raises(ValueError, match="000016: is scored twice"):
        ranked([[(1.0, "000016")], [(1.0, "000016")]])


def test_nothing_is_ranked_as_nothing():
    assert ranked([]) == ranked([[], []]) == []
