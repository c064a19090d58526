"""Free ground, judged: on pictures whose figures can be counted on one's fingers, and the outlines that are kept."""

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from pavemark.accuracy.ground import Outline, Outlined, Truth, compare, truth
from pavemark.errors import InputError
from pavemark.records import from_json

GROUND = Path(__file__).parents[1] / "ground"
FILES = sorted(GROUND.glob("*.json"))


def box(what, left, top, right, bottom):
    return Outline(what, ((left, top), (right, top), (right, bottom), (left, bottom)))


def scene(*outlines):
    return Outlined("a.jpg", 10, 8, 20.0, outlines)


def test_outlines_are_masks_of_the_pixels_whose_centres_they_hold():
    known = truth(scene(box("car", 2, 1, 5, 4), box("ego", 7.4, 0, 10, 8), box("unsure", 4, 3, 6.5, 5)))
    assert known.ego[:, 7:].all() and not known.ego[:, :7].any()
    assert not known.ground[1:4, 2:5].any() and not known.ground[:, 7:].any()
    assert known.ground.sum() == 80 - 9 - 24
    # What is sure wins; the pixel 6, whose centre is on the border, is not in it.
    unjudged = ~known.judged
    assert unjudged.sum() == 2 * 2 - 1
    assert unjudged[3, 5] and unjudged[4, 4] and unjudged[4, 5] and not unjudged[3, 4]


def test_a_polygon_that_crosses_itself_is_filled_where_it_has_an_inside():
    bow = Outline("post", ((0, 0), (4, 4), (4, 0), (0, 4)))
    known = truth(scene(bow))
    assert not known.ground[1, 3] and not known.ground[2, 0] and known.ground[6, 6]


def test_figures_are_shares_that_can_be_counted():
    known = truth(scene(box("car", 0, 0, 5, 4), box("ego", 8, 0, 10, 8), box("unsure", 5, 6, 8, 8)))
    assert compare(known.ground, known).ground == compare(known.ground, known).things == 1
    found = np.ones((8, 10), bool)
    found[:, 8:] = False
    found[0, 0] = False  # a pixel of the car is found
    found[7, :5] = False  # five of ground are lost
    found[7, 6] = False  # nobody judges that
    over = compare(found, known)
    ground, car = 80 - 20 - 16 - 6, 20
    assert over.ground == over.beside_ego == pytest.approx((ground - 5) / (ground + car - 1))
    assert over.things == pytest.approx(1 / (20 + 5))
    assert over.painted == pytest.approx(19 / 20)
    assert over.lost == pytest.approx(5 / ground)
    everything = compare(np.ones((8, 10), bool), known)
    assert everything.ground == pytest.approx(ground / (ground + car + 16))
    assert everything.beside_ego == pytest.approx(ground / (ground + car))


def test_bare_ground_has_no_things_to_be_found():
    bare = Truth(np.ones((4, 4), bool), np.zeros((4, 4), bool), np.ones((4, 4), bool))
    over = compare(np.ones((4, 4), bool), bare)
    assert over.ground == 1 and over.lost == 0
    assert math.isnan(over.things) and math.isnan(over.painted)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_outlines_that_are_kept_can_be_read(path):
    outlined = from_json(Outlined, path)
    assert Path(outlined.image).stem == path.stem
    for outline in outlined.outlines:
        points = np.array(outline.polygon)
        assert len(points) >= 3
        assert (points >= 0).all() and (points <= (outlined.width, outlined.height)).all()
    known = truth(outlined)
    assert 0.2 < known.ground.mean() < 1
    assert known.judged.mean() > 0.7
    # Drawn anew by other code: within a pixel of the outlines it may differ.
    drawn = np.ones_like(known.ground, np.uint8)
    edges = np.zeros_like(drawn)
    for item in json.loads(path.read_text())["outlines"]:
        polygon = np.rint(np.array(item["polygon"]) * 16 - 8).astype(int)
        if item["what"] != "unsure":
            cv2.fillPoly(drawn, [polygon], 0, shift=4)
            cv2.polylines(edges, [polygon], True, 1, 3, shift=4)
    assert np.array_equal(drawn[edges == 0] > 0, known.ground[edges == 0])


def test_all_places_and_both_sizes_are_there():
    images = [from_json(Outlined, path) for path in FILES]
    halves = [image for image in images if image.image.startswith("halfview/")]
    assert len(halves) >= 20 and len(images) - len(halves) == 13
    assert {(image.width, image.height) for image in halves} == {(96, 300), (192, 600)}
    assert len({"_".join(Path(image.image).stem.split("_")[:-2]) for image in halves}) == 9


def test_a_thing_nobody_knows_is_told(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(
        '{"image": "a", "width": 9, "height": 9, "scale": 20, "outlines": [{"what": "cow", "polygon": [[0, 0]]}]}'
    )
    with pytest.raises(InputError, match="cow"):
        from_json(Outlined, path)
