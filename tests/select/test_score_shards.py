"""Shards of scores: the same bytes for the same rows, and no bit that flips is taken for a score."""

import math

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scored import ORIGIN, row

from pavemark.errors import InputError
from pavemark.select import scores, shards
from pavemark.select.candidate import Candidate
from pavemark.select.shards import Broken


def some(count=40):
    return [row(f"images/{k}", k / 7, "p" if k % 3 else None, "base", (0.5 * k, 1.25)) for k in range(count)]


@pytest.fixture
def shard(tmp_path):
    path = shards.path_of(tmp_path, 0)
    shards.write(path, 0, some(), ORIGIN)
    return path


def test_what_is_written_is_read(shard):
    assert shards.rows(shard, 0) == (ORIGIN, some())


def test_the_same_rows_are_the_same_bytes(shard, tmp_path):
    again = shards.path_of(tmp_path / "again", 0)
    shards.write(again, 0, some(), ORIGIN)
    assert again.read_bytes() == shard.read_bytes()


def test_others_read_it_as_plain_parquet(shard):
    table = pq.read_table(shard)
    assert table.column_names == ["name", "loss", "plate", "domain", "groups", "embedding", "mark"]
    assert table.schema.field("embedding").type.list_size == 2
    assert table.column("embedding").to_pylist()[3] == [1.5, 1.25]
    assert table.column("plate").to_pylist()[:3] == [None, "p", "p"]
    assert dict(table.column("groups").to_pylist()[1]) == {"plate": "p", "domain": "base"}
    assert table.schema.metadata[b"pavemark"] == b"scores 1"
    assert b'"model": "model"' in table.schema.metadata[b"origin"]


def test_a_file_that_is_cut_short(shard):
    whole = shard.read_bytes()
    for size in (0, 1, 4, len(whole) // 2, len(whole) - 9, len(whole) - 1):
        shard.write_bytes(whole[:size])
        with pytest.raises(Broken):
            shards.rows(shard, 0)


def test_bits_that_flip_are_no_scores(shard):
    whole = shard.read_bytes()
    refused = 0
    for k in range(len(whole)):
        flipped = bytearray(whole)
        flipped[k] ^= 1 << k % 8
        shard.write_bytes(flipped)
        try:
            _, found = shards.rows(shard, 0)
        except (Broken, InputError):
            refused += 1
        else:
            assert found == some()
    # Statistics, which nothing is read from, are the rest.
    assert refused > len(whole) / 2


def test_a_shard_under_the_name_of_another(shard):
    with pytest.raises(Broken, match="another shard"):
        shards.rows(shard, 1)


def test_a_parquet_file_of_someone_else(tmp_path):
    path = shards.path_of(tmp_path, 0)
    pq.write_table(pa.table({"name": ["a"]}), path)
    with pytest.raises(InputError, match=r'scores-000000.parquet: is of the kind "no scores"'):
        shards.rows(path, 0)
    with pytest.raises(InputError, match="no scores"):
        scores.read(tmp_path)


def test_other_columns(shard, tmp_path):
    table = pq.read_table(shard)
    pq.write_table(table.drop_columns(["mark"]), shard)
    with pytest.raises(Broken, match="columns"):
        shards.rows(shard, 0)


def test_scores_of_a_folder(tmp_path):
    shards.write(shards.path_of(tmp_path, 1), 1, some(40)[25:], ORIGIN)
    shards.write(shards.path_of(tmp_path, 0), 0, some(40)[:25], ORIGIN)
    (tmp_path / "scores-old.parquet").write_bytes(b"not one of ours")
    found = scores.read(tmp_path)
    assert [each.name for each in found.candidates] == [each.name for each in some(40)]
    assert found.candidates[1] == Candidate("images/1", 1 / 7, "p", "base")
    assert found.candidates[0].plate is None
    assert found.embeddings(["images/30", "images/2"]).tolist() == [[15.0, 1.25], [1.0, 1.25]]
    assert found.embeddings([]).shape == (0, 2)
    with pytest.raises(ValueError, match="1 names that have no scores"):
        found.embeddings(["images/30", "images/77"])


def test_no_scores(tmp_path):
    with pytest.raises(InputError, match="holds no scores"):
        scores.read(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("rows", "origin", "said"),
    [
        ([row("b", 0.1), row("a", 0.2)], ORIGIN, "b: is scored twice"),
        ([row("c", math.nan)], ORIGIN, "c: loss = nan"),
        ([row("c", 0.1)], shards.Origin("other", "dmpr", "dataset", "", {}), "another detector"),
    ],
)
def test_shards_that_do_not_go_together(tmp_path, rows, origin, said):
    shards.write(shards.path_of(tmp_path, 0), 0, [row("a0", 0.1), row("b", 0.2)], ORIGIN)
    shards.write(shards.path_of(tmp_path, 1), 1, rows, origin)
    with pytest.raises(InputError, match=said):
        scores.read(tmp_path)


def test_a_broken_shard_is_no_selection(shard, tmp_path):
    shard.write_bytes(shard.read_bytes()[:-5])
    with pytest.raises(InputError, match="is no whole shard"):
        scores.read(tmp_path)
