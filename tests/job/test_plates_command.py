"""Folders of plates: exact files whatever the workers and interruptions, mended by hand, and drawn on as they are."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from commandline import PROGRAM, contents, gone, kill, pavemark, start, wait_until, workers_of
from pavemark import cli
from pavemark.background.stock import stock as stock_of
from pavemark.compose.optics import measure
from pavemark.job import journal
from pavemark.job.config import Inputs
from pavemark.job.plates import make
from pavemark.job.preview import preview
from pavemark.job.progress import Quiet
from pavemark.job.run import Machine

SCALE, GAP, HEAD = 4, 6, 38
"""Of sheets of so small images."""

OPTIONS = ("--scale", "12", "--inpainter", "navier-stokes", "--segmenter", "strokes")


@pytest.fixture
def said(capfd):
    """Runs a command in this process: its exit code, and what it said."""

    def run(*words):
        with pytest.raises(SystemExit) as left:
            cli.main([str(word) for word in words], [*PROGRAM, "--worker"])
        told = capfd.readouterr()
        assert "Traceback" not in told.out + told.err
        return left.value.code, told.out, told.err

    return run


def command(inputs, out, *more):
    """The command that makes plates of a folder `images` with `masks` beside it."""
    return ("plates", inputs / "images", "--masks", inputs / "masks", *OPTIONS, "--workers", "1", "--out", out, *more)


def many(folder, count=12):
    """A folder of images like those of `inputs`."""
    rng = np.random.default_rng(3)
    mask = np.zeros((64, 96), np.uint8)
    mask[:, 40:42] = 1
    (folder / "images").mkdir(parents=True)
    (folder / "masks").mkdir()
    for number in range(count):
        image = rng.normal(60 + 9 * number, 5, (64, 96, 3)) + 60 * mask[..., None]
        cv2.imwrite(str(folder / "images" / f"{number:02d}.png"), image.clip(0, 255).astype(np.uint8))
        cv2.imwrite(str(folder / "masks" / f"{number:02d}.png"), mask)
    return folder


def read(path):
    """A file's values as they are stored, colours in the order blue, green, red."""
    pixels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert pixels is not None and pixels.dtype == np.uint8
    return pixels


def rows(out):
    told = [json.loads(line) for line in (out / "plates.jsonl").read_text().splitlines()]
    assert [row["name"] for row in told] == sorted(row["name"] for row in told)
    return {row["name"]: row for row in told}


def files(out):
    """Which file each is, and when it was written."""
    pictures = [path for kind in ("plates", "masks", "ground") for path in (out / kind).iterdir()]
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in pictures}


def linear(level):
    """Linear light of an 8-bit sRGB level, by the standard's own formula."""
    share = np.asarray(level) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


@pytest.fixture(scope="module")
def stock(inputs, tmp_path_factory):
    """The plates of `inputs`, as one worker makes them in one go. Not to be changed."""
    out = tmp_path_factory.mktemp("stock") / "out"
    done = pavemark(*command(inputs, out))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith(f"3 of 3 plates in {out}, 3 of them made now; to be looked at: {out}/sheet.png\n")
    return out


@pytest.fixture
def mended(stock, tmp_path):
    """A copy of them that hands may mend."""
    return Path(shutil.copytree(stock, tmp_path / "plates"))


def test_files_hold_what_they_should(inputs, stock):
    for name, tone in (("a", 70), ("b", 110), ("c", 150)):
        source, given = (read(inputs / kind / f"{name}.png") for kind in ("images", "masks"))
        plate, mask, ground = (read(stock / kind / f"{name}.png") for kind in ("plates", "masks", "ground"))
        assert plate.shape == (64, 96, 3) and mask.shape == ground.shape == (64, 96)
        assert (mask == given).all() and (ground == 1).all()
        far = cv2.dilate(given, np.ones((9, 9), np.uint8)) == 0
        assert (plate == source)[far].all()
        assert abs(plate[:, 40:42].mean() - tone) < 6 < source[:, 40:42].mean() - tone


def test_rows_tell_of_the_images(inputs, stock):
    told = rows(stock)
    assert told.keys() == {"a", "b", "c"}
    for name, row in told.items():
        assert (row["input"], row["size"]) == (f"{name}.png", [96, 64])
        for path, digest in {
            inputs / "images" / f"{name}.png": row["sha256"],
            inputs / "masks" / f"{name}.png": row["mask"],
            **{stock / path: digest for path, digest in row["files"].items()},
        }.items():
            found = subprocess.run(["sha256sum", path], capture_output=True, text=True, check=True)
            assert found.stdout.split()[0] == digest
        source = read(inputs / "images" / f"{name}.png")
        ratio = linear(source[:, 40:42].mean()) / linear(source[:, :30].mean())
        assert np.allclose(row["ratios"], ratio, rtol=0.1) and len(row["ratios"]) == 1
    settings = json.loads((stock / "plates.json").read_text())
    assert settings["scale"] == 12 and settings["inpainter"]["name"] == "navier-stokes"
    assert settings["versions"]["pavemark"] and settings["versions"]["numpy"] == np.__version__


