import csv
import signal
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from commandline import gone, start, wait_until, workers_of
from pavemark.accuracy.report import Report
from pavemark.cli import main
from pavemark.cli.accuracy import _all
from pavemark.errors import InputError


@pytest.fixture
def accuracy(folders, monkeypatch, capsys):
    """Runs the command in this process."""
    monkeypatch.setenv("PAVEMARK_MODELS", str(folders / "none"))

    def run(*words):
        command = ["accuracy", "--images", folders / "images", "--masks", folders / "masks", "--out", folders / "out"]
        command += ["--set", "mask.ground = [0]", "--scale", "30"]
        command += [*([] if "--stage" in words else ["--stage", "inpaint"]), *words]
        with pytest.raises(SystemExit) as left:
            main([str(word) for word in command])
        told = capsys.readouterr()
        return SimpleNamespace(code=left.value.code, out=told.out, err=told.err)

    return run


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_report_of_fills_and_times(folders, accuracy):
    done = accuracy("--methods", "navier-stokes", "--quick")
    found = rows(folders / "out/inpaint.csv")
    assert [(row["image"], row["mask_of"]) for row in found] == [("a", "a"), ("b", "b"), ("bare", "a")]
    # A smooth slope of light is what both carry on.
    assert min(float(row["psnr"]) for row in found) > 30
    assert all(float(row["seconds"]) > 0 and 20 < float(row["peak_mb"]) < 1000 for row in found)
    times = [row for row in rows(folders / "out/speed.csv") if row["segmenter"] == "strokes"]
    assert [(row["width"], row["height"]) for row in times] == [("600", "600"), ("96", "300")]
    for row in times:
        both = float(row["segment_seconds"]) + float(row["fill_seconds"])
        assert float(row["plates_per_minute"]) == pytest.approx(60 / both, rel=1e-3)
    sheet = cv2.imread(str(folders / "out/inpaint.png"))
    assert sheet.shape == (18 + 3 * (80 + 18), 3 * 104, 3)
    told = (folders / "out/inpaint.md").read_text()
    assert "| navier-stokes | 3 |" in told
    assert "1 thread a method" in told
    assert told.strip() in done.out


def test_a_report_of_residue_beside_what_others_have_cleaned(folders, accuracy):
    others = folders / "others"
    others.mkdir()
    image = cv2.imread(str(folders / "images/a.png"))
    half = image.astype(float)
    half[10:60, 40:44] = (half[10:60, 40:44] + half[10:60, 50:54]) / 2
    cv2.imwrite(str(others / "a.png"), half.astype(np.uint8))
    done = accuracy("--stage", "residue", "--methods", "navier-stokes", "--cleaned", f"half={others}")
    left = {(row["image"], row["method"]): float(row["left"]) for row in rows(folders / "out/residue.csv")}
    assert left.keys() == {("a", "before"), ("a", "half"), ("a", "navier-stokes")} | {
        ("b", "before"),
        ("b", "navier-stokes"),
    }
    assert left["a", "half"] == pytest.approx(left["a", "before"] / 2, rel=0.15)
    assert abs(left["a", "navier-stokes"]) < 1
    profile = [row for row in rows(folders / "out/profile.csv") if row["method"] == "before" and row["image"] == "a"]
    assert float(profile[0]["contrast"]) > 20 > abs(float(profile[-1]["contrast"]))
    # The bare image has nothing to look for, which is said.
    assert done.code == 1
    assert "bare: no paint stands out" in done.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--methods", "lama"], "inpainter = 'lama': allowed patchmatch"),
        (["--methods", ","], "--methods: it is empty: allowed patchmatch"),
        (
            ["--stage", "taste"],
            "'taste' is not one of 'render', 'effects', 'blend', 'geometry', 'labels', 'inpaint', 'residue', 'all'",
        ),
        (["--stage", "residue", "--cleaned", "here"], "'here': allowed is NAME=DIR"),
        (["--stage", "residue", "--cleaned", "x=/nowhere"], "/nowhere: cannot be listed"),
        (["--scale", "0"], "scale = 0.0: allowed 1 to 10000"),
    ],
)
def test_bad_words_are_refused_in_one_line(folders, accuracy, words, told):
    done = accuracy(*words)
    assert done.code == 2
    (line,) = done.err.splitlines()
    assert told in line
    assert not (folders / "out").exists()


