"""A pool of views: the same whatever drew it, and gone on with where it was left."""

import numpy as np
import pytest

from pavemark.errors import InputError
from pavemark.training import pool
from pavemark.training import views as own
from pavemark.training.pool import GROUND, MARKING, drawn


def _silent(done):
    pass


@pytest.fixture(scope="module")
def views(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pool")
    return folder, np.array(drawn(folder, 3, 4, 2, _silent))


def test_views_depend_on_their_number_alone(views, tmp_path):
    assert (drawn(tmp_path, 2, 4, 1, _silent) == views[1][:2]).all()


def test_what_is_there_is_not_drawn_again(views, monkeypatch):
    monkeypatch.setattr(pool, "_drawn", lambda numbers, *rest: [pytest.fail("drawn again") for _ in numbers])
    assert (drawn(views[0], 3, 4, 1, _silent) == views[1]).all()


def test_the_bits_are_the_truth(views):
    bits = views[1][..., 3]
    assert set(np.unique(bits)) <= {0, GROUND, MARKING | GROUND}
    assert (bits > 0).mean() > 0.2


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        drawn(tmp_path / "file" / "pool", 1, 0, 1, _silent)


@pytest.mark.parametrize("number", [0, 1, 3, len(own.KINDS) + 6])
def test_kinds_come_in_turn(number):
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(7, spawn_key=(number,))))
    wanted = own.sample(rng, True, own.KINDS[number % len(own.KINDS)])
    assert (pool._view((number, 7))[..., :3] == wanted.image).all()
