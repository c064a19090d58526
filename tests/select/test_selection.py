"""A selection is a folder that datasets' readers read, with the dataset's own lines, in its order."""

import json
import os
import shutil

import attrs
import numpy as np
import pytest
from scored import ORIGIN, row, scores

from detect.datasets import listed, made
from pavemark.detect import reading
from pavemark.errors import InputError
from pavemark.select import material, selection
from pavemark.select.choice import Wanted
from pavemark.select.selection import Outcome, select

COUNT = 9


@pytest.fixture
def dataset(tmp_path):
    return made(tmp_path / "dataset", COUNT)


def rows(losses):
    return [(f"images/{k:06d}", loss, f"plate{k % 2}", "base") for k, loss in enumerate(losses)]


@pytest.fixture
def scored(dataset, tmp_path):
    return scores(tmp_path / "scores", dataset, rows([0.5, 0.1, 0.4, 0.1, 0.9, 0.2, 0.3, 0.7, 0.8]), size=4)


def kept(out):
    return [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]


def tree(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_selection_is_read_as_a_dataset(dataset, scored, tmp_path):
    out = tmp_path / "kept"
    assert select(dataset, scored, out, Wanted("cfds", 4)) == Outcome(4, COUNT, 0)
    found = list(reading.examples(out))
    assert [example.name for example in found] == [f"images/{k:06d}" for k in (1, 3, 5, 6)]
    assert reading.count(out) == 4 and reading.picture(found[1])[0, 0, 0] == 63
    own = [json.loads(line) for line in (dataset / "manifest.jsonl").read_text().splitlines()]
    assert kept(out) == [
        own[k] | {"name": f"images/{k:06d}", "loss": loss, "rank": rank}
        for k, loss, rank in ((1, 0.1, 1), (3, 0.1, 2), (5, 0.2, 3), (6, 0.3, 4))
    ]


def test_the_record_tells_all_that_was_asked_for(dataset, scored, tmp_path):
    out = tmp_path / "deep" / "kept"
    select(dataset, scored, out, Wanted("random", 3, seed=5, cap_per_plate=2, drop_hardest=0.2))
    told = json.loads((out / "selection.json").read_text())
    assert (told["strategy"], told["keep"], told["seed"]) == ("random", 3, 5)
    assert (told["cap_per_plate"], told["drop_hardest"], told["near_duplicates"]) == (2, 0.2, None)
    assert (told["model"], told["family"], told["learner"]) == ("model", "dmpr", None)
    assert told["dataset"] == told["source"] == told["listed"] == "../../dataset"
    assert str(tmp_path) not in (out / "selection.json").read_text()


def test_the_folders_can_be_moved_together(dataset, scored, tmp_path):
    select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))
    (tmp_path / "there").mkdir()
    for name in ("dataset", "kept"):
        shutil.move(tmp_path / name, tmp_path / "there" / name)
    assert len([reading.picture(example) for example in reading.examples(tmp_path / "there" / "kept")]) == 2


def test_the_shards_the_order_and_the_run_change_nothing(dataset, scored, tmp_path):
    wanted = Wanted("coverage", 5, cap_per_plate=3)
    select(dataset, scored, tmp_path / "one", wanted)
    other = scores(tmp_path / "other", dataset, rows([0.5, 0.1, 0.4, 0.1, 0.9, 0.2, 0.3, 0.7, 0.8])[::-1], size=2)
    select(dataset, other, tmp_path / "two", wanted)
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    before = tree(tmp_path / "one")
    select(dataset, scored, tmp_path / "one", wanted)
    assert tree(tmp_path / "one") == before


def test_learnable_takes_two_scores(dataset, scored, tmp_path):
    learner = scores(tmp_path / "learner", dataset, rows([0.6, 0.9, 0.4, 0.2, 0.99, 0.2, 0.3, 0.7, 0.8]))
    select(dataset, scored, tmp_path / "kept", Wanted("learnable", 3), learner=learner)
    # Reducible by 0.8, 0.1 and 0.1; what is reducible by 0.09 is among the hardest quarter.
    assert [(line["name"], line["rank"]) for line in kept(tmp_path / "kept")] == [
        ("images/000000", 3),
        ("images/000001", 1),
        ("images/000003", 2),
    ]


