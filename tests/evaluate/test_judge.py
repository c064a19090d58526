"""A detector is judged picture by picture, and what is no detection is refused with the image and the model."""

import math
import tracemalloc

import attrs
import numpy as np
import pytest
from labelled import Said, dataset, detection, example

from pavemark.detect.reading import examples
from pavemark.errors import InputError
from pavemark.evaluate.curve import rates
from pavemark.evaluate.found import found
from pavemark.evaluate.judge import judged, judged_together, of_detections, of_found, of_votes
from pavemark.evaluate.results import plain, result
from pavemark.ground import Frame

POINTS = [(20, 20), (20, 60), (80, 40)]
SLOTS = [(0, 1)]
GOOD = detection([(21, 20), (20, 61), (100, 80)], [0.9, 0.8, 0.3], [(0, 1), (1, 2)], [0.7, 0.4])
NOTHING = detection([], [])


def test_points_and_slots_of_a_dataset(tmp_path):
    dataset(tmp_path, [(60, POINTS, SLOTS), (70, POINTS, SLOTS), (80, [], [])])
    said = Said({60: GOOD, 70: NOTHING, 80: GOOD})
    got = judged(said, examples(tmp_path))
    assert got.names == ("images/000000", "images/000001", "images/000002")
    assert [each["plate"] for each in got.groups] == ["even.png", "odd.png", "even.png"]
    assert got.points.truths.tolist() == [3, 3, 0] and got.slots.truths.tolist() == [1, 1, 0]
    points, slots = rates(got.points, 0.5), rates(got.slots, 0.5)
    assert (points.hits, points.false_positives, points.misses) == (2, 2, 4)
    assert (slots.hits, slots.false_positives, slots.misses) == (1, 1, 1)
    assert [(tone, shape) for tone, shape, _ in said.seen] == [(tone, (90, 120, 3)) for tone in (60, 70, 80)]


def test_points_alone(tmp_path):
    dataset(tmp_path, [(60, POINTS, []), (70, [], [])], points_alone=True)
    got = judged(Said({60: GOOD, 70: GOOD}), examples(tmp_path))
    assert got.slots is None and list(got.kinds) == ["points"]
    at = rates(got.points, 0.5)
    assert (at.hits, at.false_positives, at.misses) == (2, 2, 1)
    assert list(got.by("place")) == ["even", "odd"]


def test_detections_found_before_are_judged_the_same(tmp_path):
    dataset(tmp_path, [(60, POINTS, SLOTS), (70, POINTS, SLOTS)])
    one = judged(Said({60: GOOD, 70: NOTHING}), examples(tmp_path))
    other = of_detections(examples(tmp_path), [GOOD, NOTHING])
    for kind, tally in one.kinds.items():
        for name, values in attrs.asdict(tally).items():
            np.testing.assert_array_equal(values, getattr(other.kinds[kind], name))
    with pytest.raises(ValueError, match="shorter"):
        of_detections(examples(tmp_path), [GOOD])


def test_a_slot_is_right_by_both_ends_and_their_order():
    truth = example("a", POINTS, SLOTS)
    turned = detection(POINTS, [0.9] * 3, [(1, 0)], [0.9])
    assert rates(of_detections([truth], [turned]).slots, 0.5).hits == 0
    far = detection([(28, 20), (28, 60)], [0.9] * 2, [(0, 1)], [0.9])
    got = of_detections([truth], [far])
    # 8 px at each end: each point is right, and 11.3 px together are too far.
    assert rates(got.points, 0.5).hits == 2 and rates(got.slots, 0.5).hits == 0
    assert rates(of_detections([truth], [far], 12.0).slots, 0.5).hits == 1


def test_the_tolerance_goes_with_the_scale_of_each_image():
    near = detection([(26, 20)], [0.9])
    fine, coarse = (example(f"{scale}", [(20, 20)], frame=Frame(120, 90, scale)) for scale in (60.0, 30.0))
    assert of_detections([fine, coarse], [near, near]).points.hit.tolist() == [True, False]


def test_several_together(tmp_path):
    dataset(tmp_path, [(60, POINTS, SLOTS)])
    slot = detection([(20, 20), (20, 60)], [0.9, 0.9], [(0, 1)], [0.8])
    three = [Said({60: GOOD}), Said({60: slot}), Said({60: NOTHING})]
    hits = {
        vote: (rates(got.slots, 0.1).hits, rates(got.slots, 0.1).false_positives)
        for vote in ("affirmative", "unanimous", "consensus")
        for got in [judged_together(three, examples(tmp_path), vote)]
    }
    assert hits == {"affirmative": (1, 1), "unanimous": (0, 0), "consensus": (1, 0)}
    for vote, wanted in hits.items():
        before = of_votes(examples(tmp_path), [[NOTHING, GOOD, slot]], vote)
        assert (rates(before.slots, 0.1).hits, rates(before.slots, 0.1).false_positives) == wanted


def test_votes_agree_within_as_many_metres_at_every_scale():
    one, other = detection([(20, 20)], [0.9]), detection([(28, 20)], [0.9])
    for scale, found_together in ((60.0, 1), (30.0, 0)):
        image = example("a", [(24, 20)], frame=Frame(120, 90, scale))
        assert len(of_votes([image], [[one, other]], "unanimous").points.confidence) == found_together


