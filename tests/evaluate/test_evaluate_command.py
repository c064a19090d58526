"""`pavemark evaluate`: what it says and writes, and the line in which it refuses what it cannot judge."""

import json
import os
import sys
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from labelled import Said, dataset, detection

from detect.graphs import graph
from pavemark.cli import main
from pavemark.detect import reading
from pavemark.errors import InputError

POINTS = [(20, 20), (20, 60), (80, 40)]
SLOTS = [(0, 1)]
GOOD = detection([(21, 20), (20, 61), (100, 80)], [0.9, 0.8, 0.3], [(0, 1), (1, 2)], [0.7, 0.4])
NOTHING = detection([], [])
RIGHT = detection(POINTS, [0.9, 0.9, 0.9], SLOTS, [0.6])

MODELS = {
    "good.onnx": Said({60: GOOD, 70: NOTHING, 80: GOOD}, "g" * 64),
    "right.onnx": Said(dict.fromkeys((60, 70, 80), RIGHT), "r" * 64),
    "nothing.onnx": Said(dict.fromkeys((60, 70, 80), NOTHING), "n" * 64),
}


def run_in(folder, capsys):
    """Runs the command in this process, on a dataset of a folder."""

    def run(*words, data="judged"):
        with pytest.raises(SystemExit) as left:
            main(["evaluate", str(folder / data), *map(str, words)])
        told = capsys.readouterr()
        return SimpleNamespace(code=left.value.code, out=told.out, err=told.err)

    return run


@pytest.fixture
def evaluate(tmp_path, monkeypatch, capsys):
    """Runs the command with detectors that say what is known beforehand."""

    def opened(path):
        if path.name not in MODELS:
            raise InputError(path, "cannot be read")
        return MODELS[path.name]

    monkeypatch.setattr(sys.modules["pavemark.cli.evaluate"], "opened", opened)
    dataset(tmp_path / "judged", [(60, POINTS, SLOTS), (70, POINTS, SLOTS), (80, POINTS, [])])
    dataset(tmp_path / "chosen", [(60, POINTS, SLOTS)])
    dataset(tmp_path / "alone", [(60, POINTS, []), (70, POINTS, [])], points_alone=True)

    return run_in(tmp_path, capsys)


def row(text, name):
    """The cells of the first row of a printed table that begins so."""
    line = next(line for line in text.splitlines() if line.strip("│ ").startswith(name))
    return [cell.strip() for cell in line.strip("│").split("│")]


def test_a_table_of_slots_and_one_of_points(evaluate):
    done = evaluate("--model", "good.onnx")
    assert done.code == 0 and done.err == ""
    slots, points = done.out.split("points at confidence 0.5")
    assert "slots at confidence 0.5" in slots
    # Slots: 2 found, 1 of 2 right, and at once, for both are as sure: recall 1/2 is reached with precision 1/2.
    # Points: 4 found, all right, of 9.
    assert row(slots, "all")[:4] == ["all", "3", "2", "2"]
    assert [cell.split()[0] for cell in row(slots, "all")[4:]] == ["50.00", "50.00", "50.00", "25.00"]
    assert row(points, "all")[:4] == ["all", "3", "9", "4"]
    assert [cell.split()[0] for cell in row(points, "all")[4:6]] == ["100.00", "44.44"]


def test_points_alone(evaluate):
    done = evaluate("--model", "good.onnx", data="alone")
    assert done.code == 0 and "slots at" not in done.out
    assert [cell.split()[0] for cell in row(done.out, "all")[4:6]] == ["100.00", "33.33"]


def test_by_place_and_by_domain(evaluate):
    done = evaluate("--model", "good.onnx", "--by", "plate, domain")
    slots = done.out.split("points at")[0]
    assert row(slots, "plate even.png")[1:4] == ["2", "1", "2"]
    assert row(slots, "plate odd.png")[1:5] == ["1", "1", "0", "–"]
    assert row(slots, "domain base")[1:4] == ["3", "2", "2"]


