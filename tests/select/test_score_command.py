"""`pavemark score` and `pavemark select` as they are called: exit codes, one line an error, and what a stop leaves."""

import json
import signal
import subprocess
import sys
import time

import pyarrow.parquet
import pytest

from detect.datasets import SIZE, made, picture
from detect.graphs import graph
from pavemark import cli
from pavemark.detect import reading


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    return graph(tmp_path_factory.mktemp("model") / "detector.onnx", said={"pixels_per_metre": "22.7"})


@pytest.fixture
def dataset(tmp_path):
    return made(tmp_path / "dataset", 12)


def run(*words):
    with pytest.raises(SystemExit) as left:
        cli.main(list(map(str, words)))
    return left.value.code


def refused(capfd, *words):
    assert run(*words) == 2
    said = capfd.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1
    return said.removeprefix("error: ").strip()


def test_scores_and_selects(dataset, model, tmp_path, capfd):
    scored, out = tmp_path / "scores", tmp_path / "kept"
    assert run("score", dataset, "--model", model, "--out", scored) == 0
    assert capfd.readouterr().out == f"12 of 12 images scored in {scored}, 12 now\n"
    assert run("score", dataset, "--model", model, "--out", scored) == 0
    assert capfd.readouterr().out == f"12 of 12 images scored in {scored}, 0 now\n"
    assert run("select", dataset, "--scores", scored, "--keep", "5", "--out", out, "--materialize", "copy") == 0
    said = capfd.readouterr().out
    assert said == f"5 of 12 images kept in {out}; to be looked at: {out / 'report.html'}\n"
    kept = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    # The confidence of every cell is how bright the picture is: of two as full the darker is less wrong.
    assert [line["name"][-2:] for line in kept] == [example.name[-2:] for example in reading.examples(out)]
    assert sorted(line["rank"] for line in kept) == [1, 2, 3, 4, 5]
    losses = {line["rank"]: line["loss"] for line in kept}
    assert losses == dict(sorted(losses.items(), key=lambda each: (each[1], each[0])))


@pytest.mark.parametrize("strategy", ["cfds", "ehds", "random", "coverage", "learnable", "like-real"])
def test_every_strategy_with_every_modifier(dataset, model, tmp_path, strategy):
    scored, out = tmp_path / "scores", tmp_path / "kept"
    run("score", dataset, "--model", model, "--out", scored, "--quiet")
    learner = {"learnable": ("--scores-learner", scored), "like-real": ("--scores-real", scored)}.get(strategy, ())
    words = ("--cap-per-plate", "3", "--drop-hardest", "0.1", "--near-duplicates", "1e-9", "--seed", "3", "--quiet")
    assert (
        run("select", dataset, "--scores", scored, "--keep", 2, "--out", out, "--strategy", strategy, *learner, *words)
        == 0
    )
    assert len(list(reading.examples(out))) == 2


def test_parts_make_the_whole(dataset, model, tmp_path, capfd, monkeypatch):
    from pavemark.select import scoring  # noqa: PLC0415 - beside the command

    monkeypatch.setattr(scoring, "ROWS", 5)
    for part in ("1/2", "0/2"):
        assert run("score", dataset, "--model", model, "--out", tmp_path / "parts", "--shard", part) == 0
    assert "part 0/2: 7 of 7 images" in capfd.readouterr().out
    run("score", dataset, "--model", model, "--out", tmp_path / "whole", "--workers", 3)
    for path in (tmp_path / "whole").iterdir():
        assert (tmp_path / "parts" / path.name).read_bytes() == path.read_bytes()
    assert len(list((tmp_path / "whole").iterdir())) == 3


