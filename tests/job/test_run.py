"""Whole jobs: the same bytes whatever the workers, shards and interruptions; no file half-written, no orphan."""

import json
import os
import re
import signal
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

from commandline import contents, gone, kill, pavemark, start, wait_until, workers_of

FOLDERS = ("images", "labels/dmpr", "labels/ps2", "labels/yolo", "masks", "slots", "scenes")


@pytest.fixture(scope="module")
def reference(inputs, tmp_path_factory):
    """The dataset as one worker makes it in one go."""
    out = tmp_path_factory.mktemp("reference") / "out"
    done = pavemark(*_arguments(inputs), "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    return out


def _arguments(inputs):
    told = ["render", "--images", inputs / "images", "--masks", inputs / "masks", "--count", "10", "--seed", "7"]
    return [*told, "--scale", "12", "--inpainter", "navier-stokes", "--segmenter", "strokes", "--workers", "1"]


def rows(out):
    """The manifest without what may differ: the timings."""
    read = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    return [{name: value for name, value in row.items() if name != "timings"} for row in read]


def assert_whole(out):
    """Every file under its name can be read to its end."""
    for path in Path(out).rglob("*"):
        if path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82"), path
        elif path.suffix == ".json" and not path.name.startswith("."):
            json.loads(path.read_text())


def test_every_file_is_there(reference):
    for folder in FOLDERS:
        assert [path.stem for path in sorted((reference / folder).iterdir())] == [f"{k:06d}" for k in range(10)]
    image = cv2.imread(str(reference / "images/000003.png"))
    mask = cv2.imread(str(reference / "masks/000003.png"), cv2.IMREAD_UNCHANGED)
    assert image.shape == (64, 96, 3)
    assert mask.shape == (64, 96) and set(np.unique(mask)) <= {0, 1}
    coco = json.loads((reference / "labels/coco.json").read_text())
    assert [each["id"] for each in coco["images"]] == list(range(10))


def test_manifest_tells_what_was_made(reference):
    told = [json.loads(line) for line in (reference / "manifest.jsonl").read_text().splitlines()]
    assert [row["index"] for row in told] == list(range(10))
    for row in told:
        assert row["timings"].keys() == {"plate", "scene", "render", "compose", "labels", "files"}
        assert row["versions"]["renderer"] == "flat 1"
        scene = json.loads((reference / f"scenes/{row['index']:06d}.json").read_text())
        assert scene["plate"]["sha256"] == row["plate"] and scene["plate"]["name"] + ".png" == row["input"]
        for name, digest in row["files"].items():
            found = subprocess.run(["sha256sum", reference / name], capture_output=True, text=True, check=True)
            assert found.stdout.split()[0] == digest


def test_every_input_is_used_once_before_any_is_used_again(reference):
    names = [row["input"] for row in rows(reference)]
    for epoch in range(3):
        assert sorted(names[3 * epoch : 3 * epoch + 3]) == ["a.png", "b.png", "c.png"]


def test_workers_do_not_matter(reference, arguments, tmp_path):
    done = pavemark(*arguments[:-1], "3", "--recycle", "3", "--out", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(tmp_path / "out") == contents(reference)
    assert rows(tmp_path / "out") == rows(reference)


def test_shards_at_the_same_time_make_the_same_dataset(reference, arguments, tmp_path):
    told = [("0/3", "1"), ("1/3", "2"), ("2/3", "1")]
    runs = [start(*arguments[:-1], workers, "--shard", shard, "--out", tmp_path / "out") for shard, workers in told]
    assert [(each.communicate()[1], each.returncode) for each in runs] == [("", 0)] * 3
    assert contents(tmp_path / "out") == contents(reference)
    assert rows(tmp_path / "out") == rows(reference)


def test_the_same_command_again_redoes_nothing(arguments, tmp_path):
    out = tmp_path / "out"
    assert pavemark(*arguments[:-4], "--workers", "1", "--count", "4", "--out", out).returncode == 0
    before = {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in out.rglob("*") if path.is_file()}
    again = pavemark(*arguments[:-4], "--workers", "1", "--count", "4", "--out", out)
    assert again.returncode == 0 and "0 of them made now" in again.stdout
    after = {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in out.rglob("*") if path.is_file()}
    assert after.pop(out / "journal/merging") and before.pop(out / "journal/merging")
    assert after == before


def test_a_larger_count_goes_on_and_a_lost_file_is_made_again(reference, arguments, tmp_path):
    out = tmp_path / "out"
    assert pavemark(*arguments, "--count", "4", "--out", out).returncode == 0
    kept = (out / "images/000001.png").stat().st_ino
    (out / "labels/ps2/000002.mat").unlink()
    done = pavemark(*arguments, "--out", out)
    assert done.returncode == 0 and "7 of them made now" in done.stdout
    assert (out / "images/000001.png").stat().st_ino == kept
    assert contents(out) == contents(reference)
    assert rows(out) == rows(reference)


def test_interrupted_it_stops_cleanly_and_goes_on(reference, arguments, tmp_path):
    out = tmp_path / "out"
    run = start(*arguments[:-1], "2", "--out", out)
    assert wait_until(lambda: len(list(out.glob("images/0*.png"))) >= 2)
    crew = workers_of(run.pid)
    os.killpg(run.pid, signal.SIGINT)  # as a terminal does
    told, wrong = run.communicate(timeout=30)
    assert (run.returncode, wrong) == (130, "")
    assert "the same command goes on" in told
    assert crew and all(map(gone, crew))
    assert not list(out.rglob("*.part"))
    there = len(list(out.glob("images/0*.png")))
    assert 2 <= there < 10 and len(rows(out)) == there
    assert pavemark(*arguments, "--out", out).returncode == 0
    assert contents(out) == contents(reference)
    assert rows(out) == rows(reference)


def test_killed_at_any_moment_it_leaves_whole_files_and_no_orphans(reference, arguments, tmp_path):
    out = tmp_path / "out"
    for made in (0, 5):
        run = start(*arguments[:-1], "2", "--out", out)
        assert wait_until(lambda made=made: len(list(out.glob("images/0*.png"))) > made)
        crew = workers_of(run.pid)
        kill(run.pid)
        run.communicate()
        assert wait_until(lambda crew=crew: all(map(gone, crew)))
        assert_whole(out)
    done = pavemark(*arguments, "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(out) == contents(reference)
    assert rows(out) == rows(reference)


def test_killed_workers_are_replaced(reference, arguments, tmp_path):
    out = tmp_path / "out"
    run = start(*arguments[:-1], "2", "--out", out)
    for made in (0, 4):
        assert wait_until(lambda made=made: len(list(out.glob("images/0*.png"))) > made or run.poll() is not None)
        for worker in workers_of(run.pid)[:1]:
            kill(worker)
    told, wrong = run.communicate(timeout=60)
    assert (run.returncode, wrong) == (0, ""), told
    assert contents(out) == contents(reference)


def test_what_a_killed_writer_left_is_swept_away(arguments, tmp_path):
    out = tmp_path / "out"
    dead = subprocess.Popen(["true"])
    dead.wait()
    (out / "images").mkdir(parents=True)
    host = os.uname().nodename.replace(".", "-")
    litter = out / "images" / f".000001.png.{host}.{dead.pid}.part"
    others = out / "images" / f".000001.png.elsewhere.{dead.pid}.part"
    litter.touch(), others.touch()
    assert pavemark(*arguments, "--count", "1", "--out", out).returncode == 0
    assert not litter.exists() and others.exists()


def test_an_image_whose_worker_dies_or_hangs_is_tried_once_more(reference, arguments, tmp_path):
    out = tmp_path / "out"
    trouble = f"die@3 once {tmp_path / 'died'};hang@8 once {tmp_path / 'hung'}"
    done = pavemark(*arguments, "--patience", "2", "--out", out, FLAT_RENDERER=trouble)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "died").exists() and (tmp_path / "hung").exists()
    assert contents(out) == contents(reference)


def test_images_that_cannot_be_made_are_a_line_each_and_the_others_are_made(arguments, tmp_path):
    out = tmp_path / "out"
    done = pavemark(*arguments, "--out", out, FLAT_RENDERER="die@3;fail@8")
    assert done.returncode == 1
    died, failed = done.stderr.splitlines()
    assert died == f"image 3 failed: its worker was killed by signal 9 ({out}/errors.log has more)"
    assert failed == f"image 8 failed: ArithmeticError: a fault of two lines ({out}/errors.log has more)"
    assert "Traceback" in (out / "errors.log").read_text()
    assert [row["index"] for row in rows(out)] == [0, 1, 2, 4, 5, 6, 7, 9]


def test_another_version_does_not_go_on(arguments, tmp_path):
    out = tmp_path / "out"
    assert pavemark(*arguments, "--count", "1", "--out", out).returncode == 0
    journal = out / "journal" / "0-of-1.jsonl"
    journal.write_text(journal.read_text().replace("flat 1", "flat 0"))
    again = pavemark(*arguments, "--out", out)
    assert again.returncode == 2
    told = "begun with renderer flat 0, this is flat 1: use that version, or another folder"
    assert again.stderr == f"error: {out}: {told}\n"


def test_two_runs_do_not_write_one_part(arguments, tmp_path):
    out = tmp_path / "out"
    first = start(*arguments, "--out", out, FLAT_RENDERER="hang@0")
    assert wait_until((out / "job.json").exists)
    second = pavemark(*arguments, "--out", out)
    crew = workers_of(first.pid)
    kill(first.pid)
    first.communicate()
    assert crew and wait_until(lambda: all(map(gone, crew))), "a stuck worker outlives its run"
    assert second.returncode == 2
    assert second.stderr == f"error: {out}: another run is writing to it\n"


@pytest.mark.skipif(os.geteuid() != 0, reason="a small disk is mounted by root only")
def test_a_full_disk_stops_it_with_one_line(reference, arguments, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "pavemark", disk], check=False)
    if mounted.returncode:
        pytest.skip("no disk can be mounted here")
    try:
        done = pavemark(*arguments, "--out", disk / "out")
        assert done.returncode == 2
        assert re.fullmatch(r"error: .*: cannot be written: No space left on device\n", done.stderr)
        assert list((disk / "out").glob("images/0*.png"))
        assert_whole(disk / "out")
        assert not list(disk.rglob("*.part"))
        subprocess.run(["mount", "-o", "remount,size=100m", disk], check=True)
        assert pavemark(*arguments, "--out", disk / "out").returncode == 0
        assert rows(disk / "out") == rows(reference)
    finally:
        subprocess.run(["umount", disk], check=True)