def test_the_sheet_shows_them(inputs, stock):
    sheet = read(stock / "sheet.png")
    assert max(sheet.shape) <= 3000
    left = [GAP + column * (96 * SCALE + GAP) for column in range(4)]
    tiles = [
        sheet[HEAD : HEAD + 64 * SCALE, x : x + 96 * SCALE][SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] for x in left
    ]
    assert (tiles[0] == read(inputs / "images" / "a.png")).all()
    assert ((tiles[1] == (200, 0, 255)).all(-1) == (read(inputs / "masks" / "a.png") > 0)).all()
    assert (tiles[2] == read(stock / "plates" / "a.png")).all()
    assert (tiles[3] == tiles[2]).all()


def hard(rng, height, width, black=None):
    """Even ground of tone 100 of a size, with the ego car's black on it."""
    image = rng.integers(97, 104, (height, width, 3)).astype(np.uint8)
    if black is not None:
        image[black] = 0
    return image, np.zeros((height, width), np.uint8)


def hard_cases():
    rng = np.random.default_rng(8)
    empty = hard(rng, 64, 96)
    full = hard(rng, 64, 96)
    full[1][:] = 1
    borders = hard(rng, 64, 96)
    borders[1][[0, -1]] = borders[1][:, [0, -1]] = 1
    pixel = hard(rng, 64, 96)
    pixel[1][30, 50] = 1
    car = hard(rng, 96, 64, np.s_[24:72, 22:42])
    car[1][60:62] = 1
    odd = hard(rng, 61, 97)
    odd[1][:, 93:] = 1
    narrow, flat, least = hard(rng, 64, 8), hard(rng, 8, 64), hard(rng, 8, 8)
    narrow[1][20:22] = flat[1][:, 60:] = least[1][0] = 1
    one_column = hard(rng, 64, 8)
    one_column[1][:, 0] = 1
    names = ("empty", "full", "borders", "pixel", "car", "odd", "narrow", "flat", "least", "one_column")
    cases = (empty, full, borders, pixel, car, odd, narrow, flat, least, one_column)
    return dict(zip(names, cases, strict=True))


def test_hard_masks_and_sizes(tmp_path, said):
    (tmp_path / "images").mkdir()
    (tmp_path / "masks").mkdir()
    for name, (image, mask) in hard_cases().items():
        image[(mask > 0) & (image.max(-1) > 0)] = 190
        cv2.imwrite(str(tmp_path / "images" / f"{name}.png"), image)
        cv2.imwrite(str(tmp_path / "masks" / f"{name}.png"), mask)
    out = tmp_path / "out"
    # At this scale the paint's soft edge is two pixels wide.
    code, told, wrong = said(*command(tmp_path, out))
    assert code == 1
    assert "9 of 10 plates" in told and "1 refused" in told
    assert wrong.startswith(f"refused: {tmp_path}/masks/full.png: markings cover the whole ground")
    assert wrong.count("\n") == 1
    assert rows(out)["full"]["refused"].startswith("full.png: markings cover the whole ground")
    for name in hard_cases().keys() - {"full"}:
        source, given = (read(tmp_path / kind / f"{name}.png") for kind in ("images", "masks"))
        plate, mask, ground = (read(out / kind / f"{name}.png") for kind in ("plates", "masks", "ground"))
        far = cv2.dilate(given, np.ones((5, 5), np.uint8)) == 0
        assert (plate == source)[far].all(), name
        assert (mask == given * ground).all(), name
        bare = plate[ground > 0]
        assert bare.min() >= 95 and bare.max() <= 105, name
        if name == "car":
            assert not ground[24:72, 22:42].any() and ground[:, :18].all() and ground[:20].all()
            assert (plate[ground == 0] == source[ground == 0]).all()
        else:
            assert ground.all(), name


@pytest.fixture
def batch(inputs, tmp_path):
    """Three good images, and one each that is cut, grey, or whose mask has another size."""
    home = tmp_path / "batch"
    shutil.copytree(inputs / "images", home / "images")
    shutil.copytree(inputs / "masks", home / "masks")
    whole = (home / "images" / "a.png").read_bytes()
    for name, data in {
        "cut.png": whole[:3000],
        "grey.png": cv2.imencode(".png", read(home / "images" / "a.png")[..., 0])[1].tobytes(),
        "unfit.png": whole,
    }.items():
        (home / "images" / name).write_bytes(data)
        shutil.copy(home / "masks" / "a.png", home / "masks" / name)
    cv2.imwrite(str(home / "masks" / "unfit.png"), np.zeros((10, 10), np.uint8))
    (home / "images" / "lonely.png").write_bytes(whole)
    return home