def test_a_report_that_could_not_be_written_is_not_begun(folders, accuracy):
    (folders / "out").write_text("a letter")
    done = accuracy("--methods", "navier-stokes")
    assert (done.code, done.out) == (2, "")
    assert "is a file: a folder is allowed" in done.err
    assert (folders / "out").read_text() == "a letter"


@pytest.fixture
def alone(tmp_path, capsys):
    """Runs the command in this process, without images."""

    def run(*words):
        with pytest.raises(SystemExit) as left:
            main(["accuracy", "--quiet", "--quick", *map(str, words)])
        told = capsys.readouterr()
        return SimpleNamespace(code=left.value.code, out=told.out, err=told.err)

    return run


def test_a_report_of_a_stage_that_needs_no_images(tmp_path, alone, monkeypatch):
    monkeypatch.setattr("pavemark.accuracy.geometry.QUICK_ROUNDS", 1)
    monkeypatch.setattr("pavemark.accuracy.geometry.LEAST", 0.0)
    done = alone("--stage", "geometry", "--out", tmp_path / "out")
    assert (done.code, done.err) == (0, "")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "geometry.svg",
        "geometry.csv",
        "geometry.md",
        "report.html",
    }
    shown = (tmp_path / "out/report.html").read_text()
    assert "<svg" in shown and "normalised DLT" in shown
    assert len(rows(tmp_path / "out/geometry.csv")) > 40


def test_all_does_what_it_can_and_says_what_it_cannot(tmp_path, alone, monkeypatch):
    def judge(name):
        return lambda *given: Report({f"{name}.md": name}, name)

    def none(*given):
        raise InputError("render", "Blender: No module named 'bpy'")

    monkeypatch.setattr("pavemark.accuracy.render.report", none)
    monkeypatch.setattr("pavemark.accuracy.blend.report", judge("blend"))
    monkeypatch.setattr("pavemark.accuracy.effects.report", judge("effects"))
    monkeypatch.setattr("pavemark.accuracy.geometry.report", judge("geometry"))
    monkeypatch.setattr("pavemark.accuracy.labels.report", judge("labels"))
    monkeypatch.setattr("pavemark.accuracy.calibrate.report", none)  # asked for by name only
    done = alone("--out", tmp_path / "out")
    assert done.code == 1
    assert done.err.splitlines() == ["render: not run: render: Blender: No module named 'bpy'"]
    made = ["blend.md", "effects.md", "geometry.md", "labels.md", "report.html"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == made
    shown = (tmp_path / "out/report.html").read_text()
    for line in ("render: not run", "inpaint: not run: --images is missing", "residue: not run: --images is missing"):
        assert line in shown


def test_calibration_is_a_report_of_its_own(tmp_path, alone, monkeypatch):
    def report(make, quick, watcher):
        return Report({"rays.json": "{}", "calibration.md": "what rays promise"}, "what rays promise")

    monkeypatch.setattr("pavemark.accuracy.calibrate.report", report)
    done = alone("--calibrate", "--out", tmp_path / "out")
    assert (done.code, done.err) == (0, "")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"rays.json", "calibration.md", "report.html"}
    assert "what rays promise" in (tmp_path / "out/report.html").read_text()


@pytest.mark.parametrize("stage", ["inpaint", "residue"])
def test_images_are_asked_for_where_they_are_needed(tmp_path, alone, stage):
    done = alone("--stage", stage, "--out", tmp_path / "out")
    assert (done.code, done.err.strip()) == (
        2,
        f"error: --stage {stage}: --images is missing: a folder of AVM images is needed",
    )
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_measured(alone):
    done = alone("--stage", "blend", "--out", "/proc/here/out")
    (line,) = done.err.splitlines()
    assert (done.code, done.out) == (2, "")
    assert line.startswith("error: /proc/here/out: cannot be written: /proc: ")


