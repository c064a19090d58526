"""Near-duplicates against every pair compared in exact arithmetic, across blocks and at the threshold itself."""

from fractions import Fraction

import numpy as np
import pytest

from pavemark.select import near_duplicates
from pavemark.select.candidate import Candidate
from pavemark.select.near_duplicates import distinct


def candidates(count):
    return [Candidate(f"{k:05d}", 0.0) for k in range(count)]


def kept(embeddings, distance):
    return [int(each.name) for each in distinct(candidates(len(embeddings)), embeddings, distance)]


def naive(embeddings, distance):
    unit = embeddings.astype(np.float64)
    lengths = np.linalg.norm(unit, axis=1, keepdims=True)
    unit /= np.where(lengths, lengths, 1)
    found = []
    for k, one in enumerate(unit):
        if all(1 - one @ unit[other] >= distance for other in found):
            found.append(k)
    return found


@pytest.mark.parametrize("block", [1, 7, 1024])
@pytest.mark.parametrize("distance", [1e-3, 0.05, 0.6, 1.5])
def test_as_every_pair_says(monkeypatch, block, distance):
    monkeypatch.setattr(near_duplicates, "BLOCK", block)
    monkeypatch.setattr(near_duplicates, "_ACROSS", 3 * block)
    rng = np.random.default_rng(block)
    centres = rng.normal(size=(30, 6))
    embeddings = (centres[rng.integers(0, 30, 300)] + rng.normal(size=(300, 6)) * 0.05).astype(np.float32)
    assert kept(embeddings, distance) == naive(embeddings, distance)
    assert 0 < len(kept(embeddings, distance)) < 300


def test_ties_at_the_threshold_are_decided_exactly():
    """(3, 4) / 5 and (1, 0) are 0.4 apart, in single precision a little more or less."""
    pair = np.array([[1, 0], [3, 4]], np.float32)
    three_fifths = Fraction(float(np.float32(0.6)))
    apart = float(1 - three_fifths)
    assert kept(pair, apart) == [0, 1]
    assert kept(pair, np.nextafter(apart, 1)) == [0]


def test_copies_and_embeddings_of_no_length():
    embeddings = np.array([[1, 2], [2, 4], [0, 0], [0, 0], [-1, -2]], np.float32)
    assert kept(embeddings, 1e-3) == [0, 2, 3, 4]
    assert kept(embeddings, 1.5) == [0, 4]
    assert kept(np.ones((2000, 3), np.float32), 1e-6) == [0]


def test_no_more_is_looked_at_than_is_asked_for(monkeypatch):
    monkeypatch.setattr(near_duplicates, "BLOCK", 4)
    embeddings = np.eye(12, dtype=np.float32)
    embeddings[4:] = np.nan
    walk = distinct(candidates(12), embeddings, 0.1)
    assert [next(walk).name for _ in range(4)] == ["00000", "00001", "00002", "00003"]


def test_nothing_from_nothing():
    assert kept(np.empty((0, 3), np.float32), 0.1) == []