def test_refused_images_are_a_line_each_and_the_rest_is_done(batch, said, tmp_path):
    out = tmp_path / "out"
    code, told, wrong = said(*command(batch, out, "--workers", "2"))
    assert code == 1 and "3 of 6 plates" in told and "3 refused" in told
    lonely, *refused = wrong.splitlines()
    assert lonely == f"left out: {batch}/images/lonely.png: no mask has its name"
    reasons = {
        "cut": f"{batch}/images/cut.png: image is truncated or damaged: a whole file is allowed",
        "grey": f"{batch}/images/grey.png: image is grey: 8-bit RGB is allowed",
        "unfit": f"{batch}/masks/unfit.png: mask is 10×10 pixels: its image is 96×64",
    }
    assert sorted(refused) == sorted(f"refused: {reason}" for reason in reasons.values())
    kept = rows(out)
    for name, reason in reasons.items():
        assert kept[name] == {
            "name": name,
            "refused": reason.replace(f"{batch}/images/", "").replace(f"{batch}/masks/", ""),
        }
    assert {path.stem for path in files(out)} == {"a", "b", "c"}

    # Mended, one of them joins the others; the others are tried again and nothing else is.
    before, rest = files(out), (out / "plates.jsonl").read_text()
    cv2.imwrite(str(batch / "masks" / "unfit.png"), read(batch / "masks" / "a.png"))
    code, told, wrong = said(*command(batch, out))
    assert code == 1 and "4 of 6 plates" in told and "1 of them made now" in told and wrong.count("refused: ") == 2
    after = files(out)
    assert {path.stem for path in after.keys() - before.keys()} == {"unfit"} and before.items() <= after.items()
    assert [line for line in (out / "plates.jsonl").read_text().splitlines() if "unfit" not in line] == [
        line for line in rest.splitlines() if "unfit" not in line
    ]


def test_no_usable_image_at_all(tmp_path, said):
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.png").write_bytes(b"no")
    code, _, wrong = said("plates", tmp_path / "images", "--out", tmp_path / "out")
    assert code == 2
    assert wrong.splitlines()[-1] == f"error: {tmp_path}/images: none of its 1 images can be used"


@pytest.fixture(scope="module")
def crowd(inputs, tmp_path_factory):
    """Twelve images and their plates, made by one worker in one go."""
    home = many(tmp_path_factory.mktemp("crowd") / "inputs")
    out = home.parent / "out"
    done = pavemark(*command(home, out))
    assert (done.returncode, done.stderr) == (0, "")
    return home, out


def test_interrupted_or_killed_it_goes_on_to_the_same_bytes(crowd, tmp_path):
    home, reference = crowd
    out = tmp_path / "out"
    two = (*command(home, out, "--recycle", "5"), "--workers", "2")
    for way in (signal.SIGKILL, signal.SIGINT):
        made = len(list(out.glob("plates/*.png")))
        run = start(*two, PAVEMARK_CACHE=str(tmp_path / "cache"))
        assert wait_until(lambda made=made: len(list(out.glob("plates/[0-9]*.png"))) > made)
        crew = workers_of(run.pid)
        if way == signal.SIGINT:
            os.killpg(run.pid, way)  # as a terminal does
        else:
            kill(run.pid)
        told, wrong = run.communicate(timeout=30)
        assert crew and wait_until(lambda crew=crew: all(map(gone, crew)))
        for path in files(out):
            assert path.name.startswith(".") or path.read_bytes().endswith(b"IEND\xaeB`\x82"), path
    assert (run.returncode, wrong) == (130, "") and "the same command goes on" in told
    assert not list(out.rglob("*.part"))
    kept = files(out)
    assert 2 <= len(list(out.glob("plates/*.png"))) < 12 and len(rows(out)) == len(list(out.glob("plates/*.png")))
    done = pavemark(*two, PAVEMARK_CACHE=str(tmp_path / "cache"))
    assert (done.returncode, done.stderr) == (0, "")
    assert kept.items() <= files(out).items()
    there, wanted = contents(out), contents(reference)
    assert there.pop("plates.json") and wanted.pop("plates.json")
    assert there == wanted


def test_made_again_nothing_is_redone_and_lost_files_are_made_anew(mended, inputs, stock, said):
    before = files(mended)
    code, told, wrong = said(*command(inputs, mended))
    assert (code, wrong) == (0, "") and "3 of 3 plates" in told and "0 of them made now" in told
    assert files(mended) == before
    (mended / "ground" / "b.png").unlink()
    assert "1 of them made now" in said(*command(inputs, mended))[1]
    changed = {path.stem for path, file in files(mended).items() if before.get(path) != file}
    assert changed == {"b"}
    assert contents(mended) == contents(stock) | {"plates.json": (mended / "plates.json").read_bytes()}


