"""The training of the segmenter: it learns, goes on after a cut as if there had been none, and writes what runs."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

import onnxruntime  # noqa: E402

from pavemark.training import segmenter  # noqa: E402
from pavemark.training.canvas import SIDE  # noqa: E402
from pavemark.training.pool import GROUND, MARKING  # noqa: E402


@pytest.fixture
def pool(monkeypatch):
    """Grey ground with white lines, on which little has to be learnt."""
    monkeypatch.setattr(segmenter, "HELD_OUT", 2)
    monkeypatch.setattr(segmenter, "BATCH", 2)
    rng = np.random.default_rng(0)
    views = np.full((8, SIDE, SIDE, 4), 90, np.uint8)
    views[..., :3] += rng.integers(0, 20, (8, SIDE, SIDE, 3), dtype=np.uint8)
    views[..., 3] = GROUND
    for view in views:
        for at in rng.integers(20, SIDE - 20, 8):
            view[at : at + 8] = (220, 220, 220, GROUND | MARKING)
    return views


def _silent(step, told):
    pass


class Cut(Exception):
    pass


def test_it_goes_on_after_a_cut(pool, tmp_path, monkeypatch):
    monkeypatch.setattr(segmenter, "EVERY", 2)

    monkeypatch.setattr(segmenter, "TELL", 1)
    segmenter.train(pool, tmp_path / "whole.onnx", 8, 0, 1, _silent)
    # Between two keepings of the state, and at one.
    for turn in (3, 6):

        def cut(step, told, turn=turn):
            if step == turn:
                raise Cut

        with pytest.raises(Cut):
            segmenter.train(pool, tmp_path / "cut.onnx", 8, 0, 1, cut)
    segmenter.train(pool, tmp_path / "cut.onnx", 8, 0, 1, _silent)
    assert (tmp_path / "cut.onnx").read_bytes() == (tmp_path / "whole.onnx").read_bytes()
    assert not (tmp_path / "cut.state").exists()


def test_what_is_written_gives_what_was_learnt(tmp_path):
    torch.manual_seed(3)
    network = segmenter.Segmenter().eval()
    path = tmp_path / "model.onnx"
    path.write_bytes(segmenter.exported(network, "a test"))
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    for height, width in ((96, 320), (128, 64)):
        image = np.random.default_rng(1).random((1, 3, height, width), np.float32)
        (found,) = session.run(None, {"image": image})
        with torch.no_grad():
            wanted = torch.sigmoid(network(torch.from_numpy(image))).numpy()
        # Folding the normalisation into the weights rounds them anew.
        assert found.shape == (1, 2, height, width) and np.abs(found - wanted).max() < 1e-4


def test_the_truth_follows_its_pixels(pool):
    """Zoomed, turned and mirrored, a view's lines are bright where its bits say so."""
    for number in range(8):
        image, bits = segmenter.augmented(pool[number % 6], np.random.default_rng(number))
        marking = (bits & MARKING) > 0
        if 500 < marking.sum() < 0.5 * marking.size:
            assert np.median(image[marking]) > np.median(image[~marking]) + 0.05
