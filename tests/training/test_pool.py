"""A pool of views: the same whatever drew it, and gone on with where it was left."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pavemark.errors import InputError
from pavemark.training import pool
from pavemark.training import views as own
from pavemark.training.pool import GROUND, MARKING, drawn


def _silent(done):
    pass


def killed(task):
    os.kill(os.getpid(), signal.SIGKILL)


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


@pytest.mark.parametrize("harm", ["count", "cut", "shape", "no file"])
def test_a_pool_that_is_not_whole_is_drawn_anew(views, tmp_path, harm):
    drawn(tmp_path, 1, 4, 1, _silent)
    (pixels,), (count,) = tmp_path.glob("views-4-1-*.npy"), tmp_path.glob("views-4-1-*.done")
    if harm == "count":
        count.write_text("x")
    elif harm == "cut":
        with pixels.open("r+b") as stream:
            stream.truncate(5000)
    elif harm == "shape":
        np.save(pixels, np.zeros((1, 8, 8, 4), np.uint8))
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
    assert not [path for path in tmp_path.iterdir() if path.suffix != ".lock"]


def test_what_other_code_drew_is_not_taken(tmp_path, monkeypatch):
    drawn(tmp_path, 1, 4, 1, _silent)
    monkeypatch.setattr(pool, "_drawn_with", lambda: "other")
    told = []
    drawn(tmp_path, 1, 4, 1, told.append)
    assert told == [0, 1]


def test_all_that_views_are_drawn_by_is_told():
    """Whatever of this package `views` leads to, but for what has no pixels of its own."""
    told = "print(*(each.__file__ for name, each in sys.modules.items() if name.startswith('pavemark.')))"
    words = [sys.executable, "-c", f"import sys, pavemark.training.views; {told}"]
    used = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    package = Path(pool.__file__).parents[1]
    others = {Path(name).relative_to(package).as_posix() for name in used if Path(name) not in pool.drawing()}
    assert others == ELSEWHERE


ELSEWHERE = {"errors.py", "records.py", "training/__init__.py"}
"""No pixel depends on these."""


def test_two_do_not_draw_at_once(tmp_path):
    """The second would begin the file of the first anew."""

    def another(done):
        if done == 0:
            with pytest.raises(InputError, match="is being drawn by another process"):
                drawn(tmp_path, 2, 4, 1, _silent)

    assert drawn(tmp_path, 2, 4, 1, another).any(axis=(1, 2, 3)).all()


def test_a_process_that_is_killed_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "_view", killed)
    with pytest.raises(InputError, match="--workers: 1: one was ended"):
        drawn(tmp_path, 3, 4, 1, _silent)


@pytest.mark.parametrize("number", [0, 1, 3, len(own.KINDS) + 6])
def test_kinds_come_in_turn(number):
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(7, spawn_key=(number,))))
    wanted = own.sample(rng, True, own.KINDS[number % len(own.KINDS)])
    assert (pool._view((number, 7))[..., :3] == wanted.image).all()