def test_changed_inputs_are_made_anew_unless_their_plate_was_edited(inputs, tmp_path, said):
    home = tmp_path / "home"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
    out = tmp_path / "out"
    assert said(*command(home, out))[0] == 0
    before = files(out)

    os.utime(home / "images" / "a.png", ns=(5, 5))
    assert "0 of them made now" in said(*command(home, out))[1]
    assert files(out) == before
    # What was looked into once is not looked into again.
    assert journal.beside(out)["a"]["image"][1] == 5

    given = read(home / "masks" / "b.png")
    given[10:12] = 1
    cv2.imwrite(str(home / "masks" / "b.png"), given)
    code, told, _ = said(*command(home, out))
    assert code == 0 and "1 of them made now" in told
    assert {path.stem for path, file in files(out).items() if before[path] != file} == {"b"}
    assert (read(out / "masks" / "b.png") == given).all()

    edited = read(out / "plates" / "c.png")
    edited[:5] = 7
    cv2.imwrite(str(out / "plates" / "c.png"), edited)
    os.utime(home / "images" / "c.png", ns=(5, 5))
    code, told, _ = said(*command(home, out))
    assert code == 0 and "0 of them made now" in told
    cv2.imwrite(str(home / "masks" / "c.png"), given)
    code, told, wrong = said(*command(home, out))
    assert code == 1 and "3 of 3 plates" in told and "1 left as hands have mended them" in told
    assert wrong == (
        f"left as it is: {home}/images/c.png: it or its mask has changed since its plate was made, "
        "which hands have mended: remove its files in plates, masks and ground to have it made anew\n"
    )
    assert (read(out / "plates" / "c.png") == edited).all() and "files" in rows(out)["c"]
    # The sheet does without it: the image may be of another size now, or none at all.
    sheet = read(out / "sheet.png")
    given = read(home / "images" / "c.png")
    for content in (cv2.imencode(".png", given[:50])[1].tobytes(), b"junk"):
        (home / "images" / "c.png").write_bytes(content)
        code, told, wrong = said(*command(home, out))
        assert code == 1 and wrong.startswith("left as it is") and wrong.count("\n") == 1
        assert f"to be looked at: {out}/sheet.png" in told and (read(out / "sheet.png") == sheet).all()
    shutil.copy(inputs / "images" / "c.png", home / "images" / "c.png")
    given = read(home / "masks" / "c.png")
    for kind in ("plates", "masks", "ground"):
        (out / kind / "c.png").unlink()
    assert said(*command(home, out))[0] == 0
    assert (read(out / "masks" / "c.png") == given).all()


def test_a_plate_is_filled_anew_as_its_mended_masks_say(inputs, stock, mended, said):
    source = {name: read(inputs / "images" / f"{name}.png") for name in "abc"}
    before = files(mended)
    # In a: another marking, in an editor's white. In b: the car's ground taken out, and the marking on it is none.
    mask, ground = read(mended / "masks" / "a.png"), read(mended / "ground" / "b.png")
    mask[20:22] = 255
    ground[:, 30:50] = 0
    cv2.imwrite(str(mended / "masks" / "a.png"), mask)
    cv2.imwrite(str(mended / "ground" / "b.png"), ground)
    # In c the plate was edited too.
    plate = read(mended / "plates" / "c.png")
    plate[:5] = 7
    cv2.imwrite(str(mended / "plates" / "c.png"), plate)
    cv2.imwrite(str(mended / "masks" / "c.png"), np.zeros_like(mask))

    code, told, wrong = said(*command(inputs, mended))
    assert (code, wrong) == (0, "") and "2 of them made now" in told
    assert (read(mended / "masks" / "a.png") == (mask > 0)).all()
    a, b, c = (read(mended / "plates" / f"{name}.png") for name in "abc")
    assert (a[20:22, :30] != source["a"][20:22, :30]).any()
    assert (a[5:15] == read(stock / "plates" / "a.png")[5:15]).all()
    assert (b == source["b"]).all() and not read(mended / "masks" / "b.png").any()
    assert (read(mended / "ground" / "b.png") == ground).all()
    assert (c == plate).all() and not read(mended / "masks" / "c.png").any()
    told = rows(mended)
    assert [told[name].get("mended", False) for name in "abc"] == [True, True, False]
    assert told["a"]["ratios"] and not told["b"]["ratios"]

    # That stays so, and given masks change it no more.
    before = files(mended)
    assert "0 of them made now" in said(*command(inputs, mended))[1]
    assert files(mended) == before
    mask = read(mended / "masks" / "a.png")
    (mended / "plates" / "a.png").unlink()
    code, told, wrong = said(*command(inputs, mended))
    assert (code, wrong) == (0, "") and "1 of them made now" in told
    assert (read(mended / "masks" / "a.png") == mask).all() and (read(mended / "plates" / "a.png") == a).all()
    (mended / "ground" / "a.png").unlink()
    code, told, wrong = said(*command(inputs, mended))
    assert code == 1 and wrong.startswith(f"left as it is: {mended}/ground/a.png: is missing and belongs to a plate ")
    assert (read(mended / "masks" / "a.png") == mask).all()
    cv2.imwrite(str(mended / "ground" / "a.png"), np.ones_like(mask))
    mask[0, 0] = 3
    cv2.imwrite(str(mended / "masks" / "a.png"), mask)
    code, _, wrong = said(*command(inputs, mended))
    assert code == 1 and wrong == f"refused: {mended}/masks/a.png: mask value 3: allowed are 0, and 1 or 255\n"


def test_a_mended_mask_outlives_its_plate(inputs, mended, said):
    """Mended and never filled, then the plate taken out to have it filled: the automatic mask must not come back."""
    mask = read(mended / "masks" / "a.png")
    mask[20:22] = 1
    cv2.imwrite(str(mended / "masks" / "a.png"), mask)
    (mended / "plates" / "a.png").unlink()
    code, told, wrong = said(*command(inputs, mended))
    assert (code, wrong) == (0, "") and "1 of them made now" in told
    assert (read(mended / "masks" / "a.png") == mask).all() and rows(mended)["a"]["mended"]
    source = read(inputs / "images" / "a.png")
    assert (read(mended / "plates" / "a.png")[20:22, :30] != source[20:22, :30]).any()


