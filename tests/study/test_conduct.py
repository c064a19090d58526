"""A study from its file to its tables: what is there is not made again, and what has changed is."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import attrs
import psutil
import pytest
from real import STUDY, study, written

pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

from pavemark.errors import InputError
from pavemark.study import lessons, runs
from pavemark.study.conduct import conduct, trials
from pavemark.study.places import split
from pavemark.study.rows import Data
from pavemark.study.runs import Run
from pavemark.study.tables import tables

POOL = 'pools = ["base"]\nstrategy = "cfds"\nkeep = 3\n'
ENSEMBLE = '\n[[rows]]\nname = "two"\nreal = 1.0\nparts = 2\n'
LATER = '\n[[rows]]\nname = "later"\nreal = 0.5\n'
ALONE = STUDY.replace('\n[[rows]]\nname = "easiest"\n' + POOL, "").replace("[pools.base]\ncount = 6\n", "")


def stamps(folder):
    """When each model was written."""
    return {path.name: path.stat().st_mtime_ns for path in (folder / "models").glob("*.onnx")}


def told(lines, study, folder, **options):
    return conduct(study, folder, 1, lines.append, **options)


def test_from_the_file_to_the_tables(tmp_path):
    """The one with a pool: painted, scored by the detector of the real images, and chosen from."""
    pytest.importorskip("bpy", reason="Blender is not installed as a module")
    found, out, lines = study(tmp_path), tmp_path / "out", []
    verdicts = told(lines, found, out)
    assert [(each.name, each.seed, each.real, each.synthetic) for each in verdicts] == [
        ("real", 0, 4, 0),
        ("easiest", 0, 0, 3),
    ]
    models = stamps(out)
    assert len(models) == 2 and {path.suffix for path in (out / "models").iterdir()} == {".onnx", ".pt"}
    results = [json.loads(path.read_text())["alone"] for path in (out / "results").iterdir()]
    assert len(results) == 2
    for verdict in verdicts:
        assert json.loads(json.dumps(verdict.figures)) in results
        assert (verdict.figures["test"]["images"], verdict.figures["test"]["truths"]) == (2, 2)
        assert list(verdict.figures["places"]) == ["east"]
    rows = re.findall(r"^\| (real|easiest) \| (\d) \| (\d) \| (\d) \|", tables(verdicts, "real"), re.M)
    assert rows == [("real", "4", "0", "1"), ("easiest", "0", "3", "1")]

    again = told(lines, found, out)
    assert stamps(out) == models
    assert [each.figures for each in again] == [each.figures for each in verdicts]
    assert sum(line.startswith("trained") for line in lines) == 2


@pytest.fixture(scope="module")
def conducted(tmp_path_factory):
    """A study of real images alone, one row an ensemble, conducted once: its folder, its output and its verdicts."""
    folder = tmp_path_factory.mktemp("study")
    found = study(folder, ALONE + ENSEMBLE)
    return folder, conduct(found, folder / "out", 1, lambda line: None)


def test_an_ensemble_has_a_verdict_a_vote(conducted):
    folder, verdicts = conducted
    assert [verdict.name for verdict in verdicts] == ["real", "two, affirmative", "two, unanimous", "two, consensus"]
    assert len(stamps(folder / "out")) == 3
    results = [sorted(json.loads(path.read_text())) for path in (folder / "out" / "results").iterdir()]
    assert sorted(results) == [["affirmative", "consensus", "unanimous"], ["alone"]]


def test_told_trains_nothing(conducted, monkeypatch):
    folder, verdicts = conducted
    before = stamps(folder / "out")
    more = study(folder, ALONE + ENSEMBLE + LATER)
    # That of the row that judges is there.
    monkeypatch.setattr(runs, "train", None)
    assert [each.name for each in told([], more, folder / "out", only_told=True)] == [each.name for each in verdicts]
    assert stamps(folder / "out") == before


@pytest.mark.parametrize(("text", "said"), [(ALONE, "no detector of 'real'"), (STUDY, "base: is no folder")])
def test_told_before_anything_is_there_makes_nothing(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        told([], study(tmp_path, text), tmp_path / "out", only_told=True)
    assert not [*(tmp_path / "out").rglob("*")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ALONE + ENSEMBLE.replace("2", "5"), "rows: two: parts = 5: up to 4, its images, are allowed"),
        (ALONE + LATER.replace("0.5", "0.1"), "rows: later: real = 0.1: is no image of 4: 0.25 and more are allowed"),
    ],
)
def test_rows_without_images_are_told_before_anything_is_trained(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        told([], study(tmp_path, text), tmp_path / "out")
    assert not [*(tmp_path / "out").rglob("*")]


def test_a_place_that_tells_nothing_is_told_before_anything_is_trained(tmp_path):
    found = study(tmp_path, ALONE)
    labels = tmp_path / "real" / "labels.jsonl"
    labels.write_text(re.sub(r'("east".*)\[\[11.5, 31.5\]\]', r"\1[]", labels.read_text()))
    with pytest.raises(InputError, match="test: has no marking point"):
        told([], found, tmp_path / "out")
    assert not [*(tmp_path / "out").rglob("*")]


def test_how_pictures_are_read_is_of_a_run_too(tmp_path, monkeypatch):
    found = study(tmp_path, ALONE)
    run = Run(tuple(split(found)["train"]), 4, 0, found.training, found.scale)
    before = run.key()
    monkeypatch.setattr(runs, "versions", lambda: {"opencv": "1"})
    assert run.key() != before
    package = Path(runs.__file__).parents[1]
    read = {path.relative_to(package).as_posix() for where in runs.CODE for path in package.glob(where)}
    assert {"study/lessons.py", "detect/scaling.py", "training/detectors/training.py"} < read
    assert len(read) > len(runs.CODE)


def test_a_changed_label_is_another_run(tmp_path):
    found = study(tmp_path, ALONE)

    def key():
        ((run,),) = (trial.runs for trial in trials(found, found.rows, Data(tuple(split(found)["train"]), {})))
        return run.key()

    before = key()
    assert key() == before
    labels = tmp_path / "real" / "labels.jsonl"
    text = labels.read_text()
    labels.write_text(text.replace("[[11.5, 31.5]]", "[[11.5, 31.75]]", 1))
    assert key() != before
    labels.write_text(text)
    assert key() == before
    # What is judged by is not learned from.
    labels.write_text("[[11.5, 31.75]]".join(text.rsplit("[[11.5, 31.5]]", 1)))
    assert key() == before


def test_settings_are_of_a_run_too(tmp_path):
    found = study(tmp_path, ALONE)
    run = Run(tuple(split(found)["train"]), 4, 0, found.training, found.scale)
    others = [
        attrs.evolve(run, steps=5),
        attrs.evolve(run, seed=1),
        attrs.evolve(run, scale=11.0),
        attrs.evolve(run, training=attrs.evolve(found.training, batch=3)),
        attrs.evolve(run, examples=run.examples[::-1]),
        attrs.evolve(run, start=run),
        attrs.evolve(run, start=attrs.evolve(run, seed=1)),
    ]
    assert len({each.key() for each in [run, *others]}) == 8


def test_fine_tuning_starts_from_the_weights_of_the_first_run(tmp_path, monkeypatch):
    found = study(tmp_path, ALONE)
    train = tuple(split(found)["train"])
    first = Run(train[:2], 4, 0, found.training, found.scale)
    run = Run(train[2:], 2, 0, found.training, found.scale, first)
    begun = []

    def learnt(run, start, state):
        begun.append((run, start))
        return b"model", f"weights of {run.steps}".encode()

    monkeypatch.setattr(lessons, "learnt", learnt)
    assert runs.train(run, tmp_path).read_bytes() == b"model"
    assert begun == [(first, None), (run, b"weights of 4")]
    # One that others start from is trained once.
    runs.train(attrs.evolve(run, seed=1), tmp_path)
    assert [start for _, start in begun[2:]] == [b"weights of 4"]


def test_weights_to_begin_with_change_the_detector(tmp_path):
    found = study(tmp_path, ALONE)
    train = tuple(split(found)["train"])
    first = Run(train[:2], 4, 0, found.training, found.scale)
    _, weights = lessons.learnt(first, None, tmp_path / "a.state")
    run = Run(train[2:], 1, 0, found.training, found.scale, first)
    model, _ = lessons.learnt(run, weights, tmp_path / "b.state")
    assert model == lessons.learnt(run, weights, tmp_path / "b.state")[0]
    assert model != lessons.learnt(run, None, tmp_path / "c.state")[0]


PROGRAM = """
import sys
from pathlib import Path

from pavemark.study.design import read
from pavemark.study.places import split
from pavemark.study.runs import Run
from pavemark.study.training import train_all

if __name__ == "__main__":
    found = read(Path(sys.argv[1]))
    train = tuple(split(found)["train"])
    wanted = [(f"{steps}", Run(train, steps, 0, found.training, found.scale)) for steps in (1, 10**6)]
    train_all(wanted, Path(sys.argv[2]), 2, lambda line: print(line, flush=True))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_training_whose_program_is_killed_leaves_no_process(tmp_path, number):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    command = [sys.executable, str(program), str(written(tmp_path, ALONE)), str(tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as started:
        assert started.stdout.readline().startswith("trained 1/2")  # the other is under way, or about to be
        children = psutil.Process(started.pid).children()
        started.send_signal(number)
    assert len(children) > 1
    _, left = psutil.wait_procs(children, timeout=20)
    for each in left:
        each.kill()
    assert not left
