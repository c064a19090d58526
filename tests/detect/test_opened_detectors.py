"""A trained detector's file is opened when it is one, and what it says is read as it is meant."""

import numpy as np
import pytest
from graphs import graph, painted
from onnx import TensorProto, helper

from pavemark.detect.learned import LEAST, opened
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.select.point_loss import point_loss


def frame(width, height, scale=20.0):
    return Frame(width, height, scale)


def test_points_lie_where_their_cells_say(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx", l_shaped=0.75))
    image = painted((96, 48), {(0, 1): (0.4, 0.2, 1.0), (2, 4): (0.8, 0.6, 0.4)})
    found = detector.detect(image, frame(96, 48))
    np.testing.assert_allclose(found.points, [[(4 + 0.6) * 16, (2 + 0.4) * 16], [(1 + 0.2) * 16, 16]], atol=1e-4)
    np.testing.assert_allclose(found.confidence, [0.8, 0.4], atol=1e-5)
    np.testing.assert_allclose(found.directions, [[0, -1], [0, -1]])
    np.testing.assert_allclose(found.l_shaped, [0.75, 0.75])
    assert detector.family == "dmpr" and len(detector.version) == 64


def test_a_row_of_points_is_a_row_of_slots(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    # 3.2 m between points, at 20 pixels a metre; over the one in the middle it is 6.4 m, as to a long side.
    image = painted((240, 48), {(1, 1): (1.0, 0.6, 0.6), (1, 5): (0.8, 0.6, 0.6), (1, 9): (0.6, 0.6, 0.6)})
    found = detector.detect(image, frame(240, 48))
    assert found.slots.tolist() == [[0, 1], [1, 2], [0, 2]]
    np.testing.assert_allclose(found.slot_confidence, [0.8, 0.6, 0.6 * 0.2], atol=1e-5)


def test_what_is_hardly_likely_is_not_told(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    found = detector.detect(painted((32, 32), {(0, 0): (0.02, 0.2, 0.2), (1, 1): (0.06, 0.2, 0.2)}), frame(32, 32))
    assert len(found.points) == 1 and found.confidence[0] >= LEAST


def test_a_point_in_two_cells_is_told_once(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    found = detector.detect(painted((64, 32), {(0, 0): (0.6, 1.0, 0.4), (0, 1): (0.4, 0.2, 0.4)}), frame(64, 32))
    np.testing.assert_allclose(found.points, [[16, 6.4]], atol=1e-4)


def test_one_look_says_what_two_say(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    image = np.random.default_rng(3).integers(0, 256, (41, 90, 3), np.uint8)
    grid, embedding = detector.look(image, frame(90, 41))
    np.testing.assert_array_equal(grid, detector.grid(image, frame(90, 41)))
    np.testing.assert_array_equal(embedding, detector.embedding(image, frame(90, 41)))
    assert grid.shape == (3, 6, 3) and embedding.shape == (3,) and grid.dtype == embedding.dtype == np.float64


@pytest.mark.parametrize("size", [(90, 41), (8, 8), (8, 90), (96, 33)])
def test_any_size_is_seen_whole(tmp_path, size):
    """The border goes on to whole cells, and a point that is said to lie there is none."""
    detector = opened(graph(tmp_path / "a.onnx"))
    image = np.full((size[1], size[0], 3), (204, 0, 0), np.uint8)
    seen = detector.grid(image, frame(*size))
    assert seen.shape == (-(-size[1] // 16), -(-size[0] // 16), 3)
    np.testing.assert_allclose(seen[..., 0], 0.8, atol=1e-5)
    width, height = detector.covered(frame(*size))
    assert width == seen.shape[1] * 16 and height == seen.shape[0] * 16
    last = np.full((size[1], size[0], 3), (204, 255, 255), np.uint8)
    points = detector.detect(last, frame(*size)).points
    assert (points <= size).all()
    assert len(points) == len(points[(points % 16 == 0).all(1)])


@pytest.mark.parametrize("scale", [10.0, 40.0, 33.0])
def test_another_scale_is_brought_to_the_detectors_own(tmp_path, scale):
    detector = opened(graph(tmp_path / "a.onnx"))
    small = painted((96, 64), {(1, 3): (0.8, 0.6, 0.2)})
    times = scale / 20
    size = round(96 * times), round(64 * times)
    rows, columns = ((np.arange(n) + 0.5) / times for n in size[::-1])
    image = small[rows.astype(int)][:, columns.astype(int)]
    found = detector.detect(image, frame(*size, scale))
    np.testing.assert_allclose(found.points[0], np.array([3.6 * 16, 1.2 * 16]) * times, atol=1.2 * times)
    np.testing.assert_allclose(detector.covered(frame(*size, scale)), (96 * times, 64 * times), atol=0.6)


def test_the_same_scale_but_for_a_hundredth_is_left_alone(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    image = painted((96, 64), {(1, 3): (0.8, 0.6, 0.2)})
    one, two = (detector.detect(image, frame(96, 64, scale)) for scale in (20.0, 20.1))
    np.testing.assert_array_equal(one.points, two.points)
    assert detector.covered(frame(96, 64, 20.1)) == (96, 64)


def test_the_whole_image_is_covered(tmp_path):
    """A point on its right border is one of the last cells: 336 pixels times their width are a hair less than 102."""
    assert 336 * (102 / 336) < 102
    width, _ = opened(graph(tmp_path / "a.onnx")).covered(frame(102, 64, 20 * 102 / 336))
    assert width == 102


def test_the_grid_is_what_the_point_loss_takes(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    image = painted((90, 64), {(1, 3): (1.0, 0.6, 0.2)})
    covered = detector.covered(frame(90, 64))
    assert point_loss(np.array([[3.6 * 16, 1.2 * 16]]), covered, detector.grid(image, frame(90, 64))) < 1e-9


def test_what_an_image_looks_like(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx"))
    seen = detector.embedding(np.full((32, 32, 3), (51, 102, 153), np.uint8), frame(32, 32))
    assert seen.dtype == np.float64
    np.testing.assert_allclose(seen, [0.2, 0.4, 0.6], atol=1e-5)


def test_a_direction_of_no_length_is_still_a_unit_vector(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx", direction=(0.0, 0.0)))
    found = detector.detect(painted((32, 32), {(0, 0): (1.0, 0.2, 0.2)}), frame(32, 32))
    assert found.directions.tolist() == [[1.0, 0.0]]


POINTS = np.array([[[40.0, 20.0, 0.9], [8.0, 20.0, 0.8], [72.0, 20.0, 0.7], [73.0, 21.0, 0.6], [0.0, 0.0, 0.0]]])
PAIRS = np.zeros((1, 5, 5))
PAIRS[0, 1, 0], PAIRS[0, 0, 1] = 0.5, 0.3
PAIRS[0, 0, 2], PAIRS[0, 2, 0] = 0.95, 0.2
PAIRS[0, 0, 3] = 1.0
PAIRS[0, 2, 2] = PAIRS[0, 4, 0] = 1.0


@pytest.mark.parametrize("family", ["gcn", "deepps"])
def test_pairs_are_those_that_the_network_tells(tmp_path, family):
    detector = opened(graph(tmp_path / "a.onnx", points=POINTS, pairs=PAIRS, said={"family": family}, l_shaped=0.3))
    found = detector.detect(painted((96, 48), {}), frame(96, 48))
    # The fourth is the third once more, the fifth fills the list up.
    np.testing.assert_allclose(found.points, [[40, 20], [8, 20], [72, 20]])
    assert found.slots.tolist() == [[0, 2], [1, 0]]
    np.testing.assert_allclose(found.slot_confidence, [0.7, 0.5])
    np.testing.assert_allclose(found.l_shaped, [0.3, 0.3, 0.3])


def test_pairs_told_in_pixels_of_the_image(tmp_path):
    detector = opened(graph(tmp_path / "a.onnx", points=POINTS, pairs=PAIRS, said={"family": "gcn"}))
    found = detector.detect(painted((192, 96), {}), frame(192, 96, 40.0))
    np.testing.assert_allclose(found.points, [[80, 40], [16, 40], [144, 40]])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"said": {"pavemark": None}}, 'is not a detector: its metadata must say "pavemark" = "detector 1"'),
        ({"said": {"pavemark": "segmenter 1"}}, "is not a detector"),
        ({"said": {"family": "yolo"}}, "family = 'yolo': dmpr, gcn, deepps are allowed"),
        ({"said": {"family": None}}, "family = None"),
        ({"said": {"pixels_per_metre": "fast"}}, "pixels_per_metre = 'fast': 1 to 1000 is allowed"),
        ({"said": {"pixels_per_metre": "1e9"}}, "pixels_per_metre = '1e9': 1 to 1000 is allowed"),
        ({"said": {"stride": "1e30"}}, "stride = '1e30': 1 to 256 is allowed"),
        ({"said": {"pixels_per_metre": "inf"}}, "pixels_per_metre = 'inf'"),
        ({"said": {"pixels_per_metre": "-3"}}, "pixels_per_metre = '-3'"),
        ({"said": {"stride": None}}, "stride = None"),
        ({"said": {"stride": "0.5"}}, "stride = '0.5': 1 to 256 is allowed"),
        ({"said": {"stride": "2.5"}}, "stride = 2.5: a whole number of pixels is allowed"),
        ({"channels": 1}, "image float [?, 1, ?, ?]: image float [?, 3, ?, ?] is allowed"),
        ({"kind": TensorProto.UINT8}, "image uint8 [?, 3, ?, ?]: image float [?, 3, ?, ?] is allowed"),
        ({"renamed": ("image", "input")}, "has no image: it has input float [?, 3, ?, ?]"),
        ({"second_input": True}, "has the inputs image float [?, 3, ?, ?], mask float [1]: image alone is allowed"),
        ({"without": ("grid",)}, "has no grid"),
        ({"without": ("embedding",)}, "has no embedding"),
        ({"renamed": ("grid", "output")}, "has no grid: it has output float [?, 6, ?, ?]"),
        ({"free": True}, "embedding: its length is free; a fixed one is allowed"),
        ({"said": {"family": "gcn"}}, "has no points"),
        ({"said": {"family": "gcn"}, "points": POINTS}, "has no pairs"),
        ({"said": {"family": "gcn"}, "points": POINTS[..., :2], "pairs": PAIRS}, "points float [1, 5, 2]"),
        (
            {"said": {"family": "deepps"}, "points": POINTS, "pairs": PAIRS[:, :4]},
            "pairs float [1, 4, 5]: pairs float [?, 5, 5] is allowed",
        ),
    ],
)
def test_what_is_no_detector_is_refused(tmp_path, options, said):
    path = graph(tmp_path / "model.onnx", **options)
    with pytest.raises(InputError) as told:
        opened(path)
    assert str(told.value).startswith(f"{path}: ") and said in str(told.value)
    assert "\n" not in str(told.value)


def test_a_file_that_is_cut_off(tmp_path):
    path = graph(tmp_path / "model.onnx")
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InputError, match="is not an ONNX model that can be opened"):
        opened(path)
    with pytest.raises(InputError, match="cannot be read"):
        opened(tmp_path / "none.onnx")


@pytest.mark.parametrize(
    ("times", "said"), [(np.nan, "no finite numbers"), (np.inf, "no finite numbers"), (3.0, "run from 0 to 3: 0 to 1")]
)
def test_values_that_are_no_shares(tmp_path, times, said):
    detector = opened(graph(tmp_path / "model.onnx", times=times))
    image = np.full((32, 32, 3), 255, np.uint8)
    for look in (detector.detect, detector.grid):
        with pytest.raises(InputError, match=said):
            look(image, frame(32, 32))


def test_a_grid_of_another_stride(tmp_path):
    detector = opened(graph(tmp_path / "model.onnx", said={"stride": "8"}))
    with pytest.raises(InputError, match=r"grid has the shape \[1, 6, 2, 2\]: \[1, 6, 4, 4\] is allowed"):
        detector.grid(np.zeros((32, 32, 3), np.uint8), frame(32, 32))


def test_no_metadata_at_all(tmp_path):
    one = helper.make_tensor_value_info("a", TensorProto.FLOAT, [1])
    other = helper.make_tensor_value_info("b", TensorProto.FLOAT, [1])
    made = helper.make_graph([helper.make_node("Identity", ["a"], ["b"])], "g", [one], [other])
    path = tmp_path / "model.onnx"
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path.write_bytes(model.SerializeToString())
    with pytest.raises(InputError, match="is not a detector"):
        opened(path)
