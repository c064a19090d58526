"""Nothing of a validation or test place is learned from: no image, and no plate."""

import json
import shutil

import attrs
import cv2
import numpy as np
import pytest
from real import STUDY, study

from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.labels.truth import truth
from pavemark.records import to_json
from pavemark.scene import Area, Blend, Curvature, Marking, Paint, PlateRef, Scene, Slot
from pavemark.study import pools
from pavemark.study.leakage import hold_apart
from pavemark.study.places import name, share, split, write_views
from pavemark.study.rows import Data, real


def _pool(folder, *plates):
    """A dataset of one slot an image, on these plates."""
    for kind in ("images", "scenes", "labels/dmpr"):
        (folder / kind).mkdir(parents=True)
    (folder / "job.json").write_text('{"count": 1, "formats": ["dmpr"]}')
    lines = []
    for number, plate in enumerate(plates):
        scene = Scene(number, PlateRef(plate, "0" * 64, Frame(48, 64, 10.0)))
        (folder / "scenes" / f"{number:06d}.json").write_text(to_json(scene))
        (folder / "labels" / "dmpr" / f"{number:06d}.json").write_text('{"marks": [[3, 4, 3, 54, 1]], "slots": []}')
        lines.append(json.dumps({"input": f"{plate}.png", "files": {f"images/{number:06d}.png": ""}}) + "\n")
    (folder / "manifest.jsonl").write_text("".join(lines))
    return folder


def test_each_place_is_in_its_part(tmp_path):
    parts = split(study(tmp_path))
    assert {part: {each.groups["place"] for each in found} for part, found in parts.items()} == {
        "train": {"north"},
        "validation": {"south"},
        "test": {"east"},
    }
    assert [len(found) for found in parts.values()] == [4, 1, 2]


def test_a_place_without_images(tmp_path):
    with pytest.raises(InputError, match="place 'west' has no image: allowed east, north, south"):
        split(study(tmp_path, STUDY.replace('["east"]', '["west"]')))


def test_a_picture_of_two_places_is_refused(tmp_path):
    hold_apart(split(study(tmp_path / "good")))
    parts = split(study(tmp_path / "bad"))
    # North is learned from, east is judged by.
    shutil.copy(parts["train"][2].image, parts["test"][1].image)
    with pytest.raises(InputError, match=r"east_6.png: is of test, and the same picture as .*north_2.png, of train"):
        hold_apart(parts)


def test_a_plate_of_a_test_place_is_refused(tmp_path):
    parts = split(study(tmp_path))
    pool = _pool(tmp_path / "pool", "north_0", "east_5")
    with pytest.raises(InputError, match=r"images/000001: its plate, east_5, is of no train place"):
        pools.learnt_from(pool, parts["train"])


def test_a_plate_of_a_train_place_is_named_with_its_place(tmp_path):
    parts = split(study(tmp_path))
    (found,) = pools.learnt_from(_pool(tmp_path / "pool", "north_0"), parts["train"])
    assert found.name == "pool/images/000000"
    assert found.groups["place"] == "north" and found.points.tolist() == [[2.5, 3.5]]


def test_markings_painted_anew_keep_the_points_of_the_real_image(tmp_path):
    parts = split(study(tmp_path))
    pool = _pool(tmp_path / "pool", "north_1")
    # The real image has half the pixels.
    frame = Frame(96, 128, 20.0)
    paint = Paint((200.0, 200.0, 200.0), (2.0, 2.0, 2.0))
    marking = Marking("original", paint, areas=(Area(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),))
    scene = Scene(0, PlateRef("north_1", "0" * 64, frame), markings=(marking,), blend=Blend())
    path = pool / "scenes" / "000000.json"
    path.write_text(to_json(scene))
    (found,) = pools.learnt_from(pool, parts["train"])
    np.testing.assert_allclose(found.points, [[23.0, 63.0]])
    assert found.directions is None and found.slots is None

    curvature = Curvature(150.0, 0.5, 3)
    path.write_text(to_json(attrs.evolve(scene, curvature=curvature)))
    (bent,) = pools.learnt_from(pool, parts["train"])
    # The paint of that place is moved alike, as the labels of a slot there would say.
    corners = tuple(
        map(tuple, frame.to_world(np.array([[23.0, 63.0], [60.0, 63.0], [60.0, 30.0], [23.0, 30.0]])).tolist())
    )
    slot = Slot(tuple(map(tuple, corners)), "perpendicular", ("T", "T"), "closed")
    there = truth(attrs.evolve(scene, curvature=curvature, slots=(slot,)), np.ones((128, 96), bool)).marks[0].point
    np.testing.assert_allclose(bent.points[0], there)
    assert np.abs(bent.points - found.points).max() > 0.2


def test_views_are_of_the_train_places_alone(tmp_path):
    found = study(tmp_path)
    parts = split(found)
    write_views(parts["train"], (24, 32), tmp_path / "views")
    assert sorted(path.stem for path in (tmp_path / "views").iterdir()) == ["north_0", "north_1", "north_2", "north_3"]
    assert cv2.imread(str(tmp_path / "views" / "north_0.png")).shape == (32, 24, 3)


def test_what_plates_were_made_of_stays(tmp_path):
    """Pools may be painted on them: another picture, or another size, is for another folder."""
    train, views = split(study(tmp_path))["train"], tmp_path / "views"
    write_views(train, (24, 32), views)
    write_views(train, (24, 32), views)
    with pytest.raises(InputError, match=r"north_0.png: shows another picture than .* in this size"):
        write_views(train, (12, 16), views)
    cv2.imwrite(str(train[1].image), 255 - cv2.imread(str(train[1].image)))
    with pytest.raises(InputError, match=r"north_1.png: shows another picture"):
        write_views(train, (24, 32), views)


def test_a_frame_of_another_shape_would_squeeze_the_ground(tmp_path):
    train = split(study(tmp_path))["train"]
    with pytest.raises(InputError, match=r"frame: \[64, 48\]: .*north_0.png is 48×64 px: a frame of its shape"):
        write_views(train, (64, 48), tmp_path / "views")
    write_views(train, (19, 25), tmp_path / "views")  # rounded


def test_two_real_images_of_one_name(tmp_path):
    parts = split(study(tmp_path))
    with pytest.raises(InputError, match="has the name of another image"):
        write_views([parts["train"][0]] * 2, (24, 32), tmp_path / "views")


def test_a_share_of_the_real_images(tmp_path):
    found = study(tmp_path)
    data = Data(tuple(split(found)["train"]), {})
    half = real(attrs.evolve(found.rows[0], real=0.5), data, seed=3)
    assert len(half) == 2
    assert {name(each) for each in half} <= {name(each) for each in real(found.rows[0], data, seed=3)}
    assert [name(each) for each in share(data.real, 0.5, 3)] == [name(each) for each in half]
    others = {tuple(map(name, share(data.real, 0.5, seed))) for seed in range(20)}
    assert len(others) > 1