def test_names_are_told_whole(tmp_path, evaluate):
    """Two that are cut at the same letter could not be told apart."""
    dataset(tmp_path / "long", [(60, POINTS, SLOTS), (70, POINTS, SLOTS)])
    names = ["east_of_the_" + "very_" * 8 + name for name in ("first.png", "second.png")]
    lines = [json.loads(line) for line in (tmp_path / "long/manifest.jsonl").read_text().splitlines()]
    written = [json.dumps(line | {"input": name}) + "\n" for line, name in zip(lines, names, strict=True)]
    (tmp_path / "long/manifest.jsonl").write_text("".join(written))
    done = evaluate("--model", "good.onnx", "--by", "plate", data="long")
    told = "".join(line.split("│")[1].strip() for line in done.out.splitlines() if line.startswith("│"))
    assert all(name in told for name in names) and "…" not in done.out
    assert row(done.out, "all")[4] == "100.00 (100.0–100.0)"


def test_a_threshold_is_chosen_elsewhere(evaluate, tmp_path):
    done = evaluate("--model", "good.onnx", "--threshold-from", tmp_path / "chosen")
    # There F1 of slots is best at 0.7, and that of points at 0.8.
    assert "slots at confidence 0.7" in done.out and "points at confidence 0.8" in done.out
    done = evaluate("--model", "nothing.onnx", "--threshold-from", tmp_path / "chosen")
    assert done.code == 0 and "no slots found there are right" in done.err


def test_the_tolerance_is_told_in_pixels_of_600(evaluate):
    done = evaluate("--model", "good.onnx", "--tolerance", "1")
    assert row(done.out, "all")[4].split()[0] == "0.00"


def test_several_vote(evaluate):
    three = [word for name in ("good", "right", "nothing") for word in ("--model", f"{name}.onnx")]
    found = {}
    for vote in ("affirmative", "unanimous", "consensus"):
        done = evaluate(*three, "--vote", vote, "--threshold", "0.1")
        assert done.code == 0
        found[vote] = row(done.out, "all")[3]
    # GOOD has the slot and a wrong one in two images, RIGHT the slot in all three.
    assert found == {"affirmative": "5", "unanimous": "0", "consensus": "2"}


def test_what_is_written(evaluate, tmp_path):
    out = tmp_path / "out"
    words = ["--model", "good.onnx", "--by", "plate", "--cluster", "plate", "--out", out]
    assert evaluate(*words).code == 0
    told = json.loads((out / "results.json").read_text(), parse_constant=pytest.fail)
    assert told["models"] == [{"file": "good.onnx", "family": "said", "version": "g" * 64}]
    assert told["intervals"]["drawn_by"] == "plate" and told["tolerance"] == 10 and told["vote"] is None
    slots = told["slots"]
    assert (slots["hits"], slots["false_positives"], slots["misses"]) == (1, 1, 1)
    assert slots["intervals"]["recall"] == [0, 1]
    assert slots["by"]["plate"]["odd.png"]["precision"] is None
    assert slots["by"]["plate"]["odd.png"]["intervals"]["recall"] is None
    assert slots["curve"]["confidence"] == [0.7, 0.4]
    assert "| plate odd.png | 1 | 1 | 0 | – | 0.00 |" in (out / "results.md").read_text()
    drawn = (out / "curve.svg").read_text()
    assert "slots, AP 25.0 %" in drawn and "points, AP" in drawn
    sheet = cv2.imread(str(out / "worst.png"))
    assert sheet is not None and sheet.shape[1] > 240
    first = {path.name: path.read_bytes() for path in out.iterdir()}
    assert evaluate(*words).code == 0
    assert {path.name: path.read_bytes() for path in out.iterdir()} == first


def test_for_the_sheet_only_its_own_labels_are_read_once_more(evaluate, tmp_path, monkeypatch):
    opened = []
    read_json = reading.read_json
    monkeypatch.setattr(reading, "read_json", lambda path: opened.append(path.name) or read_json(path))
    monkeypatch.setattr(sys.modules["pavemark.cli.evaluate"], "WORST", 1)
    assert evaluate("--model", "good.onnx", "--out", tmp_path / "out").code == 0
    # Labels and scene of all, to know what is told; of all to judge them; and of the one drawn.
    assert len([name for name in opened if name.startswith("00000")]) == 2 * (3 + 3 + 1)


