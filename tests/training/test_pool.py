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


@pytest.mark.parametrize("harm", ["count", "cut", "no file"])
def test_a_pool_that_is_not_whole_is_drawn_anew(views, tmp_path, harm):
    drawn(tmp_path, 1, 4, 1, _silent)
    pixels, count = tmp_path / "views-4-1.npy", tmp_path / "views-4-1.done"
    if harm == "count":
        count.write_text("x")
    elif harm == "cut":
        with pixels.open("r+b") as stream:
            stream.truncate(5000)
    else:
        pixels.unlink()
    told = []
    assert (drawn(tmp_path, 1, 4, 1, told.append) == views[1][:1]).all()
    assert told == [0, 1]


def test_a_full_disk_is_told_before_anything_is_drawn(tmp_path, monkeypatch):
    def full(*rest):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pool.system, "reserve", full)
    with pytest.raises(InputError, match="No space left"):
        drawn(tmp_path, 1, 4, 1, lambda done: pytest.fail("drawn"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("number", [0, 1, 3, len(own.KINDS) + 6])
def test_kinds_come_in_turn(number):
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(7, spawn_key=(number,))))
    wanted = own.sample(rng, True, own.KINDS[number % len(own.KINDS)])
    assert (pool._view((number, 7))[..., :3] == wanted.image).all()
