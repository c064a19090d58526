"""The journal: lines that are whole count, one writer at a time, and the job that a folder holds."""

import fcntl
import json
import threading
from pathlib import Path

import attrs
import pytest

from pavemark.background.index import index
from pavemark.errors import InputError
from pavemark.job import journal
from pavemark.job.config import read
from pavemark.job.folder import claim, recorded
from pavemark.job.journal import Journal, Shard

WHOLE = Shard()


def _written(out, *numbers):
    with Journal(out, WHOLE) as kept:
        for number in numbers:
            kept.append(number, {"index": number, "versions": {"pavemark": "1"}}, {"text": f"tab\t{number}"})


def test_what_was_appended_is_read(tmp_path):
    _written(tmp_path, 3, 1)
    found = journal.entries(tmp_path)
    assert found.keys() == {1, 3}
    row, coco = found[3].read()
    assert json.loads(row)["index"] == 3 and json.loads(coco) == {"text": "tab\t3"}
    assert journal.versions(tmp_path) == [{"pavemark": "1"}]


def test_what_is_said_last_of_a_name_counts(tmp_path):
    with Journal(tmp_path, WHOLE) as kept:
        for size in (1, 2):
            kept.append('odd\t"näme"\n', {"size": size}, [size])
        kept.append("7", {"size": 3}, None)
    found = journal.entries(tmp_path)
    assert found.keys() == {'odd\t"näme"\n', "7"}
    assert json.loads(found['odd\t"näme"\n'].read()[0]) == {"size": 2}
    assert journal.beside(tmp_path) == {'odd\t"näme"\n': [2], "7": None}


@pytest.mark.parametrize("torn", [b'7\t{"index": 7}\t{"text"', b'7\t{"index": 7}\t{}', b"7", b"\0\0\0"])
def test_a_torn_line_does_not_count_and_does_not_spoil_the_next(tmp_path, torn):
    _written(tmp_path, 3)
    path = tmp_path / "journal" / "0-of-1.jsonl"
    path.write_bytes(path.read_bytes() + torn)
    assert journal.entries(tmp_path).keys() == {3}
    _written(tmp_path, 4)
    assert journal.entries(tmp_path).keys() == {3, 4}
    assert json.loads(journal.entries(tmp_path)[4].read()[0])["index"] == 4


def test_one_writer_a_shard(tmp_path):
    with (
        Journal(tmp_path, Shard(0, 2)),
        Journal(tmp_path, Shard(1, 2)),
        pytest.raises(InputError, match="another run is writing part 1/2"),
    ):
        Journal(tmp_path, Shard(1, 2))
    with Journal(tmp_path, Shard(1, 2)):
        pass


def test_journals_are_joined_by_one_at_a_time(tmp_path):
    entered = threading.Event()

    def join():
        with journal.merging(tmp_path):
            entered.set()

    _written(tmp_path, 1)
    with (tmp_path / "journal" / "merging").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        other = threading.Thread(target=join)
        other.start()
        assert not entered.wait(0.2)
    other.join(10)
    assert entered.is_set()


def test_shards_share_all_images():
    shards = [Shard(part, 3) for part in range(3)]
    assert sorted(number for shard in shards for number in shard.numbers(10)) == list(range(10))


def test_the_count_grows_and_does_not_shrink(inputs, tmp_path):
    entries, _ = index(inputs / "images", inputs / "masks")
    job = read(None, {"images": str(inputs / "images"), "masks": str(inputs / "masks"), "count": 10, "scale": 12.0})
    for count, kept in ((10, 10), (4, 10), (12, 12)):
        claim(tmp_path, attrs.evolve(job, count=count), entries)
        assert recorded(tmp_path).count == kept
    there = recorded(tmp_path)
    assert (there.images, there.pixels_per_metre, there.layout) == (job.images, 12.0, job.layout)


def test_other_inputs_are_another_job(inputs, tmp_path):
    entries, _ = index(inputs / "images", inputs / "masks")
    job = read(None, {"images": str(inputs / "images")})
    claim(tmp_path, job, entries)
    with pytest.raises(InputError, match=r"holds another job: inputs.images was 3 and is 2"):
        claim(tmp_path, job, entries[:2])


def test_a_journal_is_opened_once_for_many_lines(tmp_path, monkeypatch):
    """On a network drive every opening waits for an answer."""
    for part in range(3):
        with Journal(tmp_path, Shard(part, 3)) as kept:
            for number in range(part, 30, 3):
                kept.append(number, {"index": number}, number)
    found = journal.entries(tmp_path)
    opened, plain = [], Path.open

    def counted(path, *mode):
        opened.append(path.name)
        return plain(path, *mode)

    monkeypatch.setattr(Path, "open", counted)
    told = [json.loads(row)["index"] for row, _ in journal.lines(found[number] for number in range(30))]
    assert told == list(range(30))
    assert sorted(opened) == ["0-of-3.jsonl", "1-of-3.jsonl", "2-of-3.jsonl"]
    monkeypatch.setattr(journal, "MOST_OPEN", 2)
    assert [json.loads(beside) for _, beside in journal.lines(found[n] for n in range(30))] == list(range(30))
