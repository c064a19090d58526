import hashlib
import os
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.background import cache, plates
from pavemark.background.plates import make_plate
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError

RNG = np.random.default_rng(9)
TABLE = MaskTable()


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PAVEMARK_CACHE", str(tmp_path / "cache"))
    plates._plate.cache_clear()


def pixels() -> tuple[np.ndarray, np.ndarray]:
    """A garage floor with a black car, a line of ratio 2 in linear light, and its mask."""
    image = RNG.integers(90, 101, (180, 200, 3)).astype(np.uint8)
    mask = np.zeros((180, 200), np.uint8)
    mask[30:36, 10:190] = mask[20:110, 60:66] = 1
    image[mask > 0] = 130
    image[50:130, 80:120] = 0
    return image, mask


def saved(folder: Path, image: np.ndarray, mask: np.ndarray) -> tuple[Path, Path]:
    (folder / "masks").mkdir(exist_ok=True)
    cv2.imwrite(str(folder / "a.png"), image[..., ::-1])
    cv2.imwrite(str(folder / "masks/a.png"), mask)
    return folder / "a.png", folder / "masks/a.png"


@pytest.fixture
def files(tmp_path):
    return saved(tmp_path, *pixels())


def made(files, scale=40.0, table=TABLE, method="navier-stokes"):
    return make_plate(*files, scale, table, method, "strokes")


def same(a, b) -> bool:
    arrays = ("image", "ground", "markings", "source")
    return (
        a.sha256 == b.sha256
        and a.ratios == b.ratios
        and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in arrays)
    )


@pytest.mark.parametrize("method", ["navier-stokes", "fsr", "patchmatch"])
def test_the_markings_are_gone_and_the_rest_is_the_image(files, method):
    image, mask = cv2.imread(str(files[0]))[..., ::-1], cv2.imread(str(files[1]), 0) > 0
    plate = made(files, method=method)
    hole = cv2.dilate(mask.astype(np.uint8), np.ones((11, 11))) > 0
    assert np.array_equal(plate.image[~hole], image[~hole])
    assert plate.image[mask & plate.ground].min() >= 80
    assert plate.image[mask & plate.ground].max() <= 112
    assert np.array_equal(plate.source, image)
    assert plate.name == "a"
    assert (plate.frame.width, plate.frame.height, plate.frame.scale) == (200, 180, 40.0)


def test_the_car_is_not_ground_and_stays_black(files):
    plate = made(files)
    assert not plate.ground[50:130, 80:120].any()
    assert plate.ground[:, :75].all()
    assert not plate.image[50:130, 80:120].any()


def test_a_mask_that_names_its_ground_is_believed(files):
    image, mask = pixels()
    mask[150:, :] = 2
    saved(files[0].parent, image, mask)
    plate = made(files, table=MaskTable(ground=(0,)))
    assert not plate.ground[150:].any()
    assert plate.ground[60:120, 85:115].all()


def test_ratios_are_measured(files):
    (ratio,) = made(files).ratios
    # Levels 130 over 95, in linear light.
    assert ratio == pytest.approx((1.92,) * 3, rel=0.05)


def test_without_a_mask_the_markings_are_found(files):
    mask = cv2.imread(str(files[1]), 0) > 0
    plate = make_plate(files[0], None, 40.0, TABLE, "navier-stokes", "strokes")
    assert (plate.markings & mask).sum() > 0.8 * mask.sum()
    assert plate.markings.sum() < 1.3 * mask.sum()


def test_the_cache_gives_the_same_plate_fast(files, monkeypatch):
    first = made(files, method="patchmatch")
    plates._plate.cache_clear()
    monkeypatch.setattr(plates, "_made", None)
    start = time.perf_counter()
    second = made(files, method="patchmatch")
    # 3 ms here; the bound only tells reading from making, which takes seconds, on a busy machine.
    assert time.perf_counter() - start < 0.2
    assert same(first, second)


def test_the_last_plates_stay_in_memory(files):
    assert made(files) is made(files)


def test_arrays_that_are_shared_cannot_be_written(files):
    plate = made(files)
    for array in (plate.image, plate.ground, plate.markings, plate.source):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_other_input_is_another_plate(files, monkeypatch):
    image, mask = pixels()
    keys = {plates._Source(*files, 40.0, TABLE, "navier-stokes").key()}
    keys.add(plates._Source(*files, 41.0, TABLE, "navier-stokes").key())
    keys.add(plates._Source(*files, 40.0, MaskTable(ground=(0,)), "navier-stokes").key())
    keys.add(plates._Source(*files, 40.0, TABLE, "fsr").key())
    keys.add(plates._Source(files[0], None, 40.0, TABLE, "navier-stokes").key())
    saved(files[0].parent, image, 1 - mask)
    keys.add(plates._Source(*files, 40.0, TABLE, "navier-stokes").key())
    saved(files[0].parent, image + 1, mask)
    keys.add(plates._Source(*files, 40.0, TABLE, "navier-stokes").key())
    monkeypatch.setattr(plates, "VERSION", -1)
    keys.add(plates._Source(*files, 40.0, TABLE, "navier-stokes").key())
    assert len(keys) == 8