def test_names_with_line_breaks(evaluate, tmp_path):
    dataset(tmp_path / "broken", [(60, POINTS, [])], points_alone=True)
    path = tmp_path / "broken" / "labels.jsonl"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"place": "up\n\x1b[31mdown"}) + "\n")
    done = evaluate("--model", "good.onnx", "--by", "place", "--out", tmp_path / "out", data="broken")
    assert r"place up\n\x1b[31mdown" in done.out
    assert r"| place up\n\x1b[31mdown | 1 | 3 |" in (tmp_path / "out" / "results.md").read_text()


def test_no_mistakes_leave_no_sheet_of_a_run_before(evaluate, tmp_path):
    out = tmp_path / "out"
    assert evaluate("--model", "nothing.onnx", "--out", out, data="chosen").code == 0
    assert (out / "worst.png").exists()
    assert evaluate("--model", "right.onnx", "--out", out, data="chosen").code == 0
    assert not (out / "worst.png").exists()
    assert "AP 100.0 %" in (out / "curve.svg").read_text()


def test_nothing_found_and_nothing_there(evaluate, tmp_path):
    dataset(tmp_path / "empty", [(60, [], []), (70, [], [])])
    done = evaluate("--model", "nothing.onnx", "--out", tmp_path / "out", data="empty")
    assert done.code == 0
    assert row(done.out, "all")[4:] == ["–"] * 4
    assert "none are there" in (tmp_path / "out/curve.svg").read_text()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--model", "good.onnx", "--model", "right.onnx"], "--vote: is missing for 2 models"),
        (["--model", "good.onnx", "--vote", "unanimous"], "--vote: says nothing to one model"),
        (["--model", "good.onnx", "--threshold", "0.5", "--threshold-from", "{chosen}"], "are both given"),
        (["--model", "good.onnx", "--threshold-from", "{judged}"], "is what is judged"),
        (["--model", "good.onnx", "--threshold-from", "{alone}"], "has points alone"),
        (["--model", "good.onnx", "--threshold-from", "{part}"], "images/000001 is judged by: other images"),
        (["--model", "good.onnx", "--threshold-from", "{chosen}", "--out", "{chosen}"], "is the folder of the inputs"),
        (["--model", "good.onnx", "--cluster", ""], "--cluster: it is empty"),
        (["--model", "good.onnx", "--threshold-from", "{none}"], "none: is no folder"),
        (["--model", "good.onnx", "--threshold", "1.5"], "1.5 is not in the range"),
        (["--model", "good.onnx", "--threshold", "nan"], "--threshold': nan: a finite number is allowed"),
        (["--model", "good.onnx", "--tolerance", "0"], "--tolerance"),
        (["--model", "good.onnx", "--tolerance", "inf"], "--tolerance': inf: a finite number is allowed"),
        (["--model", "good.onnx", "--by", ","], "--by: ','"),
        (["--model", "good.onnx", "--by", "side,plate"], "tells no side of its images: domain, kind, plate is told"),
        (["--model", "good.onnx", "--cluster", "place"], "tells no place"),
        (["--model", "gone.onnx"], "gone.onnx: cannot be read"),
        (["--model", "good.onnx", "--out", "{judged}"], "is the folder of the inputs"),
        ([], "--model"),
    ],
)
def test_bad_input_is_told_in_one_line(evaluate, tmp_path, words, told):
    names = {name: tmp_path / name for name in ("judged", "chosen", "alone", "part", "none")}
    dataset(names["part"], [(60, POINTS, SLOTS), (70, POINTS, SLOTS)])
    (names["part"] / "images/000001.png").unlink()
    os.link(names["judged"] / "images/000001.png", names["part"] / "images/000001.png")
    done = evaluate(*(word.format(**names) for word in words))
    assert done.code == 2 and done.out == ""
    assert told in done.err and done.err.startswith("error: ") and len(done.err.splitlines()) == 1


