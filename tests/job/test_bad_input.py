"""Bad input through the command line: one line on stderr that names file, field, value and what is allowed."""

import importlib
import json
import os
import re
import shutil
import stat
import struct
import zlib

import cv2
import numpy as np
import pytest

from commandline import PROGRAM, pavemark
from pavemark import cli
from pavemark.errors import InputError
from pavemark.job.explain import explain
from pavemark.job.worker import started


def refused(capfd, *words):
    """The one line that a command is refused with, in this process."""
    with pytest.raises(SystemExit) as left:
        cli.main([str(word) for word in words], [*PROGRAM, "--worker"])
    said = capfd.readouterr()
    assert left.value.code == 2
    assert said.err.startswith("error: ") and said.err.count("\n") == 1 and said.err.endswith("\n"), said.err
    assert "Traceback" not in said.out
    return said.err[len("error: ") : -1]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("colr = 1", r"unknown field colr \(did you mean colour\?"),
        ("[noise]\nrat = 0.1", r"noise: unknown field rat \(did you mean rate\?"),
        ("[noise]\nrate = 2.0", r"noise: rate = 2.0: allowed 0 to 1"),
        ("[noise]\nrate = nan", r"noise.rate: nan is not a finite number"),
        ("[noise]\nrate = 'often'", r"noise.rate: 'often' is not a number"),
        ("[brightness]\nfactor = [1.5, 0.5]", r"brightness: factor = \[1.5, 0.5\]: allowed are two ascending"),
        ("scale = nan", r"scale: nan is not a finite number"),
        ("scale = inf", r"scale: inf is not a finite number"),
        ("scale = 0", r"scale = 0.0: allowed 1 to 10000"),
        ("scale = 60\nmetres_per_pixel = 0.02", r"scale and metres_per_pixel are both given"),
        ("count = 0", r"count = 0: allowed 1 to"),
        ("count = 1.5", r"count: 1.5 is not a whole number"),
        ("seed = -1", r"seed = -1: allowed 0 to"),
        ("inpainter = 'magic'", r"inpainter = 'magic': allowed patchmatch"),
        ("preset = 'papre'", r"preset = 'papre': allowed default, paper"),
        ("preset = 3", r"preset = 3: allowed default, paper"),
        ("formats = ['dmpr', 'voc']", r"formats = 'voc': allowed dmpr, ps2, coco, yolo"),
        ("formats = ['dmpr', 'dmpr']", r"formats = .*: each format once is allowed"),
        ("images = 3", r"images: 3 is not a str"),
        ("noise = 3", r"noise: 3 is not a table of fields"),
        ("stops = { shade = [0.1] }", r"stops.shade: not enough values in \[0.1\]: 2 are allowed"),
        ("shape = { line = [0.1, 0.2, 0.3] }", r"shape.line: too many values in \[0.1, 0.2, 0.3\]: 2 are allowed"),
        ("formats = 'dmpr'", r"formats: 'dmpr' is not a list"),
        ("mask = 'masks'", r"mask: 'masks' is not a table of fields"),
        ("count = inf", r"count: inf is not a finite number"),
        (f"seed = {'9' * 5000}", r"not a TOML file: "),
        ("[mask]\nmarking = [300]", r"mask: marking = 300: allowed 0 to 255"),
        ("what is this", r"not a TOML file: "),
        ("\0", r"not a TOML file: "),
    ],
)
def test_job_file(inputs, tmp_path, capfd, line, told):
    job = tmp_path / "job.toml"
    images = "" if line.startswith("images") else f"images = '{inputs / 'images'}'\n"
    job.write_text(images + line)
    said = refused(capfd, "render", job, "--out", tmp_path / "out")
    assert re.match(re.escape(str(job)) + ": " + told, said), said
    assert not (tmp_path / "out").exists()


