"""`pavemark train detector`: from datasets to a detector that opens, and on from there."""

import json

import attrs
import cv2
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

from detect.datasets import made  # noqa: E402
from pavemark import cli  # noqa: E402
from pavemark.cli.train import _whole  # noqa: E402
from pavemark.detect.learned import opened  # noqa: E402
from pavemark.detect.reading import examples  # noqa: E402
from pavemark.errors import InputError  # noqa: E402
from pavemark.ground import Frame  # noqa: E402
from pavemark.training.detectors import command, training  # noqa: E402
from pavemark.training.detectors.datasets import Lessons, digest, largest  # noqa: E402
from pavemark.training.detectors.lessons import Lesson  # noqa: E402
from pavemark.training.detectors.training import train_detector  # noqa: E402


def listed(folder, count=3, size=(70, 40)):
    """A list of points alone, at 20 pixels a metre."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    lines = []
    for k in range(count):
        cv2.imwrite(str(folder / f"{k}.png"), rng.integers(0, 255, (size[1], size[0], 3), dtype=np.uint8))
        line = {"image": f"{k}.png", "w": size[0], "h": size[1], "scale": 20, "points": [[10 + k, 20.5]]}
        lines.append(json.dumps(line))
    (folder / "labels.jsonl").write_text("\n".join(lines))
    return folder


def run(capfd, *words):
    with pytest.raises(SystemExit) as left:
        cli.main(["train", "detector", "--threads", "1", "--batch", "2", *map(str, words)])
    said = capfd.readouterr()
    return left.value.code, said.err if left.value.code else said.out


def test_a_detector_is_made_and_another_begins_from_it(tmp_path, capfd):
    data = listed(tmp_path / "streets")
    assert run(capfd, "--data", data, "--out", tmp_path / "a.onnx", "--steps", 2)[0] == 0
    detector = opened(tmp_path / "a.onnx")
    assert (detector.family, detector.pixels_per_metre) == ("dmpr", 20.0)
    assert detector.grid(np.zeros((40, 70, 3), np.uint8), Frame(70, 40, 20.0)).shape == (3, 5, 3)
    words = ("--data", data, "--data", data, "--share", 1, "--share", 3, "--steps", 1, "--start", tmp_path / "a.pt")
    assert run(capfd, *words, "--out", tmp_path / "b.onnx", "--scale", 10)[0] == 0
    assert opened(tmp_path / "b.onnx").pixels_per_metre == 10.0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"streets", "a.onnx", "a.pt", "b.onnx", "b.pt"}
    assert torch.load(tmp_path / "a.pt", weights_only=True).keys() == torch.load(tmp_path / "b.pt").keys()


def test_twice_the_same(tmp_path, capfd):
    data = listed(tmp_path / "streets")
    for name in ("a", "b"):
        assert run(capfd, "--data", data, "--out", tmp_path / f"{name}.onnx", "--steps", 2)[0] == 0
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()


def test_what_is_stopped_as_the_model_is_written_is_not_in_the_way(tmp_path, capfd, monkeypatch):
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--steps", 1)

    def stopped(*of):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(command, "exported", stopped)
        assert run(capfd, *words)[0] == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.state", "streets"]
    assert run(capfd, *words)[0] == 0
    assert {path.name for path in tmp_path.iterdir()} == {"streets", "a.onnx", "a.pt"}


@pytest.mark.parametrize("option", ["--data", "--start"])
def test_an_empty_path(tmp_path, capfd, option):
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx")
    assert "it is empty" in run(capfd, *words, option, "")[1]


@pytest.mark.parametrize("words", [("--scale", "nan"), ("--height", "nan"), ("--share", "nan"), ("--share", "inf")])
def test_what_is_no_number(tmp_path, capfd, words):
    said = run(capfd, "--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--steps", 1, *words)
    assert said[0] == 2 and ("a finite number is allowed" in said[1] or "is not in the range" in said[1])


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04junk", {"a": 1}])
def test_a_damaged_state_is_told(tmp_path, capfd, content):
    state = tmp_path / "a.state"
    torch.save(content, state) if isinstance(content, dict) else state.write_bytes(content)
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--steps", 1)
    told = f"error: {state}: is no whole state of a training: remove it, and it begins anew\n"
    assert run(capfd, *words) == (2, told)
    state.unlink()
    assert run(capfd, *words)[0] == 0


def test_a_training_that_goes_astray_leaves_no_model(tmp_path, capfd, monkeypatch):
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--steps", 3)
    losses = training.Points.loss

    def astray(self, image, lessons):
        found = losses(self, image, lessons)
        return found | {next(iter(found)): next(iter(found.values())) * float("nan")}

    monkeypatch.setattr(training.Points, "loss", astray)
    code, said = run(capfd, *words)
    assert code == 2 and said.startswith("error: step 1: the loss is nan: a finite number is allowed")
    assert [path.name for path in tmp_path.iterdir()] == ["streets"]


def test_a_start_without_numbers(tmp_path, capfd):
    data = listed(tmp_path / "streets")
    assert run(capfd, "--data", data, "--out", tmp_path / "a.onnx", "--steps", 1)[0] == 0
    weights = torch.load(tmp_path / "a.pt", weights_only=True)
    torch.save({name: each * float("nan") for name, each in weights.items()}, tmp_path / "nan.pt")
    words = ("--data", data, "--out", tmp_path / "b.onnx", "--steps", 1, "--start", tmp_path / "nan.pt")
    code, said = run(capfd, *words)
    assert code == 2 and "nan.pt: holds weights that are no numbers" in said


def test_what_cannot_be_learnt_from_is_told_before_the_first_step(tmp_path, capfd):
    data = listed(tmp_path / "streets")
    words = ("--data", data, "--out", tmp_path / "a.onnx", "--steps", 1)
    (data / "1.png").unlink()
    code, said = run(capfd, *words)
    assert code == 2 and f"{data / '1.png'}: is missing, the first of 1 of the 3 images of {data}" in said
    first, _, third = (data / "labels.jsonl").read_text().splitlines()
    (data / "labels.jsonl").write_text("\n".join([first, third, first]))
    code, said = run(capfd, *words)
    assert code == 2 and "0: is listed twice: once is allowed" in said


@pytest.mark.parametrize(("option", "value"), [("--seed", 10**23), ("--share", 1e308)])
def test_numbers_beyond_all_use(tmp_path, capfd, option, value):
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--steps", 1)
    code, said = run(capfd, *words, option, value)
    assert code == 2 and option in said and "unexpected" not in said


@pytest.mark.parametrize("content", [b"", b"no weights", b"hello", b"1,2\n3,4\n", None, {"a": 1}])
def test_a_start_that_is_none(tmp_path, capfd, content):
    start = tmp_path / "start.pt"
    if content is None:
        torch.save({"head.weight": torch.zeros(3)}, start)
    elif isinstance(content, dict):
        torch.save(content, start)
    else:
        start.write_bytes(content)
    words = ("--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx", "--start", start)
    code, said = run(capfd, *words)
    assert code == 2 and said.startswith(f"error: {start}: holds no weights of a detector") and said.count("\n") == 1
    code, said = run(capfd, *words[:-1], tmp_path / "none.pt")
    assert code == 2 and "none.pt: cannot be read" in said


def test_points_alone_teach_no_pairs(tmp_path, capfd):
    words = ("--family", "gcn", "--data", listed(tmp_path / "streets"), "--out", tmp_path / "a.onnx")
    code, said = run(capfd, *words)
    assert code == 2 and "gcn: needs images whose slots are labelled" in said


def test_whose_markings_are_painted_anew_is_left_out(tmp_path, capfd):
    data = made(tmp_path / "made", 3)
    scene = json.loads((data / "scenes/000001.json").read_text())
    (data / "scenes/000001.json").write_text(json.dumps(scene | {"slots": [], "markings": [{"kind": "original"}]}))
    shown = _whole(data, list(examples(data)))
    assert [each.name for each in shown] == ["images/000000", "images/000002"]
    assert capfd.readouterr().err.startswith(f"left out: {data}: 1 of 3 images show their plates' own markings")
    only = [each for each in examples(data) if not each.known]
    with pytest.raises(InputError, match="nothing to learn from"):
        _whole(data, only)


@pytest.mark.parametrize("steps", [1, 2, 8, 9, 10, 19])
def test_any_number_of_steps(tmp_path, steps):
    lesson = Lesson(np.zeros((32, 32, 3), np.uint8), np.array([[9.0, 9.0]]), None, None, None)
    train_detector("dmpr", [[lesson]], steps, 0, batch=2, threads=1)


def test_lessons_are_kept_as_far_as_memory_reaches(tmp_path):
    shown = list(examples(listed(tmp_path / "streets")))
    lessons = Lessons(shown, 20.0, memory=70 * 40 * 3 * 2)
    assert lessons[0] is lessons[0] and lessons[2] is lessons[2]
    assert lessons[1] is not lessons[1]
    np.testing.assert_array_equal(lessons[1].image, cv2.imread(str(shown[1].image))[..., ::-1])
    assert len(lessons) == 3
    small = Lessons(shown, 10.0)[1]
    assert small.image.shape == (20, 35, 3) and small.points.tolist() == [[5.5, 10.25]]


def test_every_image_fits(tmp_path):
    shown = list(examples(listed(tmp_path / "streets")))
    assert largest(shown, 20.0, 16) == (80, 48)
    assert largest(shown, 10.0, 16) == (48, 32)
    assert largest(shown, 900.0, 16) == (640, 640)


def test_a_dataset_is_told_from_another(tmp_path):
    one, two = (list(examples(listed(tmp_path / name))) for name in ("a", "b"))
    assert digest(one) == digest(two) != digest(two[:2])
    turned = [attrs.evolve(each, directions=np.array([[1.0, 0.0]])) for each in one]
    assert digest(turned) != digest(one)
    # Another picture of as many bytes.
    kept = (tmp_path / "b" / "1.png").read_bytes()
    (tmp_path / "b" / "1.png").write_bytes(kept[:-1] + bytes([kept[-1] ^ 1]))
    assert digest(two) != digest(one)
