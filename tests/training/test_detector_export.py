"""What is written as ONNX finds what the network found, at any size, and says what it is."""

import io

import numpy as np
import onnx
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")

import onnxruntime  # noqa: E402

from pavemark.detect.learned import opened  # noqa: E402
from pavemark.ground import Frame  # noqa: E402
from pavemark.training.detectors.export import exported  # noqa: E402
from pavemark.training.detectors.training import FAMILIES, fresh  # noqa: E402


@pytest.fixture(scope="module", params=FAMILIES)
def network(request):
    """A network whose normalisation is not that of the first step, and which finds points everywhere."""
    network = fresh(request.param, 3)
    generator = torch.Generator().manual_seed(4)
    with torch.no_grad():
        for name, value in network.named_buffers():
            if name.endswith(("running_mean", "running_var")):
                value.add_(torch.rand(value.shape, generator=generator) * 0.2)
        network.head.weight.mul_(20)
        network.head.bias.zero_()
    return network.eval()


@pytest.mark.parametrize("size", [(96, 304), (16, 16), (64, 208)])
def test_the_file_gives_what_was_learnt(network, size):
    session = onnxruntime.InferenceSession(exported(network, 25.0, "a test"), providers=["CPUExecutionProvider"])
    # Of cells that differ, so that no two are as confident but for the last digits.
    cells = np.random.default_rng(1).random((2, 3, size[0] // 16, size[1] // 16), np.float32)
    image = np.kron(cells, np.ones((16, 16), np.float32))
    found = session.run(None, {"image": image})
    with torch.no_grad():
        wanted = network.outputs(torch.from_numpy(image))
    assert [output.name for output in session.get_outputs()] == list(wanted)
    for one, (name, other) in zip(found, wanted.items(), strict=True):
        # Folding the normalisation into the weights rounds them anew.
        assert one.shape == tuple(other.shape), name
        assert np.abs(one - other.numpy()).max() < 1e-4, name
    if network.family != "dmpr":
        points, pairs = found[2:]
        assert (np.diff(points[..., 2]) <= 1e-6).all() and pairs.min() >= 0 and pairs.max() <= 1
        assert not np.diagonal(pairs, axis1=1, axis2=2).any()
        assert not pairs[(points[..., 2] == 0)].any()
    grid = found[0]
    assert grid.shape == (2, 6, size[0] // 16, size[1] // 16)
    assert grid[:, [0, 1, 2, 5]].min() >= 0 and grid[:, [0, 1, 2, 5]].max() <= 1
    np.testing.assert_allclose(np.hypot(grid[:, 3], grid[:, 4]), 1, atol=1e-5)


@pytest.mark.parametrize("size", [(300, 300), (90, 41), (8, 8)])
def test_the_file_is_opened_and_looks(network, tmp_path, size):
    path = tmp_path / "model.onnx"
    path.write_bytes(exported(network, 30.0, "a test"))
    detector = opened(path)
    image = np.random.default_rng(2).integers(0, 255, (size[1], size[0], 3), dtype=np.uint8)
    found = detector.detect(image, Frame(*size, 30.0))
    assert detector.family == network.family and len(found.confidence) == len(found.points)
    assert (found.slots < len(found.points)).all() and len(found.slots) == len(found.slot_confidence)
    assert detector.embedding(image, Frame(*size, 30.0)).shape == (96,)
    grid = detector.grid(image, Frame(*size, 30.0))
    assert grid.shape == (-(-size[1] // 16), -(-size[0] // 16), 3)
    if network.family != "dmpr" and size == (300, 300):
        assert len(found.points) > 5


def test_no_size_is_taken_for_fixed(network, recwarn):
    exported(network, 30.0, "a test")
    assert not [one for one in recwarn if issubclass(one.category, torch.jit.TracerWarning)]


def test_the_file_says_what_it_is(network):
    model = onnx.load(io.BytesIO(exported(network, 25.0, "pavemark train detector", "a data set", "CC0-1.0")))
    assert {prop.key: prop.value for prop in model.metadata_props} == {
        "pavemark": "detector 1",
        "family": network.family,
        "pixels_per_metre": "25",
        "stride": "16",
        "made": "pavemark train detector",
        "licence": "CC0-1.0",
        "trained_on": "a data set",
    }


def test_the_same_network_gives_the_same_file(network):
    assert exported(network, 25.0, "a test") == exported(network, 25.0, "a test")
