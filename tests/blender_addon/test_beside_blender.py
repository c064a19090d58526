"""Processes beside Blender: progress, stop, death, a full disk, the end of Blender itself."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.records import from_json
from pavemark.scene import Scene

bpy = pytest.importorskip("bpy", reason="the bpy wheel is not installed")

from blender_addon import child, document, running, shot  # noqa: E402 - needs bpy

ROOT = Path(__file__).parents[2]
FLAT = [sys.executable, str(ROOT / "tests" / "flat_renderer.py"), "render"]


def wait(until, seconds=60):
    for _ in range(10 * seconds):
        running.watch()
        if until():
            return
        time.sleep(0.1)
    raise AssertionError("nothing comes of it")


def start(scene, out, monkeypatch, count=3, trouble=""):
    """Start a batch with a renderer that needs no Blender and can misbehave."""
    monkeypatch.setattr(child, "render_command", lambda: FLAT)
    monkeypatch.setenv("FLAT_RENDERER", trouble)
    settings = scene.pavemark
    settings.batch_folder, settings.batch_count, settings.workers = str(out), count, 1
    bpy.ops.pavemark.batch()
    return running.children[running.BATCH]


def alive(pid):
    """Whether a process is there, a zombie counting too."""
    return Path(f"/proc/{pid}").exists()


def family(pid):
    """A process and all below it."""
    found = [pid]
    for listed in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = listed.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found += family(int(listed.parent.name))
    return found


def test_a_batch_is_the_headless_job(clean, tmp_path):
    """With this very Blender, in a process of its own; the panel then opens one of its scenes and makes its image."""
    settings = clean.pavemark
    settings.draw = "preset"
    settings.batch_folder, settings.batch_count, settings.workers, settings.seed = str(tmp_path / "out"), 3, 1, 5
    bpy.ops.pavemark.batch()
    assert not bpy.ops.pavemark.batch.poll()
    wait(lambda: not running.children, 180)
    kind, line = running.outcomes[running.BATCH]
    assert (kind, line.split(" images")[0]) == ("INFO", "3 of 3")
    assert "\n" not in line
    scenes = sorted((tmp_path / "out" / "scenes").glob("*.json"))
    path = next(path for path in scenes if from_json(Scene, path).markings)
    bpy.ops.pavemark.open_scene(filepath=str(path))
    assert document.current(clean) == from_json(Scene, path)
    assert settings.folder == str(tmp_path / "out")
    bpy.ops.pavemark.render()
    image = bpy.data.images[shot.IMAGE]
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    here = np.rint(values.reshape(64, 96, 4)[::-1, :, 2::-1] * 255)
    assert np.array_equal(here, cv2.imread(str(tmp_path / "out" / "images" / f"{path.stem}.png")))
    # Saved back into the job's folder, the image counts as the job's own.
    before = (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()
    settings.brightness.use = True
    bpy.ops.pavemark.save_image()
    after = (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()
    assert len(after) == len(before) == 3
    assert sum(a != b for a, b in zip(before, after, strict=True)) == 1


def test_progress_is_told_and_a_stopped_batch_goes_on(clean, tmp_path, monkeypatch):
    started = start(clean, tmp_path / "out", monkeypatch, count=400)
    wait(lambda: started.done > 0)
    assert started.total == 400 and float(started.rate) > 0 and ":" in started.left
    pids = family(started._process.pid)
    bpy.ops.pavemark.stop(what=running.BATCH)
    wait(lambda: not running.children)
    kind, line = running.outcomes[running.BATCH]
    assert kind == "WARNING" and "goes on" in line
    assert not any(map(alive, pids))
    done = len(list((tmp_path / "out" / "images").glob("0*.png")))
    assert 0 < done < 400
    again = start(clean, tmp_path / "out", monkeypatch, count=done + 3)
    wait(lambda: not running.children)
    assert again.outcome()[0] == "INFO", again.outcome()


def test_a_killed_batch_is_told_and_leaves_no_zombie(clean, tmp_path, monkeypatch):
    started = start(clean, tmp_path / "out", monkeypatch, count=50, trouble="hang@3")
    wait((tmp_path / "out" / "images" / "000002.png").exists)
    pids = family(started._process.pid)
    os.kill(started._process.pid, signal.SIGKILL)
    wait(lambda: not running.children)
    assert running.outcomes[running.BATCH] == (
        "ERROR",
        "Batch: its process was killed by signal 9; what is finished stays",
    )
    wait(lambda: not any(map(alive, pids)), 30)
    assert (tmp_path / "out" / "images" / "000002.png").exists()


def test_a_batch_that_cannot_start_says_why(clean, tmp_path, monkeypatch):
    (tmp_path / "out").write_text("a file")
    start(clean, tmp_path / "out", monkeypatch)
    wait(lambda: not running.children)
    kind, line = running.outcomes[running.BATCH]
    assert kind == "ERROR" and line.startswith(str(tmp_path / "out")) and "folder is allowed" in line


def test_a_batch_ends_with_blender(tmp_path, inputs):
    """Blender is killed while a batch runs: nothing goes on, and what is finished stays."""
    script = tmp_path / "blender.py"
    script.write_text(
        f"""