def test_like_real_takes_scores_of_real_images(dataset, tmp_path):
    """Image k looks k · 10° from the first; of the real ones two look like 6, one like 2."""
    way = [(np.cos(np.radians(10 * k)), np.sin(np.radians(10 * k))) for k in range(COUNT)]
    scored = scores(tmp_path / "scores", dataset, [(*row, way[k]) for k, row in enumerate(rows([0.5] * COUNT))])
    lines = [{"image": f"{name}.png", "w": 48, "h": 96, "scale": 22.7, "points": []} for name in "abc"]
    streets = listed(tmp_path / "streets", *lines)
    real = scores(tmp_path / "real", streets, [("a", 0.1, None, None, way[6]), ("b", 0.1, None, None, way[6])])
    wanted = Wanted("like-real", 2)
    select(dataset, scored, tmp_path / "two", wanted, real=real)
    assert [line["name"] for line in kept(tmp_path / "two") if line["rank"] == 1] == ["images/000006"]
    told = json.loads((tmp_path / "two" / "selection.json").read_text())
    assert len(told["real"]) == 64 and told["real"] in (tmp_path / "two" / "report.html").read_text()

    both = [("a", 0.1, None, None, way[6]), ("b", 0.1, None, None, way[6]), ("c", 0.1, None, None, way[2])]
    more = scores(tmp_path / "more", streets, both)
    select(dataset, scored, tmp_path / "three", wanted, real=more)
    # 5 is between them, 2 cos 10° + cos 30° in all; then 2 adds more than 6 does.
    ranked = {line["rank"]: line["name"] for line in kept(tmp_path / "three")}
    assert ranked == {1: "images/000005", 2: "images/000002"}
    backwards = scores(tmp_path / "backwards", streets, both[::-1])
    select(dataset, scored, tmp_path / "three", wanted, real=backwards)
    with pytest.raises(InputError, match="holds another selection: real was"):
        select(dataset, scored, tmp_path / "two", wanted, real=more)
    other = scores(tmp_path / "other", streets, both, attrs.evolve(ORIGIN, model="another"))
    with pytest.raises(InputError, match=r"other: holds scores of the detector another: of model, as .*scores, are"):
        select(dataset, scored, tmp_path / "four", wanted, real=other)


def test_a_selection_of_a_selection(dataset, scored, tmp_path):
    select(dataset, scored, tmp_path / "many", Wanted("cfds", 6))
    select(tmp_path / "many", scored, tmp_path / "few", Wanted("random", 2, drop_hardest=0.5))
    few = [line["name"] for line in kept(tmp_path / "few")]
    assert len(few) == 2 and set(few) <= {"images/000001", "images/000003", "images/000005"}
    assert len([reading.picture(example) for example in reading.examples(tmp_path / "few")]) == 2
    told = json.loads((tmp_path / "few" / "selection.json").read_text())
    assert (told["dataset"], told["listed"]) == ("../dataset", "../many")


def test_near_duplicates_go(dataset, tmp_path):
    losses = [0.5, 0.1, 0.4, 0.1, 0.9, 0.2, 0.3, 0.7, 0.8]
    seen = [(np.cos(a), np.sin(a)) for a in (0, 1, 1.001, 1.002, 2, 2.5, 2.501, 3, 3.001)]
    told = [(*each, embedding) for each, embedding in zip(rows(losses), seen, strict=True)]
    scored = scores(tmp_path / "scores", dataset, told, size=2)
    select(dataset, scored, tmp_path / "kept", Wanted("cfds", 5, near_duplicates=1e-4))
    assert [line["name"][-1] for line in kept(tmp_path / "kept")] == ["0", "1", "4", "5", "7"]
    with pytest.raises(InputError, match="--keep: 6: 5 of 9"):
        select(dataset, scored, tmp_path / "more", Wanted("cfds", 6, near_duplicates=1e-4))
    assert not (tmp_path / "more").exists()


