"""Datasets are read as they were written, and a broken one is refused in a line that names the file."""

import json
import os

import numpy as np
import pytest
from datasets import listed, made, picture

from pavemark.detect import reading
from pavemark.errors import InputError

PLACE = {"place": "p", "scene": "Open", "side": "L"}
LINE = {"image": "images/a.png", "w": 96, "h": 300, "points": [[25.0, 157.5]], **PLACE}


def test_a_dataset_of_ours(tmp_path):
    found = list(reading.examples(made(tmp_path, curvature={"alpha": 1})))
    assert [example.name for example in found] == ["images/000000", "images/000001", "images/000002"]
    last = found[2]
    # DMPR counts from the centre of the first pixel, which is 1; here it is at 0.5.
    np.testing.assert_allclose(last.points, [[10.5, 22.0], [10.5, 62.0]])
    np.testing.assert_allclose(last.directions, [[1, 0], [1, 0]])
    assert last.l_shaped.tolist() == [True, False]
    assert last.slots.tolist() == [[0, 1]]
    assert (last.frame.width, last.frame.height, last.frame.scale) == (48, 96, 22.7)
    assert last.groups == {"plate": "plate0.png", "domain": "curvature", "kind": "parallel"}
    assert reading.picture(last)[5, 5].tolist() == [62, 62, 62]
    assert reading.count(tmp_path) == 3


def test_an_image_without_marks(tmp_path):
    made(tmp_path, 1)
    (tmp_path / "labels/dmpr/000000.json").write_text('{"marks": [], "slots": []}')
    (example,) = reading.examples(tmp_path)
    assert example.points.shape == (0, 2) and example.slots.shape == (0, 2) and example.directions.shape == (0, 2)


def test_a_selection_reads_the_images_of_its_dataset(tmp_path):
    made(tmp_path / "all")
    kept = (tmp_path / "all" / "manifest.jsonl").read_text().splitlines()[1]
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "manifest.jsonl").write_text(kept + "\n")
    (tmp_path / "kept" / "selection.json").write_text('{"dataset": "../all"}')
    (example,) = reading.examples(tmp_path / "kept")
    assert example.name == "images/000001" and reading.picture(example)[0, 0, 0] == 61


def test_a_list_of_points(tmp_path):
    (example,) = reading.examples(listed(tmp_path, LINE), height=15.0)
    assert example.name == "images/a" and example.frame.scale == 20.0
    assert example.points.tolist() == [[25.0, 157.5]]
    assert example.directions is None and example.l_shaped is None and example.slots is None
    assert example.groups == PLACE
    (told,) = reading.examples(listed(tmp_path, LINE | {"scale": 7.0}), height=15.0)
    assert told.frame.scale == 7.0
    (of_none,) = reading.examples(listed(tmp_path, LINE | {"place": None}), height=15.0)
    assert "place" not in of_none.groups


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ({"image": 3}, "image = 3"),
        ({"w": "96"}, "w = '96'"),
        ({"h": True}, "h = True"),
        ({"w": 3}, "width"),
        ({"scale": "x"}, "scale"),
        ({"scale": True}, "scale = True"),
        ({"image": ""}, "image = ''"),
        ({"place": ["a"]}, r"place = \['a'\]"),
        ({"points": [[1]]}, "points: a list of"),
        ({"points": [[1, 2, 3], [4, 5, 6]]}, "points: a list of"),
        ({"points": [[1, "x"]]}, "points: a list of"),
        ({"points": [[float("nan"), 1]]}, "finite"),
        ({"points": [[97, 1]]}, r"\(97, 1\)"),
    ],
)
def test_a_line_that_is_wrong(tmp_path, line, said):
    listed(tmp_path, LINE)
    text = json.dumps(LINE) + "\n" + json.dumps(LINE | line) + "\n"
    (tmp_path / "labels.jsonl").write_text(text)
    with pytest.raises(InputError, match=rf"labels.jsonl:2: .*{said}"):
        list(reading.examples(tmp_path, height=13.2))


def test_a_list_with_a_byte_order_mark(tmp_path):
    listed(tmp_path, LINE)
    (tmp_path / "labels.jsonl").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "labels.jsonl").read_bytes())
    (example,) = reading.examples(tmp_path, height=15.0)
    assert example.name == "images/a" and reading.count(tmp_path) == 1


def test_the_list_that_is_counted_is_the_one_that_is_read(tmp_path):
    listed(tmp_path / "real", LINE, LINE | {"image": "b.png"})
    (tmp_path / "real" / "manifest.jsonl").write_text('{"somebody": "else\'s"}\n')
    assert reading.count(tmp_path / "real") == len(list(reading.examples(tmp_path / "real", 15.0))) == 2
    made(tmp_path / "stopped")
    (tmp_path / "stopped" / "manifest.jsonl").unlink()
    with pytest.raises(InputError, match=r"manifest.jsonl: cannot be read"):
        reading.count(tmp_path / "stopped")


def test_a_list_without_a_scale(tmp_path):
    with pytest.raises(InputError, match=r"labels.jsonl:1: has no scale"):
        list(reading.examples(listed(tmp_path, LINE)))


