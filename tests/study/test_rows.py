"""What a row learns from is what its strategy chooses by the losses that it asks for."""

from pathlib import Path
from types import SimpleNamespace

import attrs
import numpy as np
import pytest

from pavemark.errors import InputError
from pavemark.select.candidate import Candidate
from pavemark.select.scores import Scores
from pavemark.study.design import Row
from pavemark.study.rows import Data, synthetic


def scores(**losses: float) -> dict[str, Scores]:
    return {"base": Scores(Path(), None, [Candidate(name, loss) for name, loss in losses.items()])}


EASIEST = Row("easiest", pools=("base",), strategy="cfds", keep=2)
LEARNED = attrs.evolve(EASIEST, scored_by="learner")
DATA = Data(
    (),
    {"base": tuple(SimpleNamespace(name=f"base/{name}") for name in "abcd")},
    scores(a=0.1, b=0.2, c=0.3, d=0.4),
    {
        LEARNED.learner: scores(a=0.4, b=0.1, c=0.3, d=0.2),
        attrs.evolve(LEARNED, keep=3).learner: scores(a=0.1, b=0.4, c=0.3, d=0.2),
    },
)


def chosen(row: Row) -> list[str]:
    return [example.name.removeprefix("base/") for example in synthetic(row, DATA, 0)]


def test_the_reference_or_the_learner_says_what_is_hard():
    assert chosen(EASIEST) == ["a", "b"]
    assert chosen(LEARNED) == ["b", "d"]


def test_who_has_yet_to_learn_has_learned_from_as_many_as_are_kept():
    assert chosen(attrs.evolve(LEARNED, keep=3)) == ["a", "d", "c"]
    assert EASIEST.learner is None
    learnable = attrs.evolve(EASIEST, strategy="learnable")
    assert chosen(learnable) == ["a", "c"]  # of the easier three: 0.1 - 0.4, 0.3 - 0.3, 0.2 - 0.1
    assert chosen(attrs.evolve(learnable, keep=3)) == ["b", "a", "c"]
    assert (learnable.learner.strategy, learnable.learner.keep, learnable.learner.seeds) == ("random", 2, (0,))


def test_the_hardest_are_dropped_by_who_scores():
    anything = Row("anything", pools=("base",), strategy="random", keep=3, drop_hardest=0.25)
    assert set(chosen(anything)) == {"a", "b", "c"}
    assert set(chosen(attrs.evolve(anything, scored_by="learner"))) == {"a", "c", "d"}


def test_like_real_looks_at_what_the_real_images_look_like():
    looks = {"a": (1.0, 0.0), "b": (0.0, 1.0), "c": (-1.0, 0.0), "d": (0.1, -1.0)}
    known = [Candidate(name, 0.1) for name in looks]
    pool = SimpleNamespace(candidates=known, embeddings=lambda names: np.array([looks[name] for name in names]))
    row = Row("like", pools=("base",), strategy="like-real", keep=2)

    def kept(*real):
        data = attrs.evolve(DATA, scores={"base": pool}, seen=np.array(real, np.float32))
        return [example.name for example in synthetic(row, data, 0)]

    assert kept((0.0, -1.0), (0.0, -1.0), (0.0, 1.0)) == ["base/d", "base/b"]
    assert kept((-1.0, 0.0), (1.0, 0.0), (1.0, 0.0)) == ["base/a", "base/c"]


def test_more_than_there_are_is_told_with_the_row():
    with pytest.raises(InputError, match=r"rows: easiest: .*4 of 4 images"):
        synthetic(attrs.evolve(EASIEST, keep=5), DATA, 0)
