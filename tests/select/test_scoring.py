"""Scoring goes on where it stopped, gives the same bytes whatever the machine does, and tells what it cannot score."""

import json
import threading
import tracemalloc
import weakref

import cv2
import numpy as np
import pytest
from scored import Fake, Watcher

from detect.datasets import listed, made
from pavemark.detect import reading
from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.job.config import PATHS
from pavemark.select import scores, scoring, shards
from pavemark.select.origin import GROWS
from pavemark.select.scoring import Outcome


@pytest.fixture(autouse=True)
def small_shards(monkeypatch):
    monkeypatch.setattr(scoring, "ROWS", 4)


@pytest.fixture
def dataset(tmp_path):
    return made(tmp_path / "dataset", 10)


def score(dataset, out, detector=None, **options):
    watcher = Watcher()
    detector = detector or Fake()
    return scoring.score(dataset, lambda: detector, out, watcher, **options), watcher, detector


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*"))}


def loss_by_hand(example, mean, cells, size):
    """Eq. 2 for a detector that says one number of every cell."""
    rows, columns = cells
    total = 0.0
    for row in range(rows):
        for column in range(columns):
            places = [(u / size[0] * columns - column, v / size[1] * rows - row) for u, v in example.points]
            inside = [(x, y) for x, y in places if 0 <= x < 1 and 0 <= y < 1]
            assert len(inside) < 2
            total += sum((1 - mean) ** 2 + (x - mean) ** 2 + (y - mean) ** 2 for x, y in inside) or mean**2
    return total / (rows * columns)


@pytest.mark.parametrize("beyond", [(0, 0), (9, 5)])
def test_the_loss_is_that_of_the_paper(dataset, tmp_path, beyond):
    """The grid may cover more than the picture, to whole cells."""
    came, watcher, _ = score(dataset, tmp_path / "scores", Fake(beyond=beyond))
    assert came == Outcome(10, 10, 0) and watcher.total == 10 and watcher.steps == [False] * 10
    found = scores.read(tmp_path / "scores").candidates
    for k, (each, example) in enumerate(zip(found, reading.examples(dataset), strict=True)):
        assert each.name == f"images/{k:06d}" and each.plate == f"plate{k % 2}.png" and each.domain == "base"
        expected = loss_by_hand(example, (60 + k) / 255, (3, 2), (48 + beyond[0], 96 + beyond[1]))
        assert each.loss == pytest.approx(expected, abs=1e-12)
    origin, rows = shards.rows(shards.path_of(tmp_path / "scores", 2), 2)
    assert len(rows) == 2 and rows[1].embedding == (float(np.float32(69 / 255)), 1.0)
    assert rows[1].groups == {"plate": "plate1.png", "domain": "base", "kind": "parallel"}
    assert (origin.model, origin.family) == ("fake", "dmpr")


def test_the_same_bytes_whatever_the_workers_the_parts_and_the_order(dataset, tmp_path):
    score(dataset, tmp_path / "one")
    score(dataset, tmp_path / "many", workers=7)
    for part in (2, 0, 1):
        score(dataset, tmp_path / "parts", part=(part, 3))
    score(dataset, tmp_path / "again")
    (tmp_path / "again" / "scores-000001.parquet").unlink()
    score(dataset, tmp_path / "again")
    one = contents(tmp_path / "one")
    assert list(one) == ["scores-000000.parquet", "scores-000001.parquet", "scores-000002.parquet"]
    assert contents(tmp_path / "many") == contents(tmp_path / "parts") == contents(tmp_path / "again") == one


def test_each_thread_opens_a_detector_of_its_own(dataset, tmp_path):
    opened = []

    def open_one():
        opened.append((threading.get_ident(), Fake()))
        return opened[-1][1]

    scoring.score(dataset, open_one, tmp_path / "scores", Watcher(), workers=3)
    threads = [thread for thread, detector in opened if detector.seen]
    assert len(set(threads)) == len(threads) <= 3
    assert sum(len(detector.seen) for _, detector in opened) == 10


def test_a_rerun_does_only_what_is_missing(dataset, tmp_path):
    out = tmp_path / "scores"
    score(dataset, out)
    before = contents(out)
    came, watcher, detector = score(dataset, out)
    assert came == Outcome(10, 0, 0) and watcher.total == 0 and detector.seen == []
    (out / "scores-000001.parquet").unlink()
    came, watcher, detector = score(dataset, out)
    assert came == Outcome(10, 4, 0) and watcher.total == 4 and len(detector.seen) == 4
    assert contents(out) == before