@pytest.mark.parametrize("way", material.WAYS)
def test_a_selection_that_has_its_images(dataset, scored, tmp_path, way):
    out, steps = tmp_path / "kept", []
    select(dataset, scored, out, Wanted("cfds", 3), way=way, step=lambda: steps.append(1))
    assert len(steps) == 3
    assert sorted(path.name for path in (out / "images").iterdir()) == ["000001.png", "000003.png", "000005.png"]
    assert (out / "images/000003.png").samefile(dataset / "images/000003.png") == (way == "link")
    assert not (out / "job.json").samefile(dataset / "job.json")
    before = tree(out)
    select(dataset, scored, out, Wanted("cfds", 3), way=way)
    assert tree(out) == before
    shutil.rmtree(dataset)
    found = list(reading.examples(out))
    assert [reading.picture(example)[0, 0, 0] for example in found] == [61, 63, 65]
    assert [len(example.points) for example in found] == [2, 2, 2]
    select(out, scored, tmp_path / "fewer", Wanted("cfds", 2))
    assert [line["name"] for line in kept(tmp_path / "fewer")] == ["images/000001", "images/000003"]


def test_where_there_are_no_hard_links(dataset, scored, tmp_path, monkeypatch):
    def refuse(*names):
        raise OSError(18, "Invalid cross-device link")

    monkeypatch.setattr(os, "link", refuse)
    select(dataset, scored, tmp_path / "soft", Wanted("cfds", 2), way="link")
    link = tmp_path / "soft/images/000001.png"
    assert link.is_symlink() and not link.readlink().is_absolute()
    assert len([reading.picture(each) for each in reading.examples(tmp_path / "soft")]) == 2
    monkeypatch.setattr("pathlib.Path.symlink_to", refuse)
    select(dataset, scored, tmp_path / "copied", Wanted("cfds", 2), way="link")
    assert not (tmp_path / "copied/images/000001.png").is_symlink()
    assert len([reading.picture(each) for each in reading.examples(tmp_path / "copied")]) == 2
    assert not [path for path in tmp_path.rglob("*.part")]


def test_files_that_lack(dataset, scored, tmp_path):
    (dataset / "scenes/000003.json").unlink()
    for way in (None, *material.WAYS):
        with pytest.raises(InputError, match=r"scenes/000003.json"):
            select(dataset, scored, tmp_path / str(way), Wanted("cfds", 3), way=way)
        assert not (tmp_path / str(way)).exists(), "nothing is begun"


def test_paths_that_lead_out_of_a_dataset_are_not_followed(dataset, scored, tmp_path):
    lines = [json.loads(line) for line in (dataset / "manifest.jsonl").read_text().splitlines()]
    (tmp_path / "secret").write_text("not theirs")
    for line in lines:
        line["files"] |= {"../secret": "0", str(tmp_path / "secret"): "0"}
    (dataset / "manifest.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    (tmp_path / "deep").mkdir()
    select(dataset, scored, tmp_path / "deep" / "kept", Wanted("cfds", 2), way="copy")
    assert not (tmp_path / "deep" / "secret").exists()


def test_images_without_scores(dataset, tmp_path):
    scored = scores(tmp_path / "scores", dataset, rows([0.1] * 9)[:6])
    with pytest.raises(InputError, match=r"lacks 3 of the images of .*, the first is images/000006"):
        select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))
    learner = scores(tmp_path / "all", dataset, rows([0.1] * 9))
    with pytest.raises(InputError, match=f"{scored}: lacks 3"):
        select(dataset, learner, tmp_path / "kept", Wanted("learnable", 2), learner=scored)
    assert not (tmp_path / "kept").exists()