@pytest.mark.parametrize(
    ("labels", "said"),
    [
        ("[]", "marks and slots"),
        ('{"marks": [[1, 2, 3]], "slots": []}', "marks and slots"),
        ('{"marks": [[1, 2], [1, 2], [1, 2], [1, 2], [1, 2]], "slots": []}', "marks and slots"),
        ('{"marks": [[1, 2, 1, 2, 0]], "slots": []}', "direction"),
        ('{"marks": [[NaN, 2, 1, 3, 0]], "slots": []}', "finite"),
        ('{"marks": [[1, 2, 1, 3, 0]], "slots": [[1, 2, 1, 90]]}', "two different marks, 1 to 1"),
        ('{"marks": [[1, 2, 1, 3, 0], [5, 2, 5, 3, 0]], "slots": [[1, 1, 1, 90]]}', "two different marks"),
        ("{", "JSON"),
    ],
)
def test_labels_that_are_wrong(tmp_path, labels, said):
    made(tmp_path)
    (tmp_path / "labels/dmpr/000001.json").write_text(labels)
    with pytest.raises(InputError, match=rf"000001.json: .*{said}"):
        list(reading.examples(tmp_path))


def test_datasets_that_are_none(tmp_path):
    with pytest.raises(InputError, match="is no folder"):
        list(reading.examples(tmp_path / "nowhere"))
    with pytest.raises(InputError, match=r"no job.json"):
        list(reading.examples(tmp_path))
    made(tmp_path)
    (tmp_path / "job.json").write_text('{"count": 3, "formats": ["yolo"]}')
    with pytest.raises(InputError, match=r'\[\'yolo\'\]: "dmpr" among them'):
        list(reading.examples(tmp_path))
    made(tmp_path)
    (tmp_path / "manifest.jsonl").write_text("\n")
    with pytest.raises(InputError, match="holds no image"):
        list(reading.examples(tmp_path))
    for files in ("{}", '{"images/../a.png": ""}', '{"images/a.png": "", "images/b.png": ""}'):
        (tmp_path / "manifest.jsonl").write_text(f'{{"files": {files}}}\n')
        with pytest.raises(InputError, match=r"manifest.jsonl:1: files: exactly one image"):
            list(reading.examples(tmp_path))
    for line in ('{"files": null}', '{"files": 3}', '{"files": ["images/a.png"]}', "{}"):
        (tmp_path / "manifest.jsonl").write_text(line + "\n")
        with pytest.raises(InputError, match=r"manifest.jsonl:1: files: a table of names"):
            list(reading.examples(tmp_path))
    (tmp_path / "manifest.jsonl").write_text('{"index": 0\n')
    with pytest.raises(InputError, match=r"manifest.jsonl:1: is no JSON record"):
        list(reading.examples(tmp_path))


def test_labels_that_lack(tmp_path):
    made(tmp_path)
    (tmp_path / "labels/dmpr/000002.json").unlink()
    with pytest.raises(InputError, match=r"000002.json: cannot be read"):
        list(reading.examples(tmp_path))


def test_a_picture_of_another_size(tmp_path):
    example = next(reading.examples(made(tmp_path)))
    picture(example.image, (48, 95))
    with pytest.raises(InputError, match=r"is 48×95 px: 48×96"):
        reading.picture(example)


def test_nothing_is_read_ahead(tmp_path):
    made(tmp_path)
    with (tmp_path / "manifest.jsonl").open("a") as file:
        file.write("broken\n")
    stream = reading.examples(tmp_path)
    assert [next(stream).name for _ in range(3)][-1] == "images/000002"
    with pytest.raises(InputError, match=r"manifest.jsonl:4"):
        next(stream)


def test_a_point_outside_its_picture(tmp_path):
    made(tmp_path)
    (tmp_path / "labels/dmpr/000001.json").write_text('{"marks": [[48.6, 2, 1, 3, 0]], "slots": []}')
    first, second, _ = reading.examples(tmp_path)
    reading.hold_labelled(first)
    with pytest.raises(InputError, match=r"labels of .*000001.png: \(48.1, 1.5\): within the picture of 48×96"):
        reading.hold_labelled(second)


def test_markings_painted_anew_have_no_labels(tmp_path):
    made(tmp_path)
    scene = {"plate": {"name": "p", "frame": {"width": 48, "height": 96}}, "markings": [{"kind": "original"}]}
    (tmp_path / "scenes/000001.json").write_text(json.dumps(scene))
    first, second, third = reading.examples(tmp_path)
    assert first.known and third.known and not second.known
    reading.hold_labelled(first)
    with pytest.raises(InputError, match=r"000001.png: shows its plate's own markings painted anew"):
        reading.hold_labelled(second)


def test_many_are_read_in_their_order(tmp_path):
    made(tmp_path, 3 * reading.AT_A_TIME)
    found = [example.name for example in reading.examples(tmp_path)]
    assert found == [f"images/{k:06d}" for k in range(3 * reading.AT_A_TIME)]


def test_pictures_that_two_datasets_share(tmp_path):
    """A link is the same picture under another name; a copy is not known to be."""
    one, other = made(tmp_path / "one"), made(tmp_path / "other")
    of_both = [reading.of_both(reading.examples(one), reading.examples(folder)) for folder in (one, other)]
    assert [len(list(found)) for found in of_both] == [3, 0]
    for name, link in (("000000", os.symlink), ("000002", os.link)):
        (other / "images" / f"{name}.png").unlink()
        link(one / "images" / f"{name}.png", other / "images" / f"{name}.png")
    (other / "images/000001.png").unlink()
    found = reading.of_both(reading.examples(other), reading.examples(one))
    assert [example.image for example in found] == [other / "images" / f"{name}.png" for name in ("000000", "000002")]