import sys, time
sys.path[:0] = {[str(ROOT / "pipeline"), str(ROOT)]!r}
from blender_addon.child import Child
batch = Child("Batch")
batch.start({FLAT!r} + {["--images", str(inputs / "images"), "--out", str(tmp_path / "out"), "--count", "500"]!r}
    + {["--segmenter", "strokes", "--inpainter", "navier-stokes", "--workers", "1", "--leash", "--every", "0"]!r})
print(batch._process.pid, flush=True)
time.sleep(600)
"""
    )
    blender = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    # Blender has its own to say before.
    pid = next(int(line) for line in blender.stdout if line.strip().isdigit())
    wait(lambda: list((tmp_path / "out" / "images").glob("0*.png")))
    pids = family(pid)
    assert len(pids) > 1
    blender.kill()
    blender.wait()
    blender.stdout.close()
    wait(lambda: not any(map(alive, pids)), 30)
    assert not list((tmp_path / "out").rglob("*.part"))


def test_a_full_disk_is_told_and_nothing_is_lost(drawn, tmp_path, monkeypatch):
    before = drawn.pavemark.document
    drawn.pavemark.folder = str(tmp_path / "set")
    bpy.ops.pavemark.save_image()
    image = (tmp_path / "set/images/000000.png").read_bytes()

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    drawn.pavemark.brightness.use = True
    changed = drawn.pavemark.document
    monkeypatch.setattr(os, "fsync", full)
    for operator, told in (
        (bpy.ops.pavemark.save_image, "cannot be written: No space left on device"),
        (lambda: bpy.ops.pavemark.save_scene(filepath=str(tmp_path / "scene.json")), "scene.json: cannot be written"),
        (lambda: bpy.ops.pavemark.export_job(filepath=str(tmp_path / "job.toml")), "job.toml: cannot be written"),
    ):
        with pytest.raises(RuntimeError, match=told):
            operator()
    assert (tmp_path / "set/images/000000.png").read_bytes() == image
    assert not (tmp_path / "scene.json").exists() and not list(tmp_path.rglob("*.part"))
    assert drawn.pavemark.document == changed != before


def test_a_disk_that_fills_during_a_batch_is_told_in_a_line(clean, tmp_path, monkeypatch):
    out = tmp_path / "out"
    start(clean, out, monkeypatch, trouble="full@1")
    wait(lambda: not running.children)
    kind, line = running.outcomes[running.BATCH]
    assert (kind, line) == ("ERROR", f"{out / 'images' / '000001.png'}: cannot be written: No space left on device")
    assert (out / "images" / "000000.png").exists() and not list(out.rglob("*.part"))
    start(clean, out, monkeypatch)
    wait(lambda: not running.children)
    kind, line = running.outcomes[running.BATCH]
    assert (kind, line) == ("INFO", f"3 of 3 images in {out}, 2 of them made now")


def test_a_batch_that_finds_no_room_for_its_job_is_told_in_a_line(clean, tmp_path, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RuntimeError) as refused:
        start(clean, tmp_path / "out", monkeypatch)
    (line,) = str(refused.value).strip().splitlines()
    assert line.endswith("pavemark-job.toml: cannot be written: No space left on device")
    assert not running.children and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("12/200  3.1 images/s  0:01:00 left", (12, 200, "3.1", "0:01:00")),
        ("2/9  0.4 plates/s  0:00:18 left  1 lacking", (2, 9, "0.4", "0:00:18")),
        ("Fra:1 Mem:33.47M | Sample 0/1", (0, 0, "", "")),
    ],
)
def test_progress_is_read_from_lines(line, said):
    told = child.Child("Batch")
    told._take(line)
    assert (told.done, told.total, told.rate, told.left) == said