def test_a_point_that_nobody_could_find_does_not_count_as_missed(evaluate, tmp_path):
    dataset(tmp_path / "beyond", [(60, POINTS, SLOTS), (70, [(500, 20)], [])])
    done = evaluate("--model", "good.onnx", data="beyond")
    assert done.code == 2 and done.out == "" and "000001.png: (500, 20): within the picture of 120×90" in done.err


@pytest.mark.parametrize("option", [(), ("--threshold-from", "judged")])
@pytest.mark.parametrize(
    ("harm", "said"),
    [
        ("gone", "000002.json: cannot be read"),
        ("outside", "within the picture of"),
        ("original", "painted anew"),
        ("twice", "000001: is in the set twice"),
    ],
)
def test_labels_of_no_use_are_told_before_any_picture_is_looked_at(evaluate, tmp_path, monkeypatch, option, harm, said):
    judged = tmp_path / "judged"
    labels, scene = judged / "labels/dmpr/000002.json", judged / "scenes/000002.json"
    if harm == "gone":
        labels.unlink()
    elif harm == "outside":
        labels.write_text('{"marks": [[5000, 5, 5001, 5, 1]], "slots": []}')
    elif harm == "original":
        told = json.loads(scene.read_text())
        scene.write_text(json.dumps(told | {"markings": [{"kind": "original"}]}))
    else:
        lines = (judged / "manifest.jsonl").read_text().splitlines()
        (judged / "manifest.jsonl").write_text("\n".join([*lines[:2], lines[1]]))
    monkeypatch.setattr(reading, "read_image", None)
    option = option and (option[0], tmp_path / option[1])
    done = evaluate("--model", "good.onnx", *option, data="chosen" if option else "judged")
    assert done.code == 2 and done.err.count("\n") == 1 and said in done.err


def test_no_such_dataset(evaluate):
    done = evaluate("--model", "good.onnx", data="none")
    assert done.code == 2 and "none: is no folder" in done.err


def test_a_detector_that_says_nonsense_stops_the_judge(evaluate, monkeypatch):
    bad = detection([(1, np.nan)], [0.5])
    monkeypatch.setitem(MODELS, "bad.onnx", Said({60: GOOD, 70: bad}, "b" * 64))
    done = evaluate("--model", "bad.onnx")
    assert done.code == 2 and "000001.png: said bbbbbbbbbbbb: points holds nan" in done.err


def test_detectors_that_are_onnx_files(tmp_path, capsys):
    """Graphs that say the same of every picture: one right, one with both points of the slot exchanged."""
    dataset(tmp_path / "judged", [(60, POINTS, SLOTS), (70, [], [])])
    points = np.array([[(u, v, 0.9) for u, v in POINTS]])
    pairs = np.zeros((1, 3, 3))
    pairs[0, 0, 1] = 1.0
    of = {"family": "gcn", "pixels_per_metre": "60"}
    right = graph(tmp_path / "right.onnx", points=points, pairs=pairs, said=of)
    turned = graph(tmp_path / "turned.onnx", points=points, pairs=pairs.transpose(0, 2, 1), said=of)
    run = run_in(tmp_path, capsys)
    for models, cells in (
        ((right,), ["2", "1", "2", "50.00", "100.00"]),
        ((turned,), ["2", "1", "2", "0.00", "0.00"]),
        ((right, turned), ["2", "1", "4", "25.00", "100.00"]),
    ):
        words = [word for model in models for word in ("--model", model)]
        done = run(*words, *(["--vote", "affirmative"] if len(models) > 1 else []))
        assert done.code == 0 and done.err == ""
        assert [cell.split()[0] for cell in row(done.out, "all")[1:6]] == cells
    nonsense = graph(tmp_path / "nan.onnx", times=np.nan, said=of | {"family": "dmpr"})
    done = run("--model", nonsense)
    assert done.code == 2 and "000000.png" in done.err and "nan.onnx" in done.err
    (tmp_path / "no.onnx").write_bytes(b"no graph")
    done = run("--model", tmp_path / "no.onnx")
    assert done.code == 2 and "no.onnx: is not an ONNX model" in done.err