def test_images_that_cannot_be_read_are_left_out(dataset, tmp_path):
    every = rows([0.5, 0.1, 0.4, 0.1, 0.9, 0.2, 0.3, 0.7, 0.8])
    scored = scores(tmp_path / "scores", dataset, [each for each in every if each[0][-1] not in "15"])
    (dataset / "images/000001.png").unlink()
    (dataset / "images/000005.png").write_bytes(b"no picture")
    told = []
    assert select(dataset, scored, tmp_path / "kept", Wanted("cfds", 3), tell=told.append) == Outcome(3, 7, 2)
    assert [line["name"][-1] for line in kept(tmp_path / "kept")] == ["2", "3", "6"]
    assert [line.split(": ")[1] for line in told] == [str(dataset / f"images/00000{k}.png") for k in "15"]
    # The learner may have scored another than the reference has.
    (dataset / "images/000003.png").unlink()
    learner = scores(tmp_path / "learner", dataset, [each for each in every if each[0][-1] != "3"])
    came = select(dataset, scored, tmp_path / "learned", Wanted("learnable", 2), learner=learner, tell=told.append)
    assert came == Outcome(2, 6, 3) and "images/000003.png" in told[3]
    with pytest.raises(InputError, match="--keep: 8: 7 of 7 images are left"):
        select(dataset, scored, tmp_path / "more", Wanted("cfds", 8))


def test_a_damaged_label_of_an_image_that_is_not_kept(dataset, scored, tmp_path):
    (dataset / "labels/dmpr/000008.json").write_text("{")
    select(dataset, scored, tmp_path / "kept", Wanted("cfds", 3), way="copy")
    assert len(kept(tmp_path / "kept")) == 3
    assert "cannot be read" in (tmp_path / "kept" / "report.html").read_text()


def test_an_image_that_could_be_scored_is_not_left_out(dataset, tmp_path, monkeypatch):
    scored = scores(tmp_path / "scores", dataset, rows([0.1] * 9)[:3])
    (dataset / "images/000003.png").unlink()
    opened = []
    monkeypatch.setattr(selection, "picture", lambda example: opened.append(example.name) or reading.picture(example))
    with pytest.raises(InputError, match=r"lacks 5 of the images of .*, the first is images/000004"):
        select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))
    # Of a dataset of which no part has been scored yet not every picture is opened.
    assert opened == ["images/000003", "images/000004"]
    assert not (tmp_path / "kept").exists()


def test_scores_of_another_dataset(dataset, scored, tmp_path):
    (dataset / "job.json").write_text(json.dumps({"count": 9, "formats": ["dmpr"], "seed": 8}))
    with pytest.raises(InputError, match="holds scores of another dataset"):
        select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))


def test_a_dataset_that_lists_an_image_twice(dataset, scored, tmp_path):
    with (dataset / "manifest.jsonl").open("a") as stream:
        stream.write((dataset / "manifest.jsonl").read_text().splitlines()[2] + "\n")
    with pytest.raises(InputError, match="images/000002: is listed twice"):
        select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))


def test_a_list_of_real_images_is_not_selected_from(tmp_path):
    folder = listed(tmp_path / "real", {"image": "a.png", "w": 48, "h": 96, "scale": 20, "points": []})
    scored = scores(tmp_path / "scores", folder, [("a", 0.1)])
    with pytest.raises(InputError, match=r"manifest.jsonl: cannot be read"):
        select(folder, scored, tmp_path / "kept", Wanted("cfds", 1))


def test_a_folder_that_holds_something_else(dataset, scored, tmp_path):
    out = tmp_path / "kept"
    select(dataset, scored, out, Wanted("cfds", 2))
    with pytest.raises(InputError, match="holds another selection: keep was 2 and is 3; use another folder"):
        select(dataset, scored, out, Wanted("cfds", 3))
    assert len(kept(out)) == 2
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("precious")
    with pytest.raises(InputError, match=r"has files and no selection.json"):
        select(dataset, scored, tmp_path / "mine", Wanted("cfds", 2))
    for folder in (dataset, out):
        with pytest.raises(InputError, match="is the folder of the dataset"):
            select(folder, scored, folder, Wanted("cfds", 1))
    with pytest.raises(InputError, match=r"is a file|cannot be written"):
        select(dataset, scored, tmp_path / "mine" / "notes.txt", Wanted("cfds", 2))