SHARD = "allowed is K/N with K from 0 to N - 1, such as 3/16"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--scale", "nan"], "command line: scale: nan is not a finite number"),
        (["--count", "-3"], "command line: count = -3: allowed 1 to 1e+09"),
        (["--count", "many"], "Invalid value for '--count': 'many' is not a valid integer."),
        (["--cuont", "3"], "no such option: --cuont (did you mean --count?)"),
        (["--preset", "papr"], "command line: preset = 'papr': allowed default, paper"),
        (
            ["--shard", "16/16"],
            "Invalid value for '--shard': '16/16': allowed is K/N with K from 0 to N - 1, such as 3/16",
        ),
        (["--shard", "x"], "Invalid value for '--shard': 'x': allowed is K/N with K from 0 to N - 1, such as 3/16"),
        (["--workers", "0"], "Invalid value for '--workers': 0 is not in the range 1<=x<=1024."),
        (
            ["--set", f"seed = {'9' * 5000}"],
            f"--set: 'seed = {'9' * 5000}': allowed is a line of a job file, like 'noise.rate = 0.2' (Exceeds the limit"
            " (4300 digits) for integer string conversion: value has 5000 digits; use sys.set_int_max_str_digits() to"
            " increase the limit)",
        ),
        (["--set", "noise.rate = 7"], "command line: noise: rate = 7.0: allowed 0 to 1"),
    ],
)
def test_options(inputs, tmp_path, capfd, words, told):
    said = refused(capfd, "render", "--images", inputs / "images", "--out", tmp_path / "out", *words)
    assert said == told
    assert not (tmp_path / "out").exists()


def test_text_files_with_a_byte_order_mark_and_windows_line_ends(tmp_path, capfd):
    job = tmp_path / "job.toml"
    job.write_bytes(b"\xef\xbb\xbfimages = 'none'\r\nseed = 3\r\n")
    assert "none: cannot be listed" in refused(capfd, "render", job, "--out", tmp_path / "out")
    scene = tmp_path / "scene.json"
    scene.write_bytes(b"\xef\xbb\xbf" + json.dumps(SCENE).encode())
    assert explain(scene)


def test_without_a_command_it_shows_the_help(capfd):
    with pytest.raises(SystemExit) as left:
        cli.main([], [])
    said = capfd.readouterr()
    assert left.value.code == 0
    assert said.err == "" and "\n  render " in said.out


def test_commands_and_missing_words(inputs, tmp_path, capfd):
    assert refused(capfd, "rendr").startswith("No such command 'rendr'.")
    assert refused(capfd, "render", "--images", tmp_path) == "Missing option '--out'."
    assert "images is missing" in refused(capfd, "render", "--out", tmp_path / "out")
    job = tmp_path / "none.toml"
    assert (
        refused(capfd, "render", job, "--out", tmp_path / "out") == f"{job}: cannot be read: No such file or directory"
    )


def test_folders(inputs, tmp_path, capfd):
    out = ("--out", tmp_path / "out")
    assert "No such file" in refused(capfd, "render", "--images", tmp_path / "none", *out)
    (tmp_path / "empty").mkdir()
    assert "holds no image" in refused(capfd, "render", "--images", tmp_path / "empty", *out)
    said = refused(capfd, "render", "--images", inputs / "images", "--masks", tmp_path / "empty", *out)
    assert "holds no PNG mask" in said
    assert not (tmp_path / "out").exists()


def test_output(inputs, tmp_path, capfd):
    job = ("render", "--images", inputs / "images", "--out")
    (tmp_path / "file").touch()
    assert refused(capfd, *job, tmp_path / "file") == f"{tmp_path / 'file'}: is a file: a folder is allowed"
    assert "cannot be written" in refused(capfd, *job, tmp_path / "file" / "below")
    assert "cannot be written" in refused(capfd, *job, "/proc/here")


def test_inputs_and_strangers_are_not_written_over(inputs, tmp_path, capfd):
    home = tmp_path / "home"
    (home / "images").mkdir(parents=True)
    shutil.copy(inputs / "images" / "a.png", home / "images" / "000000.png")
    before = (home / "images" / "000000.png").read_bytes()
    job = ("render", "--images", home / "images", "--count", "1", "--workers", "1", "--scale", "12", "--out")
    assert f"{home}/images: is the folder of the inputs" in refused(capfd, *job, home)
    other = ("render", "--images", inputs / "images", "--out", home)
    assert f"{home}: has files in images and no job.json" in refused(capfd, *other)
    assert "is the folder of the inputs" in refused(capfd, *job, home / "images")
    assert [path.name for path in home.rglob("*")] == ["images", "000000.png"]
    assert (home / "images" / "000000.png").read_bytes() == before