def test_a_given_mask_that_changes_under_a_mended_one_is_told(inputs, tmp_path, said):
    home, out = tmp_path / "home", tmp_path / "out"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
    said(*command(home, out))
    mask = read(out / "masks" / "a.png")
    mask[20:22] = 1
    cv2.imwrite(str(out / "masks" / "a.png"), mask)
    assert "1 of them made now" in said(*command(home, out))[1]
    given = read(home / "masks" / "a.png")
    given[30:32] = 1
    cv2.imwrite(str(home / "masks" / "a.png"), given)
    code, told, wrong = said(*command(home, out))
    assert code == 1 and "0 of them made now" in told
    assert wrong.startswith(f"left as it is: {home}/images/a.png: it or its mask has changed")
    assert (read(out / "masks" / "a.png") == mask).all()


def test_images_that_break_or_go_are_no_plates_of_this_run(inputs, tmp_path, said):
    home, out = tmp_path / "home", tmp_path / "out"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
    said(*command(home, out))
    (home / "images" / "a.png").write_bytes(b"junk")
    (home / "images" / "b.png").unlink()
    (home / "masks" / "b.png").unlink()
    code, told, wrong = said(*command(home, out))
    assert code == 1 and "1 of 2 plates" in told and "1 refused" in told
    assert f"1 more of images that are not in {home}/images" in told
    assert "refused" in rows(out)["a"] and "files" in rows(out)["b"]
    _, _, wrong = said("render", "--plates", out, "--count", "4", "--workers", "1", "--out", tmp_path / "made")
    used = {json.loads(path.read_text())["plate"]["name"] for path in (tmp_path / "made" / "scenes").iterdir()}
    assert used == {"b", "c"}
    assert wrong == f"left out: {out}/plates/a.png: plates.jsonl does not tell of it\n"


def test_folders_that_are_refused(inputs, stock, tmp_path, said):
    code, _, wrong = said(*command(inputs, stock, "--scale", "13", "--inpainter", "fsr"))
    assert code == 2
    assert wrong == (
        f"error: {stock}: holds another set of plates: inpainter.name was 'navier-stokes' and is 'fsr', "
        "scale was 12.0 and is 13.0; use another folder\n"
    )
    code, _, wrong = said("plates", inputs / "images", *OPTIONS, "--out", stock)
    assert code == 2 and "holds another set of plates" in wrong and "masks was " in wrong and " and is None" in wrong
    code, _, wrong = said("plates", inputs / "images", "--masks", stock / "masks", *OPTIONS, "--out", stock)
    assert wrong == f"error: {stock}/masks: is the folder of the inputs: another folder is allowed\n"
    before = contents(stock)
    code, _, wrong = said("plates", stock / "plates" / "a.png", "--masks", inputs / "masks", *OPTIONS, "--out", stock)
    assert wrong == f"error: {stock}/plates: is the folder of the inputs: another folder is allowed\n"
    assert code == 2 and contents(stock) == before
    code, _, wrong = said("plates", inputs / "images", "--masks", inputs / "masks", "--out", inputs)
    assert wrong == f"error: {inputs}/masks: is the folder of the inputs: another folder is allowed\n"
    shutil.copytree(inputs / "masks", tmp_path / "out" / "masks")
    code, _, wrong = said(*command(inputs, tmp_path / "out"))
    assert wrong.startswith(f"error: {tmp_path}/out: has files in masks and no plates.json")
    assert "unknown field noise" in said(*command(inputs, tmp_path / "other", "--set", "noise.rate = 0"))[2]
    assert "segmenter = 'magic': allowed" in said(*command(inputs, tmp_path / "other", "--segmenter", "magic"))[2]
    assert "Missing argument 'IMAGES'" in said("plates", "--out", tmp_path / "other")[2]
    assert not (tmp_path / "other").exists()


def test_a_folder_that_cannot_be_listed_is_a_line(inputs, mended, said, monkeypatch):
    listed = os.scandir

    def scandir(path):
        # Root, as which tests may run, may list any.
        if Path(path) == mended / "plates":
            raise PermissionError(13, "Permission denied", str(path))
        return listed(path)

    monkeypatch.setattr(os, "scandir", scandir)
    code, _, wrong = said(*command(inputs, mended))
    assert (code, wrong) == (2, f"error: {mended}/plates: cannot be listed: Permission denied\n")
    assert not (mended / "errors.log").exists()


def test_without_masks_the_markings_are_found(tmp_path, said):
    rng = np.random.default_rng(5)
    image = rng.integers(95, 106, (180, 200, 3)).astype(np.uint8)
    image[30:36, 10:190] = 200
    (tmp_path / "images").mkdir()
    cv2.imwrite(str(tmp_path / "images" / "a.png"), image)
    out = tmp_path / "out"
    strokes = ("--scale", "40", *OPTIONS[2:])
    assert said("plates", tmp_path / "images", *strokes, "--out", out)[0] == 0
    mask = read(out / "masks" / "a.png")
    assert mask[31:35, 20:180].mean() > 0.9 and mask[50:].sum() == 0
    assert read(out / "plates" / "a.png")[30:36, 10:190].max() < 130
    settings = json.loads((out / "plates.json").read_text())
    assert settings["segmenter"]["name"] == "strokes" and settings["masks"] is None
    assert rows(out)["a"]["mask"] is None