def test_a_changed_file_is_seen(files):
    before = made(files)
    image, mask = pixels()
    saved(files[0].parent, image[::-1], mask)
    assert not np.array_equal(made(files).source, before.source)


@pytest.mark.parametrize("damage", ["truncated", "flipped", "empty", "text", "folder"])
def test_a_damaged_entry_is_made_anew(files, tmp_path, damage):
    first = made(files)
    plates._plate.cache_clear()
    (entry,) = (tmp_path / "cache").rglob("*.npz")
    data = bytearray(entry.read_bytes())
    if damage == "folder":
        entry.unlink()
        entry.mkdir()
    else:
        data[len(data) // 2] ^= 255
        entry.write_bytes({"truncated": data[:-30], "flipped": data, "empty": b"", "text": b"hello"}[damage])
    assert same(made(files), first)
    if damage != "folder":
        assert cache.load(entry.stem) is not None


def test_a_cache_that_cannot_be_written_is_done_without(files, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("PAVEMARK_CACHE", str(tmp_path / "file/below"))
    assert made(files).image.any()


def test_where_the_cache_lies(monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    monkeypatch.setenv("PAVEMARK_CACHE", "/own")
    assert cache.folder() == Path("/own")
    monkeypatch.delenv("PAVEMARK_CACHE")
    assert cache.folder() == Path("/somewhere/pavemark")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/home/me")
    assert cache.folder() == Path("/home/me/.cache/pavemark")


def test_a_mask_of_nothing_but_marking_is_refused(files):
    image, mask = pixels()
    saved(files[0].parent, image, np.ones_like(mask))
    with pytest.raises(InputError, match=r"masks/a\.png: markings cover the whole ground"):
        made(files)


def test_names_no_scene_can_carry_and_unknown_methods_are_refused(files):
    odd = files[0].rename(files[0].with_name("a..b.png"))
    with pytest.raises(InputError, match="plain name"):
        make_plate(odd, files[1], 40.0, TABLE, "fsr", "strokes")
    with pytest.raises(InputError, match="'lama': allowed"):
        made(files, method="lama")


def test_no_part_of_a_file_is_left_behind(files, tmp_path):
    made(files)
    assert [name for _, _, names in os.walk(tmp_path / "cache") for name in names if not name.endswith(".npz")] == []


def test_a_plate_is_the_same_bytes_everywhere(tmp_path):
    # Navier-Stokes on whole numbers: if this hash changes, so do the images of every job that uses it.
    image = np.add.outer(np.arange(64), np.arange(64)).astype(np.uint8)[..., None].repeat(3, 2)
    mask = np.zeros((64, 64), np.uint8)
    mask[20:24, 5:60] = 1
    first = made(saved(tmp_path, image, mask))
    plates._plate.cache_clear()
    digest = hashlib.sha256(first.image.tobytes()).hexdigest()
    assert digest == hashlib.sha256(made((tmp_path / "a.png", tmp_path / "masks/a.png")).image.tobytes()).hexdigest()


def test_the_roadside_is_found_and_kept(files, monkeypatch):
    image = np.full((180, 200, 3), 95, np.uint8)
    mask = np.zeros((180, 200), np.uint8)
    mask[:, 150:154] = mask[20:24, 154:] = mask[120:124, 154:] = 1
    image[mask > 0] = 150
    saved(files[0].parent, image, mask)
    first = made(files)
    assert first.roadside.direction == pytest.approx(np.pi / 2, abs=0.01)
    assert first.roadside.right == pytest.approx(-52 / 40, abs=0.05)
    assert first.roadside.left is None
    plates._plate.cache_clear()
    monkeypatch.setattr(plates, "_made", None)
    assert made(files).roadside == first.roadside


def test_bare_ground_has_no_roadside(files):
    saved(files[0].parent, np.full((180, 200, 3), 95, np.uint8), np.zeros((180, 200), np.uint8))
    assert made(files).roadside is None
    plates._plate.cache_clear()
    assert made(files).roadside is None


def test_an_image_without_ground_is_refused_also_from_the_cache(files):
    """It was a plate with all its markings, of which no label tells."""
    image, mask = pixels()
    saved(files[0].parent, image, np.full_like(mask, 2))
    for _ in range(2):
        with pytest.raises(InputError, match=r"masks/a\.png: no ground is in it"):
            made(files, table=MaskTable(ground=(0,)))
        plates._plate.cache_clear()
    saved(files[0].parent, np.zeros_like(image), mask)
    with pytest.raises(InputError, match=r"^\S+/a\.png: no ground is found in it: some is needed for paint$"):
        make_plate(files[0], None, 40.0, TABLE, "navier-stokes", "strokes")