def test_a_field_that_is_null_or_not_there_is_the_same(dataset, scored, tmp_path):
    out = tmp_path / "kept"
    select(dataset, scored, out, Wanted("cfds", 2))
    before = tree(out)
    told = json.loads((out / "selection.json").read_text())
    del told["cap_per_plate"]
    (out / "selection.json").write_text(json.dumps(told | {"of_a_version_to_come": None}))
    assert select(dataset, scored, out, Wanted("cfds", 2)) == Outcome(2, COUNT, 0)
    assert tree(out) == before


def test_a_selection_that_was_cut_short_is_no_dataset_and_goes_on(dataset, scored, tmp_path, monkeypatch):
    def stopped(*given):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(selection, "materialise", stopped)
        with pytest.raises(KeyboardInterrupt):
            select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2), way="copy")
    with pytest.raises(InputError):
        list(reading.examples(tmp_path / "kept"))
    select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2), way="copy")
    assert len(list(reading.examples(tmp_path / "kept"))) == 2


@pytest.mark.parametrize("way", ["copy", "link"])
def test_what_a_grown_dataset_no_longer_keeps_goes(dataset, scored, tmp_path, way):
    """Two easier images come, and the folder is as if they had always been there."""
    asked = Wanted("cfds", 2)
    select(dataset, scored, tmp_path / "kept", asked, way=way)
    before = {path.name for path in (tmp_path / "kept/images").iterdir()}
    made(dataset, COUNT + 2)
    again = scores(tmp_path / "again", dataset, rows([0.5, 0.1, 0.4, 0.1, 0.9, 0.2, 0.3, 0.7, 0.8, 0.01, 0.02]))
    select(dataset, again, tmp_path / "kept", asked, way=way)
    select(dataset, again, tmp_path / "fresh", asked, way=way)
    assert {path.name for path in (tmp_path / "kept/images").iterdir()} != before
    assert tree(tmp_path / "kept") == tree(tmp_path / "fresh")


def test_scores_may_be_of_more_images(dataset, tmp_path):
    more = [*rows([0.3] * 9), *[(f"images/{k:06d}", 0.1) for k in range(9, 20)]]
    scored = scores(tmp_path / "scores", dataset, more)
    assert select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2)) == Outcome(2, 9, 0)
    assert row("a", 0.1).groups == {} and ORIGIN.listed == ""


@pytest.mark.parametrize("strategy", ["cfds", "random"])
def test_what_has_changed_since_it_was_scored_is_not_kept(dataset, scored, tmp_path, strategy):
    """Its loss is another's: by the labels as they were it may be the best of all."""
    label = dataset / "labels/dmpr/000003.json"
    told = json.loads(label.read_text())
    told["marks"][0][0] += 4
    label.write_text(json.dumps(told))
    with pytest.raises(InputError, match=r"000003\.png: it or its labels have changed since .*: pavemark score"):
        select(dataset, scored, tmp_path / "kept", Wanted(strategy, COUNT))
    assert not (tmp_path / "kept").exists(), "nothing is begun"
    with pytest.raises(InputError, match="changed"):
        select(dataset, scored, tmp_path / "kept", Wanted("cfds", 2))
    (dataset / "images/000004.png").unlink()
    select(dataset, scored, tmp_path / "one", Wanted("cfds", 1))
    label.write_text(json.dumps(told | {"marks": [[told["marks"][0][0] - 4, *told["marks"][0][1:]], told["marks"][1]]}))
    with pytest.raises(InputError, match=r"000004\.png: has gone"):
        select(dataset, scored, tmp_path / "kept", Wanted(strategy, COUNT))
