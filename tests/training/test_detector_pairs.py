"""The families that find pairs: which points they look at, what they are taught, and where they look."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

from pavemark.training.detectors import deepps, pairs  # noqa: E402
from pavemark.training.detectors.deepps import DeepPs  # noqa: E402
from pavemark.training.detectors.gcn import Gcn, between  # noqa: E402
from pavemark.training.detectors.lessons import Lesson  # noqa: E402
from pavemark.training.detectors.network import Points, targets  # noqa: E402
from pavemark.training.detectors.pairs import best  # noqa: E402
from pavemark.training.detectors.training import fresh  # noqa: E402


def grid(cells, size=(6, 8)):
    """One image's grid with points in some cells: {(row, column): (confidence, x, y, cos, sin, l)}."""
    made = torch.zeros(1, 6, *size)
    for (row, column), told in cells.items():
        made[0, :, row, column] = torch.tensor(told)
    return made


def test_the_best_points_come_first_and_once():
    found = best(
        grid(
            {
                (1, 2): (0.9, 0.9, 0.5, 1.0, 0.0, 0.2),
                (1, 3): (0.8, 0.3, 0.5, 1.0, 0.0, 0.2),  # once more
                (1, 4): (0.7, 0.1, 0.5, 0.0, 1.0, 0.6),  # beside what is left out, not beside what is kept
                (5, 7): (0.3, 1.0, 1.0, 0.0, -1.0, 0.0),
            }
        ),
        4,
    )
    np.testing.assert_allclose(found.at[0, :3], [[2.9, 1.5], [4.1, 1.5], [8.0, 6.0]], rtol=1e-6)
    np.testing.assert_allclose(found.confidence[0], [0.9, 0.7, 0.3, 0.0], rtol=1e-6)
    np.testing.assert_allclose(found.direction[0, :3], [[1, 0], [0, 1], [0, -1]])
    np.testing.assert_allclose(found.l_shaped[0, :3], [0.2, 0.6, 0.0])
    assert found.cell[0, :3].tolist() == [10, 12, 47]


def test_fewer_cells_than_points():
    found = best(grid({(0, 0): (0.5, 0.5, 0.5, 1.0, 0.0, 0.0)}, size=(1, 1)), 5)
    assert found.confidence.tolist() == [[0.5, 0, 0, 0, 0]] and found.at.shape == (1, 5, 2)


def test_true_points_are_looked_at_before_they_are_found():
    there = torch.zeros(1, 1, 6, 8)
    there[0, 0, 4, 4] = 1
    found = best(grid({(1, 1): (0.9, 0.5, 0.5, 1.0, 0.0, 0.0)}), 2, 2 * there)
    assert found.cell.tolist() == [[36, 9]] and found.confidence[0, 0] == 0


def lesson(slots):
    points = np.array([[24.0, 24.0], [72.0, 24.0], [72.0, 72.0]])
    return Lesson(np.zeros((96, 128, 3), np.uint8), points, np.zeros((3, 2)), np.zeros(3, bool), slots)


def test_what_is_to_be_said_of_each_pair():
    lessons = [lesson(np.array([[1, 0], [1, 2]])), lesson(None), lesson(np.zeros((0, 2), int))]
    wanted = targets(lessons, (6, 8))
    found = best(wanted.grid, 4)
    truth, weight = pairs._wanted(lessons, wanted, found)
    cells = found.cell[0].tolist()
    number = {point: cells.index(row * 8 + column) for point, (row, column) in wanted.cells[0].items()}
    assert {(i, j) for i, j in truth[0].nonzero().tolist()} == {(number[1], number[0]), (number[1], number[2])}
    assert not truth[1:].any() and not weight[1].any()
    np.testing.assert_array_equal(weight[2], 1 - np.eye(4))


@pytest.mark.parametrize("family", ["gcn", "deepps"])
def test_points_alone_teach_nothing_of_pairs(family):
    network = fresh(family, 0).train()
    losses = network.loss(torch.zeros(2, 3, 96, 128), [lesson(None), lesson(None)])
    assert losses["pairs"] == 0
    sum(losses.values()).backward()
    assert all(torch.isfinite(one.grad).all() for one in network.parameters() if one.grad is not None)


def test_a_pair_looks_to_the_left_of_its_way(monkeypatch):
    """What the pieces hold is what lies where they say: the features are the places themselves."""
    network = DeepPs().eval()
    monkeypatch.setattr(network, "thin", torch.nn.Identity())
    kept = []
    network.piece.register_forward_pre_hook(lambda module, given: kept.append(given[0]))
    at = torch.zeros(1, network.most, 2)
    at[0, 0], at[0, 1] = torch.tensor([6.0, 4.0]), torch.tensor([2.0, 4.0])
    found = pairs.Found(
        at,
        torch.ones(1, network.most),
        torch.zeros(1, network.most, 2),
        torch.zeros(1, network.most),
        torch.zeros(1, network.most, dtype=torch.int64),
        (8, 10),
    )
    down, right = torch.meshgrid(torch.arange(32) / 4 + 0.125, torch.arange(40) / 4 + 0.125, indexing="ij")
    places = torch.stack([right, down] + [torch.zeros_like(right)] * (deepps.DEPTH - 2))[None]
    with torch.no_grad():
        assert network.pair_logits([places], found).shape == (1, network.most, network.most)
    # From (6, 4) to (2, 4), to the left as seen from there is below.
    piece = kept[0].reshape(network.most, network.most, deepps.DEPTH, 8, 20)[0, 1, :2]
    np.testing.assert_allclose(piece[:, 0, 0], [6 + 0.2 * 4, 4 + 0.5 * 4], atol=1e-4)
    np.testing.assert_allclose(piece[:, -1, -1], [2 - 0.2 * 4, 4 - 0.3 * 4], atol=1e-4)


def test_what_is_told_of_a_pair_is_told_of_its_ends():
    made = best(grid({(1, 1): (0.9, 0.5, 0.5, 0.0, -1.0, 1.0), (1, 5): (0.8, 0.5, 0.5, 1.0, 0.0, 0.0)}), 2)
    told = between(made)[0]
    # 4 cells to the right; the first points up, to the left of the way; the second along it.
    np.testing.assert_allclose(told[0, 1], [0.5, 0, 0.5, 0, -1, 1, 0, 1, 0], atol=1e-3)
    np.testing.assert_allclose(told[1, 0], [-0.5, 0, 0.5, -1, 0, 0, 1, 0, 1], atol=1e-3)


def test_the_families_are_points_and_more():
    points = set(Points().state_dict())
    assert all(points < set(kind().state_dict()) for kind in (Gcn, DeepPs))