def in_trouble(home, out):
    """Make plates of a folder with workers that die on some; the exit code."""
    told = Inputs(
        images=str(home / "images"),
        masks=str(home / "masks"),
        scale=12.0,
        inpainter="navier-stokes",
        segmenter="strokes",
    )
    worker = (sys.executable, str(Path(__file__).parents[1] / "plate_trouble.py"))
    return make(told, out, Machine(worker, 2), Quiet())


def test_a_worker_that_dies_takes_nothing_with_it(inputs, tmp_path, capfd):
    home, out = tmp_path / "home", tmp_path / "out"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
        for name in ("deadly", "faulty"):
            shutil.copy(home / kind / "a.png", home / kind / f"{name}.png")
    assert in_trouble(home, out) == 1
    assert {path.stem for path in files(out)} == {"a", "b", "c"}
    died, faulty = sorted(capfd.readouterr().err.splitlines())
    assert died == f"{home}/images/deadly.png failed: its worker was killed by signal 9 ({out}/errors.log has more)"
    assert faulty.startswith(f"{home}/images/faulty.png failed: ArithmeticError: a fault of two lines (")
    assert "Traceback" in (out / "errors.log").read_text()


def test_what_failed_has_no_plate_of_what_it_was_before(inputs, tmp_path, said, capfd):
    """The image changes, of another size, and the worker dies of it: the sheet and the rows tell of the others."""
    home, out = tmp_path / "home", tmp_path / "out"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
        shutil.copy(home / kind / "a.png", home / kind / "deadly.png")
    assert said(*command(home, out))[0] == 0
    for kind in ("images", "masks"):
        cv2.imwrite(str(home / kind / "deadly.png"), cv2.copyMakeBorder(read(home / kind / "a.png"), 9, 9, 9, 9, 2))
    assert in_trouble(home, out) == 1
    assert "deadly.png failed: " in capfd.readouterr().err
    kept = rows(out)
    assert kept["deadly"] == {"name": "deadly", "refused": "failed: its worker was killed by signal 9"}
    assert "sha256" in kept["a"]
    code, told, wrong = said(*command(home, out))
    assert (code, wrong) == (0, "") and "1 of them made now" in told
    assert "sha256" in rows(out)["deadly"] and read(out / "plates/deadly.png").shape[0] == 64 + 18


def test_stopped_after_a_refusal_it_does_not_say_that_none_can_be_used(crowd, tmp_path):
    home, _ = crowd
    shutil.copytree(home, tmp_path / "home")
    (tmp_path / "home/images/0-first.png").write_bytes(b"no picture")
    shutil.copy(home / "masks/00.png", tmp_path / "home/masks/0-first.png")
    run = start(*command(tmp_path / "home", tmp_path / "out"), PAVEMARK_CACHE=str(tmp_path / "cache"))
    line = run.stderr.readline()
    os.killpg(run.pid, signal.SIGINT)
    told, _ = run.communicate(timeout=30)
    assert line.startswith("refused: ") and run.returncode == 130 and "the same command goes on" in told


def test_links_that_lead_nowhere_and_the_longest_names(inputs, tmp_path, said):
    home = tmp_path / "home"
    for kind in ("images", "masks"):
        (home / kind).mkdir(parents=True)
        shutil.copy(inputs / kind / "a.png", home / kind / f"{'停' * 81}.png")
    (home / "images/away.png").symlink_to("/nowhere/away.png")
    (home / "masks/away.png").symlink_to("/nowhere/away.png")
    code, told, wrong = said(*command(home, tmp_path / "out"))
    assert code == 1 and "1 of 2 plates" in told
    assert wrong.startswith(f"refused: {home}/images/away.png: ") and wrong.count("\n") == 1
    assert [path.stem for path in files(tmp_path / "out")] == ["停" * 81] * 3


def test_killed_while_plates_are_made_anew_it_goes_on_to_the_same_bytes(inputs, tmp_path, said, capfd):
    """What was written over by then is not taken for the work of hands, and theirs is kept."""
    home, out, reference = tmp_path / "home", tmp_path / "out", tmp_path / "reference"
    for kind in ("images", "masks"):
        shutil.copytree(inputs / kind, home / kind)
        for name in ("halfway", "untold"):
            shutil.copy(home / kind / "a.png", home / kind / f"{name}.png")
    for folder in (out, reference):
        assert said(*command(home, folder))[0] == 0
        mask = read(folder / "masks" / "untold.png")
        mask[20:22] = 255
        cv2.imwrite(str(folder / "masks" / "untold.png"), mask)
    shutil.copy(home / "images" / "b.png", home / "images" / "halfway.png")
    given = read(home / "masks" / "halfway.png")
    given[10:12] = 1
    cv2.imwrite(str(home / "masks" / "halfway.png"), given)

    assert in_trouble(home, out) == 1
    assert capfd.readouterr().err.count("its worker was killed by signal 9") == 2
    assert (read(out / "masks" / "halfway.png") == given).all()
    # Neither the old nor the new row is that of their files.
    assert {name for name, row in rows(out).items() if "refused" not in row} == {"a", "b", "c"}
    for folder in (out, reference):
        code, told, wrong = said(*command(home, folder))
        assert (code, wrong) == (0, "") and "5 of 5 plates" in told and "2 of them made now" in told
    there, wanted = contents(out), contents(reference)
    for name in ("plates.json", "errors.log"):
        there.pop(name), wanted.pop(name, None)
    assert there == wanted and rows(out)["untold"]["mended"]