BAD = {
    "points": (np.zeros((2, 3)), r"points has the shape \[2, 3\]: \[2, 2\] is allowed"),
    "confidence": (np.zeros(2), r"confidence has the shape \[2\]: \[3\] is allowed"),
    "directions": (np.full((3, 2), np.nan), "directions holds nan: finite numbers are allowed"),
    "l_shaped": (np.array([0, np.inf, 0]), "l_shaped holds inf: finite numbers are allowed"),
    "slots": (np.array([[0, 3], [1, 2]]), r"slots holds \(0, 3\): two of 3 points are allowed"),
    "slot_confidence": (np.array([0.5, 1.5]), r"slot_confidence holds 1\.5: 0 to 1 is allowed"),
}


@pytest.mark.parametrize(
    ("field", "values", "told"),
    [(field, *case) for field, case in BAD.items()]
    + [
        ("points", np.array([[1.0, 2], [3, 4], [5, np.nan]]), "points holds nan"),
        ("points", np.zeros(3), r"points has the shape \[3\]"),
        ("confidence", np.array([0.5, -0.1, 0.5]), r"confidence holds -0\.1"),
        ("slots", np.array([[0, 0], [1, 2]]), r"slots holds \(0, 0\)"),
        ("slots", np.array([[0, -1], [1, 2]]), r"slots holds \(0, -1\)"),
        ("slots", np.array([[0, 1.0], [1, 2]]), "slots is of float64: whole numbers are allowed"),
        ("slots", np.array([[0, 1, 2], [1, 2, 0]]), r"slots has the shape \[2, 3\]"),
    ],
)
def test_what_is_no_detection_is_refused_with_image_and_model(tmp_path, field, values, told):
    dataset(tmp_path, [(60, POINTS, SLOTS), (70, POINTS, SLOTS)])
    said = Said({60: GOOD, 70: attrs.evolve(GOOD, **{field: values})})
    with pytest.raises(InputError, match=rf"000001\.png: said 0123456789ab: {told}"):
        judged(said, examples(tmp_path))


def test_a_model_that_fails_is_told_with_the_image(tmp_path):
    class Fails(Said):
        def detect(self, image, frame):
            raise InputError("m.onnx", "grid holds values that are no finite numbers")

    dataset(tmp_path, [(60, POINTS, SLOTS)])
    with pytest.raises(InputError, match=r"000000\.png: m\.onnx: grid holds"):
        judged(Fails({}), examples(tmp_path))


def test_a_damaged_picture_is_told(tmp_path):
    dataset(tmp_path, [(60, POINTS, SLOTS)])
    path = tmp_path / "images/000000.png"
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(InputError, match=r"000000\.png"):
        judged(Said({60: GOOD}), examples(tmp_path))


def test_no_image_a_name_twice_and_labels_of_two_kinds():
    with pytest.raises(InputError, match="at least one is needed"):
        of_found([])
    once = example("a", POINTS, SLOTS), found(GOOD)
    with pytest.raises(InputError, match="a: is in the set twice"):
        of_found([once, once])
    alone = example("b", POINTS, points_alone=True), found(GOOD)
    with pytest.raises(InputError, match="b: has no slots labelled"):
        of_found([once, alone])
    with pytest.raises(InputError, match="a: has slots labelled, which images before it have not"):
        of_found([alone, once])


def test_groups_share_out_what_was_found():
    places = ["x", "y", "x", None]
    images = [example(f"{k}", POINTS, SLOTS, **({"place": name} if name else {})) for k, name in enumerate(places)]
    whole = of_detections(images, [GOOD, NOTHING, NOTHING, GOOD])
    parts = whole.by("place")
    assert {name: part.names for name, part in parts.items()} == {"": ("3",), "x": ("0", "2"), "y": ("1",)}
    at = {name: rates(part.slots, 0.1) for name, part in parts.items()}
    told = {name: (each.hits, each.false_positives, each.misses) for name, each in at.items()}
    assert told == {"": (1, 1, 0), "x": (1, 1, 1), "y": (0, 0, 1)}
    false, missed = parts["x"].slots.mistakes(0.1)
    assert (false.tolist(), missed.tolist()) == ([1, 0], [0, 1])
    assert whole.clusters("place") == [(True, "x"), (True, "y"), (True, "x"), (False, "3")]
    assert len(set(whole.clusters())) == 4


def test_a_result_says_none_where_there_is_no_number():
    alone = of_detections([example("a", [])], [NOTHING])
    told = plain(result(alone.slots, 0.5, alone.clusters()))
    assert told["precision"] is None and told["recall"] is None and told["average_precision"] is None
    assert told["truths"] == 0 and told["intervals"]["precision"] is None


def test_pictures_are_looked_at_one_by_one_and_not_kept():
    """40,000 images: what is kept is what was found, some hundred bytes an image, and no detection or example."""
    count = 4000

    def pairs():
        for k in range(count):
            yield example(f"{k}", POINTS, SLOTS, place="p"), found(GOOD)

    tracemalloc.start()
    got = of_found(pairs())
    kept, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 3000 * count
    assert rates(got.slots, 0.5).hits == count and math.isclose(rates(got.points, 0.5).recall, 2 / 3)
    del kept
