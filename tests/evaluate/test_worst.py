"""The worst images come first, and each colour is where what it stands for lies."""

import cv2
import numpy as np
from labelled import dataset, detection, example

from pavemark.detect.reading import examples
from pavemark.evaluate.found import found
from pavemark.evaluate.judge import of_detections
from pavemark.evaluate.worst import FALSE, HIT, MISSED, TRUE, Mistakes, worst
from pavemark.ground import Frame

BOTH = {"points": 0.5, "slots": 0.5}


def test_most_mistakes_in_slots_first_then_in_points_then_by_name():
    truth = [(20, 20), (20, 60)]
    right = detection(truth, [0.9, 0.9], [(0, 1)], [0.9])
    unpaired = detection(truth, [0.9, 0.9])
    nothing = detection([], [])
    twice = detection(truth, [0.9, 0.9], [(0, 1), (0, 1), (1, 0)], [0.9, 0.9, 0.9])
    # Found, but with too little confidence.
    unsure = detection(truth, [0.9, 0.9], [(0, 1)], [0.4])
    said = {"d": right, "c": unpaired, "b": nothing, "e": twice, "a": unsure, "f": nothing}
    judged = of_detections([example(name, truth, [(0, 1)]) for name in said], said.values())
    assert worst(judged, BOTH, 10) == ["e", "b", "f", "a", "c"]
    assert worst(judged, BOTH, 2) == ["e", "b"]


def test_points_count_where_slots_are_not_labelled():
    images = [example(name, [(20, 20)], points_alone=True) for name in "ab"]
    judged = of_detections(images, [detection([(20, 20)], [0.9]), detection([], [])])
    assert worst(judged, {"points": 0.5}, 5) == ["b"]


def test_a_picture_eight_pixels_wide(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), np.full((40, 8, 3), 90, np.uint8))
    truth = example("a", [(0, 0), (8, 40)], [(0, 1)], Frame(8, 40, 8.0), tmp_path / "a.png")
    strip = Mistakes(truth, found(detection([(0, 0), (1.5, 0)], [0.9, 0.8], [(1, 0)], [0.9])), BOTH)
    plain, drawn = strip.tiles(4.0)
    assert plain.shape == drawn.shape == (160, 32, 3) and strip.title == "a: 1 false, 1 missed"
    assert near(drawn, (16, 80), MISSED)


def near(tile, place, colour, reach=3):
    """Whether some pixel close to a place has a colour."""
    u, v = (int(value) for value in place)
    part = tile[max(0, v - reach) : v + reach + 1, max(0, u - reach) : u + reach + 1].astype(int)
    return bool((np.abs(part - colour).max(-1) < 60).any())


def test_what_is_there_and_what_was_found_are_drawn_where_they_lie(tmp_path):
    dataset(tmp_path, [(60, [(20, 20), (60, 20), (20, 70), (60, 70)], [(0, 1), (2, 3)])])
    (one,) = examples(tmp_path)
    said = detection(
        [(20, 25), (60, 25), (100, 20), (100, 70), (110, 10)],
        [0.9, 0.9, 0.9, 0.9, 0.3],
        [(0, 1), (2, 3), (3, 4)],
        [0.9, 0.8, 0.2],
    )
    strip = Mistakes(one, found(said), BOTH)
    assert strip.title == "images/000000: 1 false, 1 missed" and strip.size == (120, 90)
    for scale in (1.0, 2.0, 0.5):
        plain, drawn = strip.tiles(scale)
        assert plain.shape == drawn.shape == (90 * scale, 120 * scale, 3)
        assert np.ptp(plain) == 0
    _, drawn = strip.tiles(2.0)
    middles = {(40, 20): TRUE, (40, 25): HIT, (100, 45): FALSE, (40, 70): MISSED}
    for (u, v), colour in middles.items():
        for other in (TRUE, HIT, FALSE, MISSED):
            assert near(drawn, (2 * u, 2 * v), other) == (other == colour)
    # What is below the threshold is not drawn.
    assert not near(drawn, (210, 80), FALSE, 4)


def test_a_ring_lies_around_its_point(tmp_path):
    dataset(tmp_path, [(0, [(50.25, 30.75)], [])])
    (one,) = examples(tmp_path)
    for scale in (1.0, 2.0, 4.0):
        _, drawn = Mistakes(one, found(detection([], [])), BOTH).tiles(scale)
        weight = drawn[..., 0].astype(float)
        rows, columns = np.indices(weight.shape) + 0.5
        centre = [(weight * along).sum() / weight.sum() for along in (columns, rows)]
        np.testing.assert_allclose(centre, [50.25 * scale, 30.75 * scale], atol=0.1)
