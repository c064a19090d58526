import os
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.background.reading import MaskTable, read_image, read_mask
from pavemark.errors import InputError
from pavemark.records import structure

RNG = np.random.default_rng(7)
RGB = RNG.integers(0, 256, (40, 60, 3), np.uint8)
MASK = RNG.integers(0, 2, (40, 60), np.uint8)


def saved(path: Path, pixels: np.ndarray) -> Path:
    assert cv2.imwrite(str(path), pixels[..., ::-1] if pixels.ndim == 3 and pixels.shape[2] == 3 else pixels)
    return path


def empty_png(path: Path, width: int, height: int, depth: int = 8, colour: int = 2) -> Path:
    """A PNG with nothing but a sound header."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    body = RNG.bytes(2_000_000)  # OpenImageIO mistrusts a header that claims much more than the file can hold
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b""))
    return path


@pytest.mark.parametrize("ending", ["png", "bmp", "tif", "PNG"])
def test_pixels_come_in_the_order_red_green_blue(tmp_path, ending):
    assert np.array_equal(read_image(saved(tmp_path / f"a.{ending}", RGB)), RGB)


def refused(read, *arguments) -> str:
    with pytest.raises(InputError) as caught:
        read(*arguments)
    assert "\n" not in str(caught.value)
    assert str(arguments[0]) in str(caught.value)
    return caught.value.what


def test_text_is_not_an_image(tmp_path):
    path = tmp_path / "a.png"
    path.write_text("hello")
    assert "not an image" in refused(read_image, path)


def test_a_name_that_is_not_text_is_refused(tmp_path):
    path = saved(tmp_path / "a.png", RGB)
    odd = path.rename(tmp_path / os.fsdecode(b"\xff.png"))
    assert "not UTF-8" in refused(read_image, odd)


def test_a_missing_file_is_named(tmp_path):
    assert "cannot be read" in refused(read_image, tmp_path / "none.png")


@pytest.mark.parametrize("ending", ["png", "jpg", "bmp"])
@pytest.mark.parametrize("share", [0.1, 0.6, 0.98])
def test_a_truncated_file_is_refused_without_noise(tmp_path, ending, share, capfd):
    path = saved(tmp_path / f"a.{ending}", RGB)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    assert any(word in refused(read_image, path) for word in ("truncated", "not an image"))
    assert capfd.readouterr().err == ""


def test_a_png_with_one_wrong_byte_is_refused(tmp_path, capfd):
    path = saved(tmp_path / "a.png", RGB)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 255
    path.write_bytes(data)
    assert "damaged" in refused(read_image, path)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("pixels", "told"),
    [
        (RGB[..., 0], "grey: 8-bit RGB is allowed"),
        (np.dstack([RGB, RGB[..., :1]]), "with alpha: 8-bit RGB is allowed"),
        (RGB.astype(np.uint16) * 257, "uint16 values: 8 bits a channel are allowed"),
        (RGB[:1, :1], "1×1 pixels: 8 to 16384"),
        (RGB[:7], "60×7 pixels: 8 to 16384"),
    ],
)
def test_images_of_another_kind_are_told_what_is_allowed(tmp_path, pixels, told):
    assert told in refused(read_image, saved(tmp_path / "a.png", pixels))


def test_an_image_too_large_is_known_by_its_header(tmp_path):
    # There are no pixels to decode in this file: only a reader that stops at the header can tell its size.
    assert "20000×20000 pixels: 8 to 16384" in refused(read_image, empty_png(tmp_path / "a.png", 20000, 20000))


def test_by_default_one_is_marking_and_zero_is_ground(tmp_path):
    classes = read_mask(saved(tmp_path / "a.png", MASK), MaskTable(), MASK.shape)
    assert np.array_equal(classes.marking, MASK == 1)
    assert classes.ground.all()


def test_a_table_maps_values_and_what_it_does_not_list_is_not_ground(tmp_path):
    values = RNG.integers(0, 6, (40, 60), np.uint8)
    table = structure(MaskTable, {"marking": [1, 3], "ground": [4]}, "job.toml")
    classes = read_mask(saved(tmp_path / "a.png", values), table, values.shape)
    assert np.array_equal(classes.marking, np.isin(values, (1, 3)))
    assert np.array_equal(classes.ground, np.isin(values, (1, 3, 4)))


def test_a_mask_of_three_equal_channels_is_read(tmp_path):
    classes = read_mask(saved(tmp_path / "a.png", np.dstack([MASK] * 3)), MaskTable(), MASK.shape)
    assert np.array_equal(classes.marking, MASK == 1)


@pytest.mark.parametrize(
    ("pixels", "told"),
    [
        (MASK * 255, "mask value 255: allowed are 0 (ground), 1 (marking); others need a [mask] table"),
        (MASK[:-1], "mask is 60×39 pixels: its image is 60×40"),
        (MASK.astype(np.uint16), "16 bits a value"),
        (RGB, "colours"),
        (np.dstack([RGB[..., :1]] * 4), "alpha"),
    ],
)
def test_masks_of_another_kind_are_told_what_is_allowed(tmp_path, pixels, told):
    assert told in refused(read_mask, saved(tmp_path / "a.png", pixels), MaskTable(), MASK.shape)


def test_a_mask_must_be_a_png_without_palette(tmp_path):
    jpeg = saved(tmp_path / "a.jpg", MASK)
    assert "not a PNG" in refused(read_mask, jpeg, MaskTable(), MASK.shape)
    palette = empty_png(tmp_path / "a.png", 60, 40, colour=3)
    assert "palette" in refused(read_mask, palette, MaskTable(), MASK.shape)


def test_a_truncated_mask_is_refused(tmp_path):
    path = saved(tmp_path / "a.png", MASK)
    path.write_bytes(path.read_bytes()[:-20])
    assert "truncated" in refused(read_mask, path, MaskTable(), MASK.shape)


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"marking": [256]}, "marking = 256: allowed 0 to 255"),
        ({"marking": [0]}, "ground = 0 is a marking too"),
        ({"marking": [1], "ground": [1, 2]}, "ground = 1 is a marking too"),
        ({"ground": [0.5]}, "not a whole number"),
        ({"road": [3]}, "unknown field road"),
    ],
)
def test_a_wrong_table_is_told(table, told):
    assert told in refused(lambda _: structure(MaskTable, table, "job.toml"), "job.toml")