def test_a_broken_shard_is_told_and_redone(dataset, tmp_path):
    out = tmp_path / "scores"
    score(dataset, out)
    before = contents(out)
    (out / "scores-000000.parquet").write_bytes(before["scores-000000.parquet"][:-100])
    flipped = bytearray(before["scores-000002.parquet"])
    flipped[60] ^= 8
    (out / "scores-000002.parquet").write_bytes(flipped)
    came, watcher, _ = score(dataset, out)
    assert came == Outcome(10, 6, 0) and contents(out) == before
    assert [line.split(": ")[1] for line in watcher.lines] == ["is no whole shard and is made anew"] * 2
    assert "scores-000000" in watcher.lines[0] and "scores-000002" in watcher.lines[1]


def test_what_was_left_half_written_is_swept(dataset, tmp_path):
    from pavemark import files  # noqa: PLC0415 - its private name for the host

    out = tmp_path / "scores"
    out.mkdir()
    (out / f".scores-000000.parquet.{files._HOST}.999999999.part").write_bytes(b"half")
    score(dataset, out)
    assert all(name.startswith("scores-") for name in contents(out))


def test_a_dataset_that_has_grown(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    made(dataset, 14)
    came, _, detector = score(dataset, tmp_path / "scores")
    assert came == Outcome(14, 4, 0) and len(detector.seen) == 4
    score(dataset, tmp_path / "fresh")
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")


def test_a_part_opens_no_labels_of_others(dataset, tmp_path):
    for name in ("000003", "000008"):
        (dataset / f"labels/dmpr/{name}.json").unlink()
    came, _, detector = score(dataset, tmp_path / "scores", part=(1, 3))
    assert came == Outcome(4, 4, 0) and len(detector.seen) == 4
    assert list(contents(tmp_path / "scores")) == ["scores-000001.parquet"]
    assert score(dataset, tmp_path / "scores", part=(2, 3))[0] == Outcome(2, 1, 1)


def test_a_part_beyond_the_last_shard_has_nothing_to_do(dataset, tmp_path):
    assert score(dataset, tmp_path / "scores", part=(7, 8))[0] == Outcome(0, 0, 0)


def test_a_dataset_without_an_image(dataset, tmp_path):
    (dataset / "manifest.jsonl").write_text("")
    with pytest.raises(InputError, match="dataset: holds no image: at least one is needed"):
        score(dataset, tmp_path / "scores")


def test_a_dataset_that_has_become_smaller(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    lines = (dataset / "manifest.jsonl").read_text().splitlines(keepends=True)
    (dataset / "manifest.jsonl").write_text("".join(lines[4:]))
    came, watcher, _ = score(dataset, tmp_path / "scores", part=(0, 2))
    assert came.images == 4 and "scores-000002.parquet: the dataset has become smaller" in watcher.lines[0]
    score(dataset, tmp_path / "scores", part=(1, 2))
    score(dataset, tmp_path / "fresh")
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")
    assert len(scores.read(tmp_path / "scores").candidates) == 6
    with pytest.raises(InputError, match="another detector"):
        (dataset / "manifest.jsonl").write_text(lines[0])
        score(dataset, tmp_path / "scores", Fake("other"))
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")


def test_an_image_that_comes_late_moves_the_others(dataset, tmp_path):
    lines = (dataset / "manifest.jsonl").read_text().splitlines(keepends=True)
    (dataset / "manifest.jsonl").write_text("".join(lines[:2] + lines[3:]))
    score(dataset, tmp_path / "scores")
    (dataset / "manifest.jsonl").write_text("".join(lines))
    came, *_ = score(dataset, tmp_path / "scores")
    assert came.images == 10 and came.lacking == 0
    score(dataset, tmp_path / "fresh")
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")


def test_an_image_that_has_changed_is_scored_anew(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    labels = dataset / "labels/dmpr/000005.json"
    labels.write_text(json.dumps({"marks": [[5, 5, 9, 5, 1]], "slots": []}))
    cv2.imwrite(str(dataset / "images/000001.png"), np.arange(48 * 96 * 3, dtype=np.uint8).reshape(96, 48, 3))
    came, *_ = score(dataset, tmp_path / "scores")
    assert came == Outcome(10, 2, 0)
    score(dataset, tmp_path / "fresh")
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")


def test_a_name_that_is_not_utf_8_is_an_image_that_cannot_be_read(tmp_path):
    lines = [{"image": name, "w": 48, "h": 96, "points": [], "scale": 20} for name in ("a.png", "b.png")]
    folder = listed(tmp_path / "real", *lines)
    # As json.dumps writes what os.listdir tells of a name in Latin-1.
    with (folder / "labels.jsonl").open("a") as stream:
        stream.write(json.dumps(lines[0] | {"image": "stra\udcdfe.png"}) + "\n")
    came, watcher, _ = score(folder, tmp_path / "scores")
    assert came == Outcome(3, 2, 1)
    assert len(watcher.lines) == 1 and watcher.lines[0].startswith("not scored: ")


def test_scores_of_images_that_can_no_longer_be_read_go(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    (tmp_path / "scores" / "scores-000001.parquet").write_bytes(b"broken")
    for k in (4, 5, 6, 7, 8, 9):
        (dataset / f"images/{k:06d}.png").unlink()
    came, *_ = score(dataset, tmp_path / "scores")
    assert came == Outcome(10, 0, 6)
    assert [each.name[-1] for each in scores.read(tmp_path / "scores").candidates] == ["0", "1", "2", "3"]
    score(dataset, tmp_path / "fresh")
    before = contents(tmp_path / "scores")
    assert before == contents(tmp_path / "fresh")
    # Nothing at all can be read where a drive has gone: when it is back its scores are, too.
    for path in (dataset / "images").iterdir():
        path.unlink()
    with pytest.raises(InputError, match="none of its 10 images"):
        score(dataset, tmp_path / "scores")
    assert contents(tmp_path / "scores") == before


def test_scores_of_something_else(dataset, tmp_path):
    out = tmp_path / "scores"
    score(dataset, out)
    before = contents(out)
    with pytest.raises(InputError, match=r"scores-000000.parquet: holds scores of another detector, fake, and this is"):
        score(dataset, out, Fake("other"))
    other = made(tmp_path / "other", 10)
    (other / "job.json").write_text(json.dumps({"count": 10, "formats": ["dmpr"], "seed": 3}))
    with pytest.raises(InputError, match="holds scores of another dataset"):
        score(other, out)
    selection = tmp_path / "selection"
    selection.mkdir()
    (selection / "selection.json").write_text('{"dataset": "../dataset"}')
    (selection / "manifest.jsonl").write_bytes((dataset / "manifest.jsonl").read_bytes())
    with pytest.raises(InputError, match="another selection of this dataset"):
        score(selection, out)
    assert contents(out) == before


def test_scores_by_other_versions(dataset, tmp_path, monkeypatch):
    score(dataset, tmp_path / "scores")
    monkeypatch.setattr(scoring, "__version__", "9.9")
    with pytest.raises(InputError, match=r"made with other versions, .*; use another folder"):
        score(dataset, tmp_path / "scores")


def test_a_dataset_that_was_moved_is_the_same(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    came, *_ = score(dataset.rename(tmp_path / "elsewhere"), tmp_path / "scores")
    assert came == Outcome(10, 0, 0)


@pytest.mark.parametrize("harm", ["gone", "cut", "size", "outside"])
def test_one_image_that_cannot_be_scored(dataset, tmp_path, harm):
    image = dataset / "images/000005.png"
    whole, labels = image.read_bytes(), dataset / "labels/dmpr/000005.json"
    told = labels.read_bytes()
    if harm == "gone":
        image.unlink()
    elif harm == "cut":
        image.write_bytes(whole[: len(whole) // 2])
    elif harm == "size":
        cv2.imwrite(str(image), np.zeros((96, 50, 3), np.uint8))
    else:
        labels.write_text('{"marks": [[500, 5, 501, 5, 1]], "slots": []}')
    came, watcher, _ = score(dataset, tmp_path / "scores")
    assert came == Outcome(10, 9, 1)
    assert watcher.steps.count(True) == 1
    (line,) = watcher.lines
    assert line.startswith(f"not scored: {'labels of ' if harm == 'outside' else ''}{image}: ")
    assert len(scores.read(tmp_path / "scores").candidates) == 9
    image.write_bytes(whole)
    labels.write_bytes(told)
    came, watcher, detector = score(dataset, tmp_path / "scores")
    assert came == Outcome(10, 1, 0) and watcher.lines == [] and len(detector.seen) == 1
    score(dataset, tmp_path / "fresh")
    assert contents(tmp_path / "scores") == contents(tmp_path / "fresh")


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("labels/dmpr/000005.json", "{"),
        ("labels/dmpr/000005.json", '{"marks": [[1' + "0" * 400 + ', 1, 2, 2, 1]], "slots": []}'),
        ("scenes/000005.json", "{"),
        ("scenes/000005.json", '{"plate": {}, "slots": [{"kind": 1}]}'),
        ("scenes/000005.json", '{"plate": {}, "slots": [{"kind": null}, {"kind": "a"}]}'),
    ],
)
def test_one_image_whose_labels_cannot_be_read(dataset, tmp_path, file, text):
    """It is told, as one whose picture cannot be read is, and the others keep their places in the shards."""
    whole, out = tmp_path / "whole", tmp_path / "scores"
    score(dataset, whole)
    kept = (dataset / file).read_bytes()
    (dataset / file).write_text(text)
    came, watcher, _ = score(dataset, out)
    assert came == Outcome(10, 9, 1)
    assert len(watcher.lines) == 1 and "000005.json" in watcher.lines[0]
    assert [contents(out)[name] == contents(whole)[name] for name in contents(whole)] == [True, False, True]
    (dataset / file).write_bytes(kept)
    assert score(dataset, out)[0] == Outcome(10, 1, 0)
    assert contents(out) == contents(whole)
    (dataset / file).unlink()
    assert score(dataset, out)[0] == Outcome(10, 0, 1)
    assert "000005" not in {each.name[-6:] for each in scores.read(out).candidates}


def test_the_order_is_that_of_the_list_now(dataset, tmp_path):
    score(dataset, tmp_path / "scores")
    path = dataset / "manifest.jsonl"
    path.write_text("".join(reversed(path.read_text().splitlines(keepends=True)[:4])))
    score(dataset, tmp_path / "new")
    assert score(dataset, tmp_path / "scores")[0].made == 0
    assert contents(tmp_path / "scores") == contents(tmp_path / "new")


def test_labels_of_a_list_are_corrected(tmp_path):
    lines = [{"image": f"{name}.png", "w": 48, "h": 96, "scale": 10.0, "points": [[9.0, 9.0]]} for name in "ab"]
    folder = listed(tmp_path / "list", *lines)
    score(folder, tmp_path / "scores")
    lines[0]["points"] = [[20.0, 9.0]]
    listed(tmp_path / "list", *lines)
    assert score(folder, tmp_path / "scores")[0] == Outcome(2, 1, 0)
    other = listed(tmp_path / "other", *reversed(lines))
    # Names are alike in many lists, pictures are not.
    same = listed(tmp_path / "same", *lines)
    cv2.imwrite(str(same / "a.png"), np.zeros((96, 48, 3), np.uint8))
    for another in (other, same):
        with pytest.raises(InputError, match="holds scores of another dataset"):
            score(another, tmp_path / "scores")


def test_no_image_that_can_be_scored(dataset, tmp_path):
    for image in (dataset / "images").iterdir():
        image.unlink()
    with pytest.raises(InputError, match="none of its 10 images can be scored"):
        score(dataset, tmp_path / "scores")
    assert contents(tmp_path / "scores") == {}


GRID, SEEN = np.full((3, 2, 3), 0.5), np.ones(2)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ((np.full((3, 2, 3), np.nan), SEEN), "grid of images/000000 holds NaN"),
        ((GRID, np.array([1, np.inf])), "embedding of images/000000 holds NaN or infinite"),
        ((np.ones((3, 2, 6)), SEEN), r"grid of images/000000 has the shape \[3, 2, 6\]: \[any, any, 3\] is allowed"),
        ((np.ones((3, 3)), SEEN), "grid of images/000000 has the shape"),
        ((np.ones((0, 2, 3)), SEEN), "grid of images/000000 has the shape"),
        ((GRID, np.ones((1, 2))), "embedding of images/000000 has the shape"),
        ((GRID, np.ones(0)), "embedding of images/000000 has the shape"),
    ],
)
def test_a_detector_that_is_of_no_use(dataset, tmp_path, told, said):
    with pytest.raises(InputError, match=f"detector dmpr broken: {said}"):
        score(dataset, tmp_path / "scores", Fake("broken", told=lambda mean: told))
    assert contents(tmp_path / "scores") == {}


def test_embeddings_of_several_lengths(dataset, tmp_path):
    fake = Fake(told=lambda mean: (GRID, np.ones(2 + (mean * 255 > 61.5))))
    with pytest.raises(InputError, match="the embedding of images/000002 has 3 numbers: 2, as that of images/000000"):
        score(dataset, tmp_path / "scores", fake)


def test_an_image_that_is_listed_twice(dataset, tmp_path):
    lines = (dataset / "manifest.jsonl").read_text().splitlines(keepends=True)
    (dataset / "manifest.jsonl").write_text("".join([*lines[:3], lines[1]]))
    with pytest.raises(InputError, match="images/000001: is listed twice"):
        score(dataset, tmp_path / "scores")


def test_a_list_of_points_can_be_scored(tmp_path):
    line = {"image": "a.png", "w": 48, "h": 96, "points": [[3, 5]], "place": "p"}
    folder = listed(tmp_path / "real", line)
    came, *_ = score(folder, tmp_path / "scores", height=4.0)
    assert came == Outcome(1, 1, 0)
    ((each,),) = [shards.rows(shards.path_of(tmp_path / "scores", 0), 0)[1]]
    assert each.groups == {"place": "p"}
    assert scores.read(tmp_path / "scores").candidates[0].plate is None


@pytest.mark.parametrize("what", ["nothing", "folder", "empty"])
def test_no_dataset(tmp_path, what):
    folder = tmp_path / "dataset"
    if what != "nothing":
        folder.mkdir()
    if what == "empty":
        made(folder, 0)
    with pytest.raises(InputError, match=str(folder)):
        score(folder, tmp_path / "scores")


def test_a_folder_that_cannot_be_written(dataset, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        score(dataset, tmp_path / "file" / "scores")


def test_an_interrupt_keeps_what_is_finished(dataset, tmp_path):
    class Stopped(Fake):
        def look(self, image, frame):
            if image[0, 0, 0] == 66:
                raise KeyboardInterrupt
            return super().look(image, frame)

    with pytest.raises(KeyboardInterrupt):
        score(dataset, tmp_path / "scores", Stopped())
    assert list(contents(tmp_path / "scores")) == ["scores-000000.parquet"]
    came, *_ = score(dataset, tmp_path / "scores")
    assert came == Outcome(10, 6, 0)


def test_memory_does_not_grow_with_the_dataset(tmp_path, monkeypatch):
    """A dataset of images that are drawn as they are asked for: 300,000 of them take what 300 take."""
    monkeypatch.setattr(scoring, "ROWS", 64)
    alive = peak = 0

    def gone():
        nonlocal alive
        alive -= 1

    def examples(count):
        nonlocal alive, peak
        for k in range(count):
            points = np.full((50, 2), k % 40, float)
            example = Example(f"images/{k:06d}", tmp_path, Frame(48, 96, 20.0), points, None, None, None)
            weakref.finalize(example, gone)
            alive += 1
            peak = max(peak, alive)
            yield example
            del example

    monkeypatch.setattr(reading, "picture", lambda example: np.full((96, 48, 3), 90, np.uint8))
    monkeypatch.setattr(scoring, "dataset_hash", lambda dataset: "many")
    spent = []
    for count in (4 * 64, 20 * 64):
        monkeypatch.setattr(reading, "examples_or_faults", lambda dataset, height, only, count=count: examples(count))
        monkeypatch.setattr(reading, "count", lambda dataset, count=count: count)
        fake = Fake(told=lambda mean: (np.full((3, 2, 3), mean), np.arange(100.0)))
        fake.seen = type("Nothing", (), {"append": lambda self, image: None})()
        tracemalloc.start()
        came, *_ = score(tmp_path, tmp_path / str(count), fake)
        spent.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert came.made == count
    assert peak <= 2 * 64 + 1
    assert spent[1] < 1.2 * spent[0]


def test_what_a_grown_dataset_may_differ_in_is_what_a_job_lets_differ():
    assert {"count", *PATHS} == GROWS