def test_an_image_that_cannot_be_read(dataset, model, tmp_path, capfd):
    (dataset / "images/000004.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    assert run("score", dataset, "--model", model, "--out", tmp_path / "scores") == 1
    said = capfd.readouterr()
    assert said.out.endswith("11 of 12 images scored in " + f"{tmp_path / 'scores'}, 11 now; 1 cannot be scored\n")
    assert said.err.startswith(f"not scored: {dataset / 'images/000004.png'}: ") and said.err.count("\n") == 1
    out = tmp_path / "kept"
    assert run("select", dataset, "--scores", tmp_path / "scores", "--keep", "3", "--out", out) == 1
    said = capfd.readouterr()
    assert said.out == f"3 of 11 images kept in {out}; 1 left out; to be looked at: {out / 'report.html'}\n"
    assert said.err.startswith(f"left out: {dataset / 'images/000004.png'}: ") and said.err.count("\n") == 1
    picture(dataset / "images/000004.png")
    words = ("select", dataset, "--scores", tmp_path / "scores", "--keep", "3", "--out", tmp_path / "again")
    assert "lacks 1 of the images" in refused(capfd, *words)


def test_labels_of_no_use_are_left_out(dataset, model, tmp_path, capfd):
    """A point outside its picture, and markings that no label tells of: neither is an image without points."""
    labels = json.loads((dataset / "labels/dmpr/000002.json").read_text())
    labels["marks"][0][0] = SIZE[0] + 2.0
    (dataset / "labels/dmpr/000002.json").write_text(json.dumps(labels))
    scene = json.loads((dataset / "scenes/000007.json").read_text())
    scene |= {"slots": [], "markings": [{"kind": "original"}]}
    (dataset / "scenes/000007.json").write_text(json.dumps(scene))
    assert run("score", dataset, "--model", model, "--out", tmp_path / "scores") == 1
    said = capfd.readouterr()
    assert "2 cannot be scored" in said.out and "within the picture" in said.err and "painted anew" in said.err
    words = ("select", dataset, "--scores", tmp_path / "scores", "--keep", "10", "--out", tmp_path / "kept")
    assert run(*words) == 1
    assert "10 of 10 images kept" in capfd.readouterr().out
    names = {json.loads(line)["name"] for line in (tmp_path / "kept/manifest.jsonl").read_text().splitlines()}
    assert names == {f"images/{k:06d}" for k in range(12)} - {"images/000002", "images/000007"}


def test_what_images_are_sorted_by_is_kept_up_to_date(dataset, model, tmp_path, capfd):
    words = ("score", dataset, "--model", model, "--out", tmp_path / "scores")
    assert run(*words) == 0
    scene = json.loads((dataset / "scenes/000003.json").read_text()) | {"noise": {"sigma": 2}}
    (dataset / "scenes/000003.json").write_text(json.dumps(scene))
    capfd.readouterr()
    assert run(*words) == 0
    assert "12 of 12 images scored" in (said := capfd.readouterr().out) and ", 1 now" in said
    rows = pyarrow.parquet.read_table(tmp_path / "scores").to_pylist()
    assert [row["domain"] for row in rows] == ["base"] * 3 + ["noise"] + ["base"] * 8


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"without": ("grid",)}, "has no grid"),
        ({"said": {"pavemark": None}}, "is not a detector"),
        ({"times": float("nan")}, "no finite numbers"),
        ({"times": 9.0}, "0 to 1"),
    ],
)
def test_a_model_that_is_of_no_use(dataset, tmp_path, capfd, change, said):
    wrong = graph(tmp_path / "wrong.onnx", **change)
    told = refused(capfd, "score", dataset, "--model", wrong, "--out", tmp_path / "scores")
    assert str(wrong) in told and said in told
    assert not list((tmp_path / "scores").glob("*.parquet"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--shard", "2/2"), "K from 0 to N - 1"),
        (("--workers", "0"), "0 is not in the range"),
        (("--height", "-1"), "-1"),
        (("--height", "nan"), "nan: a finite number"),
        (("--model", ""), "it is empty: a file is needed"),
    ],
)
def test_score_options(dataset, model, tmp_path, capfd, words, said):
    assert said in refused(capfd, "score", dataset, "--model", model, "--out", tmp_path / "scores", *words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--keep", "0"), "0 is not in the range"),
        (("--keep", "13"), "--keep: 13: 12 of 12 images are left"),
        (("--keep", "3", "--strategy", "best"), "'best' is not one of"),
        (("--keep", "3", "--strategy", "learnable"), "--scores-learner"),
        (("--keep", "3", "--strategy", "like-real"), "--scores-real: goes with --strategy like-real, and it needs it"),
        (("--keep", "3", "--scores-real", "x"), "--scores-real: goes with --strategy like-real"),
        (("--keep", "3", "--scores-learner", "x"), "--scores-learner: goes with --strategy learnable"),
        (("--keep", "3", "--near-duplicates", "0"), "near-duplicates"),
        (("--keep", "3", "--near-duplicates", "nan"), "nan: a finite number"),
        (("--keep", "3", "--drop-hardest", "nan"), "nan: a finite number"),
        (("--keep", "3", "--strategy", "learnable", "--learnable", "nan"), "nan: a finite number"),
        (("--keep", "3", "--drop-hardest", "2"), "drop-hardest"),
        (("--keep", "3", "--cap-per-plate", "0"), "cap-per-plate"),
        (("--keep", "3", "--cap-per-plate", "1"), "--keep: 3: 2 of 12 images are left"),
        (("--keep", "3", "--scores", "nowhere"), "nowhere: holds no scores"),
    ],
)
def test_select_options(dataset, model, tmp_path, capfd, words, said):
    run("score", dataset, "--model", model, "--out", tmp_path / "scores", "--quiet")
    told = refused(capfd, "select", dataset, "--scores", tmp_path / "scores", "--out", tmp_path / "kept", *words)
    assert said in told
    assert not (tmp_path / "kept").exists()


def test_the_command_line_is_there_without_what_blender_lacks():
    code = "import sys, pavemark.cli; print(sorted({'pyarrow', 'matplotlib', 'pyamg'} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


SLOW = """
import signal, sys, time
# What starts in the background of a script is born deaf to it.
signal.signal(signal.SIGINT, signal.default_int_handler)
from pavemark import cli
from pavemark.detect import learned
from pavemark.select import scoring
scoring.ROWS = 4
look = learned.Learned.look
def slow(self, image, frame):
    if image[0, 0, 0] > 67:
        print("waiting", flush=True)
        time.sleep(0.3)
    return look(self, image, frame)
learned.Learned.look = slow
cli.main(sys.argv[1:])
"""


def test_ctrl_c_keeps_finished_shards(dataset, model, tmp_path):
    words = ["score", dataset, "--model", model, "--out", tmp_path / "scores", "--workers", "1"]
    command = [sys.executable, "-c", SLOW, *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            if line == "waiting\n":
                break
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and said.strip() == ""
    assert time.monotonic() - start < 20
    assert sorted(path.name for path in (tmp_path / "scores").iterdir()) == [
        "scores-000000.parquet",
        "scores-000001.parquet",
    ]