RENDER = ("--count", "7", "--seed", "7", "--workers", "1")


@pytest.fixture(scope="module")
def drawn(inputs, tmp_path_factory):
    """The dataset that is made of images and masks."""
    out = tmp_path_factory.mktemp("drawn") / "out"
    given = ("--images", inputs / "images", "--masks", inputs / "masks")
    done = pavemark("render", *given, *OPTIONS, *RENDER, "--set", "layout.original_rate = 0.3", "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    return out


def test_images_of_plates_are_the_images_of_their_images(drawn, stock, tmp_path, said):
    out = tmp_path / "out"
    job = ("render", "--plates", stock, *RENDER, "--set", "layout.original_rate = 0.3", "--out", out)
    assert said(*job)[0] == 0
    there, wanted = contents(out), contents(drawn)
    assert json.loads(there.pop("job.json"))["scale"] == json.loads(wanted.pop("job.json"))["scale"] == 12
    assert there == wanted
    scenes = [json.loads((out / f"scenes/{k:06d}.json").read_text()) for k in range(7)]
    assert any("optics" in scene for scene in scenes) and any(scene.get("markings") for scene in scenes)
    # Again, a scale that agrees does no harm, and the folders may be called otherwise.
    code, told, _ = said(*job, "--metres-per-pixel", "0.0833333333")
    assert code == 0 and "0 of them made now" in told


def test_the_blur_of_the_image_outlives_its_markings(tmp_path, said):
    rng = np.random.default_rng(6)
    mask = np.zeros((180, 200), np.uint8)
    mask[30:36] = mask[140:146] = mask[:, 60:66] = 1
    line = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 2.5)[..., None]
    image = rng.normal(90, 1, (180, 200, 3)) + 90 * line
    for kind, pixels in (("images", image.clip(0, 255).astype(np.uint8)), ("masks", mask)):
        (tmp_path / kind).mkdir()
        cv2.imwrite(str(tmp_path / kind / "a.png"), pixels)
    options = ("--scale", "40", *OPTIONS[2:])
    given = (tmp_path / "images", "--masks", tmp_path / "masks", *options)
    assert said("plates", *given, "--out", tmp_path / "plates")[0] == 0
    job = ("--count", "2", "--set", "layout.empty_rate = 0", "--workers", "1")
    assert said("render", "--images", *given, *job, "--out", tmp_path / "one")[0] == 0
    assert said("render", "--plates", tmp_path / "plates", *job, "--out", tmp_path / "two")[0] == 0
    one, two = (contents(tmp_path / out) for out in ("one", "two"))
    assert one.pop("job.json") != two.pop("job.json") and one == two
    plate = stock_of(tmp_path / "plates").plate("a")
    assert plate.blur == json.loads(one["scenes/000000.json"], object_hook=_tuples)["optics"]["blur"]
    assert plate.blur != measure(plate)


def _tuples(data):
    return {name: tuple(map(tuple, value)) if name == "blur" else value for name, value in data.items()}


def test_edited_files_are_honoured(mended, tmp_path, said):
    plate, ground = read(mended / "plates" / "a.png"), read(mended / "ground" / "b.png")
    plate[:20, :30] = (10, 200, 30)
    cv2.imwrite(str(mended / "plates" / "a.png"), plate)
    ground[:, 48:] = 0
    cv2.imwrite(str(mended / "ground" / "b.png"), ground)
    out = tmp_path / "out"
    plain = ("--set", "noise.rate = 0", "--set", "brightness.rate = 0", "--set", "layout.empty_rate = 0.3")
    job = ("render", "--plates", mended, *RENDER[:1], "24", *RENDER[2:], *plain, "--out", out)
    assert said(*job)[0] == 0
    seen = {name: np.zeros((64, 96), bool) for name in "abc"}
    for path in sorted((out / "scenes").iterdir()):
        name = json.loads(path.read_text())["plate"]["name"]
        image = read(out / "images" / f"{path.stem}.png")
        lines = read(out / "masks" / f"{path.stem}.png")
        seen[name] |= lines > 0
        if name == "a":
            corner = image[:20, :30][lines[:20, :30] == 0]
            assert (corner == (10, 200, 30)).mean() > 0.5
    assert seen["c"][:, 48:].any() and not seen["b"][:, 48:].any() and seen["b"][:, :48].any()
    # What images were made of is not mixed with what it becomes.
    plate[:20, :30] = (200, 10, 30)
    cv2.imwrite(str(mended / "plates" / "a.png"), plate)
    code, _, wrong = said(*job, "--count", "30")
    assert code == 2 and wrong.startswith(f"error: {mended}/plates/a.png: it or its mask has changed since images were")