def test_a_dataset_without_its_record_is_not_taken_for_another(arguments, tmp_path, capfd):
    out = tmp_path / "out"
    assert pavemark(*arguments, "--count", "1", "--out", out).returncode == 0
    (out / "job.json").unlink()
    said = refused(capfd, *arguments, "--count", "1", "--seed", "8", "--out", out)
    assert "and no job.json that tells of them: use another folder" in said


def test_an_input_that_changed_is_not_mixed_with_what_it_was(inputs, arguments, tmp_path, capfd):
    images = tmp_path / "images"
    shutil.copytree(inputs / "images", images)
    job = (*arguments, "--images", images, "--out", tmp_path / "out", "--count")
    assert pavemark(*job, "3").returncode == 0
    shutil.copy(images / "b.png", images / "a.png")
    said = refused(capfd, *job, "6")
    assert said.startswith(f"{images / 'a.png'}: it or its mask has changed since images were made of it")
    shutil.copy(inputs / "images" / "a.png", images / "a.png")
    assert pavemark(*job, "6").returncode == 0
    rows = [json.loads(line) for line in (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()]
    assert len(rows) == 6 and len({row["plate"] for row in rows}) == 3


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_output_without_permission(inputs, tmp_path, capfd):
    (tmp_path / "locked").mkdir(mode=stat.S_IRUSR | stat.S_IXUSR)
    said = refused(capfd, "render", "--images", inputs / "images", "--out", tmp_path / "locked" / "out")
    assert "cannot be written: Permission denied" in said


def test_another_job_in_the_same_folder(arguments, tmp_path, capfd):
    out = tmp_path / "out"
    assert pavemark(*arguments, "--count", "1", "--out", out).returncode == 0
    said = refused(capfd, *arguments, "--out", out, "--seed", "8", "--set", "noise.rate = 0.125")
    assert said.startswith(f"{out}: holds another job: noise.rate was ") and "seed was 7 and is 8" in said
    assert "formats was" in refused(capfd, *arguments, "--out", out, "--set", "formats = ['ps2']")
    said = refused(capfd, *arguments, "--out", out, "--count", "2000000")
    assert said == f"{out}: count = 2000000: at most 1000000 is allowed there"
    (out / "job.json").write_text("{")
    assert "not a JSON file" in refused(capfd, *arguments, "--out", out)


def _png(width, height):
    """The start of a PNG of a size, without pixels."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))


@pytest.fixture
def batch(inputs, tmp_path):
    """A folder of one good image and one of each bad kind, with masks."""
    images, masks = tmp_path / "images", tmp_path / "masks"
    shutil.copytree(inputs / "images", images)
    shutil.copytree(inputs / "masks", masks)
    good = cv2.imread(str(images / "a.png"))
    bad = {
        "text.png": b"not an image",
        "empty.jpg": b"",
        "cut.png": (images / "a.png").read_bytes()[:3000],
        "deep.png": cv2.imencode(".png", good.astype(np.uint16) * 257)[1].tobytes(),
        "grey.png": cv2.imencode(".png", good[..., 0])[1].tobytes(),
        "alpha.png": cv2.imencode(".png", np.dstack([good, good[..., :1]]))[1].tobytes(),
        "tiny.png": cv2.imencode(".png", good[:1, :1])[1].tobytes(),
        "huge.png": _png(20000, 20000),
        "unfit.png": (images / "a.png").read_bytes(),
        "colourful.png": (images / "a.png").read_bytes(),
    }
    for name, data in bad.items():
        (images / name).write_bytes(data)
        shutil.copy(masks / "a.png", masks / name.replace(".jpg", ".png"))
    cv2.imwrite(str(masks / "unfit.png"), np.zeros((10, 10), np.uint8))
    cv2.imwrite(str(masks / "colourful.png"), good)
    (images / "lonely.png").write_bytes((images / "a.png").read_bytes())
    return images, masks, bad


def test_bad_images_of_a_batch_are_left_out_and_the_rest_is_done(batch, tmp_path):
    images, masks, bad = batch
    job = (
        "render",
        "--images",
        images,
        "--masks",
        masks,
        "--scale",
        "12",
        "--inpainter",
        "navier-stokes",
        "--segmenter",
        "strokes",
    )
    done = pavemark(*job, "--count", "26", "--workers", "2", "--out", tmp_path / "out")
    assert done.returncode == 1
    told = done.stderr.splitlines()
    assert told[0] == f"left out: {images / 'lonely.png'}: no mask has its name"
    assert len(told) == 1 + len(bad)
    for name in bad:
        lines = [line for line in told if f"/{name}: " in line]
        assert len(lines) == 1 and lines[0].startswith("left out: "), (name, told)
    rows = [json.loads(line) for line in (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()]
    assert sorted(row["input"] for row in rows) == ["a.png", "a.png", "b.png", "b.png", "c.png", "c.png"]
    assert "6 of 26 images" in done.stdout and "20 left out for 10 of 13 input images" in done.stdout


def test_a_name_cannot_speak_to_the_terminal(inputs, tmp_path):
    (tmp_path / "images").mkdir()
    shutil.copy(inputs / "images" / "a.png", tmp_path / "images")
    shutil.copy(inputs / "images" / "a.png", tmp_path / "images" / "two\n\x1b[31mlines.png")
    job = (
        "--images",
        tmp_path / "images",
        "--scale",
        "12",
        "--inpainter",
        "navier-stokes",
        "--segmenter",
        "strokes",
        "--count",
        "2",
    )
    done = pavemark("render", *job, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert done.stderr.startswith(f"left out: {tmp_path}/images/two\\n\\x1b[31mlines.png: name = ")
    assert done.stderr.count("\n") == 1 and "\x1b" not in done.stderr


def test_no_usable_image_at_all(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "a.png").write_bytes(b"no")
    done = pavemark("render", "--images", tmp_path / "one", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert re.fullmatch(rf"error: {tmp_path}/one/a.png: .*\n", done.stderr)
    (tmp_path / "one" / "b.png").write_bytes(b"no")
    done = pavemark("render", "--images", tmp_path / "one", "--out", tmp_path / "out2")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == f"error: {tmp_path}/one: none of its 2 images can be used"


SCENE = {"index": 1, "plate": {"name": "a", "sha256": "0" * 64}}


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        (SCENE | {"plate": {"name": "../../etc/passwd", "sha256": "0" * 64}}, "a plain name without path, colon"),
        (SCENE | {"plate": {"name": "/etc/passwd", "sha256": "0" * 64}}, "a plain name without path, colon"),
        (SCENE | {"plate": {"name": "C:x", "sha256": "0" * 64}}, "a plain name without path, colon"),
        (SCENE | {"plate": {"name": "a", "sha256": "../x"}}, "64 hexadecimal digits are allowed"),
        (SCENE | {"colour": 1}, "unknown field colour"),
        (SCENE | {"brightness": {"factor": -1}}, "factor = -1.0: allowed 0 to 10"),
        ('{"index": 1, "brightness": {"factor": NaN}}', "NaN is not a finite number"),
        ("[" * 100_000, "not a JSON file"),
        ("\0\xff", "not a JSON file"),
        ("3", "3 is not a table of fields"),
        (SCENE | {"markings": "ab"}, "markings[0]: 'a' is not a table of fields"),
        (SCENE | {"index": float("inf")}, "Infinity is not a finite number"),
        ('{"index": 1e999}', "index: inf is not a finite number"),
    ],
)
def test_scene_file(tmp_path, capfd, scene, told):
    path = tmp_path / "scene.json"
    path.write_bytes(scene.encode("latin-1") if isinstance(scene, str) else json.dumps(scene).encode())
    said = refused(capfd, "explain", path)
    assert said.startswith(f"{path}: ") and told in said


def test_explain_and_preview_without_their_files(tmp_path, capfd):
    none = tmp_path / "none.json"
    assert refused(capfd, "explain", none) == f"{none}: cannot be read: No such file or directory"
    assert "directory" in refused(capfd, "explain", tmp_path)
    assert "cannot be read: No such file" in refused(capfd, "preview", tmp_path / "none")


def test_without_a_renderer_it_says_so(inputs, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(cli, "WORKER", ("false",))
    with pytest.raises(SystemExit):
        cli.main(["render", "--images", str(inputs / "images"), "--out", str(tmp_path / "out")], ["false"])
    assert capfd.readouterr().err == "error: false: no worker starts: ended with exit code 1\n"


def test_a_renderer_that_lacks_its_libraries_is_told_in_a_line():
    with pytest.raises(InputError, match=r"^Blender: ModuleNotFoundError: No module named 'no_bpy': pip install 'pave"):
        started(lambda: importlib.import_module("no_bpy"))