def test_interrupted_it_leaves_nothing_behind(tmp_path):
    running = start("accuracy", "--stage", "geometry", "--out", str(tmp_path / "out"))
    assert wait_until(lambda: workers_of(running.pid, "spawn_main"))
    workers = workers_of(running.pid)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert (running.returncode, out, err.strip()) == (130, "", "")
    assert wait_until(lambda: all(map(gone, workers)))
    assert list(tmp_path.iterdir()) == []


def test_a_report_does_not_go_where_its_images_are(folders, accuracy):
    before = sorted(folders.rglob("*"))
    for folder in (folders / "images", folders / "masks"):
        done = accuracy("--methods", "navier-stokes", "--out", folder)
        assert (done.code, done.out) == (2, "") and "is the folder of the inputs" in done.err
    assert sorted(folders.rglob("*")) == before


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--stage", "blend", "--images", "there"), "--images: says nothing to --stage blend: "),
        (("--stage", "geometry", "--methods", "fsr"), "--methods: says nothing to --stage geometry: "),
        (("--stage", "labels", "--images", "there"), "--images: says nothing to --stage labels: "),
        (
            ("--calibrate", "--stage", "render"),
            "--calibrate: says nothing to --stage render: it is a report of its own",
        ),
        (("--calibrate", "--images", "there"), "--images: says nothing to --calibrate: "),
        (("--calibrate", "--cleaned", "x=there"), "--cleaned: says nothing to --calibrate: "),
        (("--masks", "there"), "--masks: --images is missing"),
        (("--cleaned", "x=there"), "--cleaned: --images is missing"),
        (("--stage", "residue", "--methods", "fsr"), "--methods: --images is missing"),
    ],
)
def test_options_that_would_say_nothing_are_refused(tmp_path, capsys, words, told):
    with pytest.raises(SystemExit) as left:
        main(["accuracy", "--out", str(tmp_path / "out"), *words])
    assert left.value.code == 2 and capsys.readouterr().err.startswith(f"error: {told}")
    assert not (tmp_path / "out").exists()


def test_what_others_have_cleaned_is_not_left_out_in_silence(folders, accuracy):
    empty = folders / "empty"
    empty.mkdir()
    cv2.imwrite(str(empty / "stranger.png"), np.zeros((9, 9, 3), np.uint8))
    stages = ("--stage", "residue", "--methods", "navier-stokes")
    for words, told in (
        (("--cleaned", f"x={empty}"), "--cleaned: says nothing to --stage inpaint"),
        ((*stages, "--cleaned", f"x={empty}", "--cleaned", f"x={folders}"), "--cleaned: x is given twice"),
        ((*stages, "--cleaned", f"before={empty}"), "--cleaned: before is what a row of our own is called"),
        ((*stages, "--cleaned", f"patchmatch={empty}"), "--cleaned: patchmatch is what a row of our own is called"),
        ((*stages, "--cleaned", f"x={empty}"), f"{empty}: has no image that is called as one of those judged (x)"),
        ((*stages, "--cleaned", f"x={folders / 'nowhere'}"), f"{folders / 'nowhere'}: "),
    ):
        done = accuracy(*words)
        assert done.code == 2 and done.err.startswith(f"error: {told}"), done.err
        assert not (folders / "out").exists()


def test_one_bad_image_leaves_a_report_of_the_others_and_exit_code_1(folders, accuracy):
    (folders / "images/a.png").write_bytes((folders / "images/a.png").read_bytes()[:200])
    done = accuracy("--methods", "navier-stokes", "--quiet", "--quick")
    assert done.code == 1
    assert "a.png: image is truncated or damaged" in done.err
    assert {row["image"] for row in rows(folders / "out/inpaint.csv")} == {"b", "bare"}
    assert done.out == ""


def test_what_is_judged_is_kept_before_the_next_stage_begins():
    """A fault, or Ctrl-C, in a later stage takes nothing of it."""
    kept = []

    def fails():
        raise ArithmeticError

    with pytest.raises(ArithmeticError):
        _all({"first": lambda: "report", "second": fails}, None, lambda made, left_out: kept.append(dict(made)))
    assert kept == [{"first": "report"}]