@pytest.mark.parametrize(
    ("kind", "mend", "told"),
    [
        ("masks", lambda pixels: None, "cannot be read: No such file or directory"),
        ("ground", lambda pixels: pixels[:50], "mask is 96×50 pixels: its image is 96×64"),
        ("masks", lambda pixels: pixels * 254, "mask value 254: allowed are 0, and 1 or 255"),
        ("masks", lambda pixels: np.dstack([pixels, pixels, 1 - pixels]), "mask has colours or alpha"),
        ("plates", lambda pixels: pixels[:, :90], "plate is 90×64 pixels: it was made 96×64"),
        ("plates", lambda pixels: np.dstack([pixels, pixels[..., 0]]), "image is with alpha: 8-bit RGB is allowed"),
    ],
)
def test_files_mended_badly_are_a_line_and_the_others_are_used(mended, tmp_path, said, kind, mend, told):
    path = mended / kind / "b.png"
    pixels = mend(read(path))
    path.unlink() if pixels is None else cv2.imwrite(str(path), pixels)
    code, summary, wrong = said("render", "--plates", mended, *RENDER[:1], "6", *RENDER[2:], "--out", tmp_path / "out")
    assert code == 1 and "4 of 6 images" in summary
    assert wrong.startswith(f"left out: {path}: {told}") and wrong.count("\n") == 1


def test_plates_taken_out_or_put_in(mended, tmp_path, said):
    (mended / "plates" / "a.png").unlink()
    shutil.copy(mended / "plates" / "b.png", mended / "plates" / "strange.png")
    code, told, wrong = said("render", "--plates", mended, "--count", "4", "--workers", "1", "--out", tmp_path / "out")
    assert code == 1 and "4 of 4 images" in told
    assert wrong == f"left out: {mended}/plates/strange.png: plates.jsonl does not tell of it\n"
    used = {json.loads(path.read_text())["plate"]["name"] for path in (tmp_path / "out" / "scenes").iterdir()}
    assert used == {"b", "c"}


def test_jobs_that_contradict_their_plates(inputs, stock, tmp_path, said):
    def wrong(*words):
        code, _, told = said(*words, "--out", tmp_path / "out")
        assert code == 2 and told.count("\n") == 1 and not (tmp_path / "out").exists()
        return told

    both = ("render", "--plates", stock, "--images", inputs / "images")
    assert wrong(*both) == (
        "error: command line: images and plates are given: plates are made already, they stand alone\n"
    )
    assert wrong("render", "--plates", stock, "--scale", "13") == (
        f"error: {stock}/plates.json: scale = 12 pixels per metre there, 13 in the job: leave it out of the job\n"
    )
    assert "inpainter and plates are given" in wrong("render", "--plates", stock, "--inpainter", "fsr")
    assert "images/plates.jsonl: cannot be read" in wrong("render", "--plates", inputs / "images")
    assert "it is empty: a folder is needed" in wrong("render", "--plates", "")
    job = tmp_path / "job.toml"
    job.write_text(f"images = 'there'\nplates = '{stock}'\n")
    assert wrong("render", job).startswith(f"error: {job}: images and plates are given")
    torn = Path(shutil.copytree(stock, tmp_path / "torn"))
    (torn / "plates.jsonl").write_text("hello\n")
    assert f"{torn}/plates.jsonl: line 1 does not tell of a plate" in wrong("render", "--plates", torn)
    (torn / "plates.jsonl").write_text("")
    assert "tells of no plate that is there" in wrong("render", "--plates", torn)
    shutil.copy(stock / "plates.jsonl", torn)
    (torn / "plates.json").write_text('{"scale": "large"}')
    assert f"{torn}/plates.json: scale: 'large' is not a number" in wrong("render", "--plates", torn)


def test_a_job_file_may_name_them_and_the_command_line_replace_them(inputs, stock, tmp_path, said):
    job = tmp_path / "job.toml"
    job.write_text(f"plates = '{os.path.relpath(stock, tmp_path)}'\ncount = 1\n")
    assert said("render", job, "--workers", "1", "--out", tmp_path / "one")[0] == 0
    recorded = json.loads((tmp_path / "one" / "job.json").read_text())
    assert recorded["images"] is None and recorded["plates"] == os.path.relpath(stock, tmp_path / "one")
    code, _, wrong = said("render", job, "--images", inputs / "images", *OPTIONS, "--out", tmp_path / "one")
    assert code == 2 and "images was None and is" in wrong
    job.write_text("images = 'nowhere'\nmasks = 'nowhere'\ninpainter = 'fsr'\ncount = 1\n[mask]\nground = [0]\n")
    assert said("render", job, "--plates", stock, "--workers", "1", "--out", tmp_path / "two")[0] == 0


def test_the_preview_shows_the_plates(stock, tmp_path, said):
    out = tmp_path / "out"
    assert said("render", "--plates", stock, "--count", "1", "--seed", "2", "--workers", "1", "--out", out)[0] == 0
    sheet = read(preview(out))
    name = json.loads((out / "scenes/000000.json").read_text())["plate"]["name"]
    tile = sheet[HEAD : HEAD + 64 * SCALE, 2 * GAP + 96 * SCALE :][:, : 96 * SCALE]
    assert (tile[SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] == read(stock / "plates" / f"{name}.png")).all()
