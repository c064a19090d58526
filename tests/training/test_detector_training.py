"""The training of detectors: it learns, the same every time, and goes on after a cut as if there had been none."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

from pavemark.errors import InputError  # noqa: E402
from pavemark.training.detectors import training  # noqa: E402
from pavemark.training.detectors.lessons import Lesson  # noqa: E402
from pavemark.training.detectors.network import Points, activated, point_losses, targets  # noqa: E402
from pavemark.training.detectors.training import FAMILIES, fresh, tensor, train_detector  # noqa: E402


def crosses(count, size=(96, 64), known=True, seed=0):
    """Grey pictures with a few white Ts that lie right, left, up and down."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        image = rng.integers(80, 100, (size[1], size[0], 3), dtype=np.uint8)
        points = rng.integers(16, np.array(size) - 16, (2, 2)).astype(float)
        steps = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])[rng.integers(4, size=2)]
        for (u, v), (x, y) in zip(points.astype(int), steps, strict=True):
            across = 10 * abs(y) + 2, 10 * abs(x) + 2
            image[v - across[1] : v + across[1], u - across[0] : u + across[0]] = 220
            for along in range(14):
                image[v + along * y - 2 : v + along * y + 2, u + along * x - 2 : u + along * x + 2] = 220
        made.append(
            Lesson(image, points, *((steps.astype(float), np.zeros(2, bool), np.array([[0, 1]])) if known else ()))
        )
    return made


def weights(network):
    return {name: value.numpy().tobytes() for name, value in network.state_dict().items()}


@pytest.mark.parametrize("family", FAMILIES)
def test_the_same_call_gives_the_same_bytes_whatever_torch_did_before(family):
    lessons = crosses(6)
    torch.manual_seed(1)
    one = train_detector(family, [lessons], 4, 0, batch=3)
    torch.manual_seed(2)
    before = torch.get_rng_state()
    two = train_detector(family, [lessons], 4, 0, batch=3)
    assert torch.equal(before, torch.get_rng_state())
    assert weights(one) == weights(two) != weights(train_detector(family, [lessons], 4, 1, batch=3))


class Cut(Exception):
    pass


def test_it_goes_on_after_a_cut(tmp_path, monkeypatch):
    monkeypatch.setattr(training, "EVERY", 2)
    lessons = crosses(6)
    whole = train_detector("dmpr", [lessons], 8, 0, batch=3)
    for turn in (3, 6):

        def cut(step, told, turn=turn):
            if step == turn:
                raise Cut

        with pytest.raises(Cut):
            train_detector("dmpr", [lessons], 8, 0, batch=3, state=tmp_path / "state", tell=cut)
    steps = []
    went_on = train_detector(
        "dmpr", [lessons], 8, 0, batch=3, state=tmp_path / "state", tell=lambda step, told: steps.append(step)
    )
    assert steps == [7, 8] and weights(went_on) == weights(whole)
    # What is done need not be done again, where the network itself was not kept.
    steps.clear()
    again = train_detector(
        "dmpr", [lessons], 8, 0, batch=3, state=tmp_path / "state", tell=lambda step, told: steps.append(step)
    )
    assert steps == [] and weights(again) == weights(whole)


def test_a_state_of_other_images_is_not_taken_up_nor_lost(tmp_path, monkeypatch):
    monkeypatch.setattr(training, "EVERY", 2)

    def until(step, told):
        if step == 3:
            raise Cut

    options = {"batch": 2, "state": tmp_path / "state"}
    with pytest.raises(Cut):
        train_detector("dmpr", [crosses(4)], 4, 0, data="one", tell=until, **options)
    before = options["state"].read_bytes()
    with pytest.raises(InputError, match=r"state: a training with other options, .* was stopped at step 2: remove it"):
        train_detector("dmpr", [crosses(4)], 4, 0, data="other", **options)
    assert options["state"].read_bytes() == before
    steps = []
    train_detector("dmpr", [crosses(4)], 4, 0, data="one", tell=lambda step, told: steps.append(step), **options)
    assert steps == [3, 4]


def test_it_learns_where_points_lie_and_point():
    network = train_detector("dmpr", [crosses(200)], 220, 0, batch=8)
    there = crosses(20, seed=1)
    with torch.no_grad():
        grid = activated(network(tensor([lesson.image for lesson in there]))[0])
    wanted = targets(there, grid.shape[-2:])
    true = wanted.there[:, 0] > 0
    assert (grid[:, 0] > 0.5)[true].float().mean() > 0.7
    assert (grid[:, 0] > 0.5)[~true].float().mean() < 0.02
    sure = true & (grid[:, 0] > 0.5)
    off = (grid[:, 1:3] - wanted.grid[:, 1:3]).permute(0, 2, 3, 1)[sure].norm(dim=-1) * 16
    assert off.median() < 2.5
    same = (grid[:, 3:5] * wanted.grid[:, 3:5]).sum(1)[sure]
    assert (same > 0.8).float().mean() > 0.8


def test_points_alone_say_nothing_of_directions():
    raw = torch.zeros(2, 6, 4, 6, requires_grad=True)
    losses = point_losses(raw, targets(crosses(2, known=False), (4, 6)))
    sum(losses.values()).backward()
    assert losses["direction"] == losses["shape"] == 0
    assert (raw.grad[:, 3:] == 0).all() and (raw.grad[:, :3] != 0).any()


def test_without_points_there_is_still_something_to_learn():
    raw = torch.zeros(1, 6, 4, 6, requires_grad=True)
    sum(
        point_losses(raw, targets([Lesson(np.zeros((64, 96, 3), np.uint8), np.zeros((0, 2)))], (4, 6))).values()
    ).backward()
    assert torch.isfinite(raw.grad).all() and (raw.grad[:, 0] > 0).all()


def test_of_two_points_in_a_cell_the_one_nearest_to_its_middle_counts():
    lesson = Lesson(np.zeros((32, 32, 3), np.uint8), np.array([[17.0, 1.0], [24.0, 9.0], [31.0, 0.0], [3.0, 20.0]]))
    wanted = targets([lesson], (2, 2))
    assert wanted.there[0, 0].tolist() == [[0, 1], [1, 0]]
    assert wanted.grid[0, 1:3, 0, 1].tolist() == [0.5, 9 / 16]
    assert wanted.cells == [{1: (0, 1), 3: (1, 0)}]


def test_shares_say_what_is_learnt_from():
    """A set with no share, and one with no image, are not looked at."""

    class Untouched(list):
        def __getitem__(self, at):
            raise AssertionError

    lessons = crosses(3)
    sets = [Untouched(lessons), lessons, []]
    train_detector("dmpr", sets, 3, 0, shares=(0, 1, 5), batch=2, size=(96, 64))
    with pytest.raises(AssertionError):
        train_detector("dmpr", sets, 3, 0, batch=4, size=(96, 64))
    with pytest.raises(ValueError, match="no images"):
        train_detector("dmpr", [[], []], 3, 0)


def test_it_begins_from_weights_that_are_given():
    lessons = crosses(4)
    start = fresh("dmpr", 5).state_dict()
    begun = train_detector("dmpr", [lessons], 1, 0, batch=2, start=start, rate=1e-9)
    for name, value in begun.state_dict().items():
        if name.endswith("weight"):
            torch.testing.assert_close(value, start[name], atol=1e-6, rtol=0)


def test_it_is_small():
    assert sum(one.numel() for one in Points().parameters()) < 400_000
