"""Training of the inpainter: the transform, the gaps, the loss's terms, the loop, the export. Needs torch."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is only there with the extra `train`")
onnxruntime = pytest.importorskip("onnxruntime")

from pavemark.errors import InputError  # noqa: E402
from pavemark.training import fourier, gaps, inpainter  # noqa: E402
from pavemark.training.canvas import SIDE  # noqa: E402
from pavemark.training.pool import GROUND, MARKING  # noqa: E402

torch.set_num_threads(1)

SIZES = [(24, 76), (128, 128), (150, 150), (25, 13), (7, 1), (1, 2)]


def stream(*keys):
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(5, spawn_key=keys)))


@pytest.fixture(scope="module")
def pool():
    """Two views of stripes that go on from edge to edge; a wall of pure green, a line of pure red."""
    views = np.zeros((2, SIDE, SIDE, 4), np.uint8)
    u = np.arange(SIDE)
    views[..., :3] = (110 + 40 * np.sin(2 * np.pi * u / 16))[None, None, :, None]
    views[..., 3] = GROUND
    views[:, :60] = (0, 255, 0, 0)
    views[:, 300:310] = (255, 0, 0, GROUND | MARKING)
    return views


@pytest.mark.parametrize("shape", SIZES)
def test_the_transform_is_the_discrete_fourier_transform(shape):
    x = torch.randn(2, 3, *shape, generator=torch.Generator().manual_seed(1))
    true = torch.fft.rfft2(x, norm="ortho")
    real, imaginary = fourier.spectrum(x)
    assert float((true.real - real).abs().max()) < 1e-5
    assert float((true.imag - imaginary).abs().max()) < 1e-5
    assert float((fourier.signal(real, imaginary, shape[1]) - x).abs().max()) < 1e-5


def test_the_inverse_takes_half_spectra_as_torch_does():
    half = torch.randn(2, 10, 6, 2, generator=torch.Generator().manual_seed(2))
    for width in (10, 11):
        true = torch.fft.irfft2(torch.view_as_complex(half), s=(10, width), norm="ortho")
        assert float((fourier.signal(half[..., 0], half[..., 1], width) - true).abs().max()) < 1e-5


def test_neither_brightness_nor_contrast_is_seen_where_nothing_is_clipped():
    torch.manual_seed(0)
    net = fourier.Filler().eval()
    image = 0.4 + 0.1 * torch.rand(1, 3, 64, 64)
    mask = torch.zeros(1, 1, 64, 64)
    mask[..., 20:34, :] = 1
    with torch.no_grad():
        plain = net(image, mask)
        other = net(0.2 + 1.3 * (image - 0.4), mask)
    # Not to the bit: the least strength is a level of rounding, whatever the contrast.
    assert float((0.2 + 1.3 * (plain - 0.4) - other).abs().max()) < 0.01
    assert float((plain - image).abs().max()) > 0.02


def test_a_membrane_joins_the_rims_of_a_hole():
    net = fourier.Filler()
    ramp = torch.linspace(0.2, 0.8, 96)[None, None, None, :].expand(1, 3, 64, 96)
    mask = torch.zeros(1, 1, 64, 96)
    mask[..., 40:58] = 1
    with torch.no_grad():
        smooth, _ = net.guess(ramp, mask)
        tight = net.membrane(torch.where(mask > 0, 1.0, ramp), mask, smooth)
    assert torch.equal(tight[..., :40], ramp[..., :40])
    # Steps of the ramp are 1.6 levels; what a mean of both sides would miss is 14.
    assert float((tight - ramp).abs().max()) * 255 < 4
    assert float((tight[..., 1:] - tight[..., :-1])[..., 30:66].min()) > 0


def test_what_lies_in_the_hole_is_not_looked_at():
    torch.manual_seed(0)
    net = fourier.Filler().eval()
    image = torch.rand(1, 3, 48, 64)
    mask = torch.zeros(1, 1, 48, 64)
    mask[..., 10:20, 8:50] = 1
    with torch.no_grad():
        assert torch.equal(net(image, mask), net(torch.where(mask > 0, 1.0, image), mask))
        assert torch.equal(net(image, 0 * mask), image)


def test_gaps_lie_on_bare_ground_and_nothing_else_is_ever_seen(pool):
    shares = []
    for number in range(30):
        patch = gaps.sample(stream(number), pool, 128)
        shares.append(patch.judged.mean())
        assert not (patch.judged & ~patch.gap).any()
        known, judged = patch.image[~patch.gap].astype(int), patch.image[patch.judged].astype(int)
        # Grey by birth, with gains of some per cent a channel. Soft edges are half wall; no pixel is all wall or paint.
        for pixels in (known, judged):
            assert (np.ptp(pixels, axis=1) < 180).all()
    assert np.mean(shares) > 0.05
    assert max(shares) < 0.7


def test_gaps_depend_on_the_stream_alone(pool):
    one, same, other = (gaps.sample(stream(key), pool, 96) for key in (1, 1, 2))
    assert np.array_equal(one.image, same.image) and np.array_equal(one.gap, same.gap)
    assert not np.array_equal(one.gap, other.gap)


def test_the_loss_asks_for_texture():
    generator = torch.Generator().manual_seed(3)
    truth = torch.randn(1, 3, 96, 96, generator=generator)
    again = torch.randn(1, 3, 96, 96, generator=generator)
    judged = torch.ones(1, 1, 96, 96)
    flat, rough = 0 * truth, 2 * again
    energy = [float(inpainter._energy_error(x, truth, judged)) for x in (truth, again, flat, rough)]
    assert energy[0] == 0
    # Another draw of the same grain is as good as the truth nearly; none at all, and too much, are not.
    assert energy[1] < 0.2 * energy[2]
    assert energy[1] < 0.2 * energy[3]
    error = [float(inpainter._error(x, truth, judged, 0 * judged)) for x in (truth, again, flat)]
    assert error[0] == 0 < error[2] < error[1]


def test_training_learns_and_goes_on_where_it_was_cut_off(pool, tmp_path, monkeypatch):
    monkeypatch.setattr(inpainter, "PATCH", 64)
    monkeypatch.setattr(inpainter, "BATCH", 2)
    monkeypatch.setattr(inpainter, "KEPT_EVERY", 2)
    monkeypatch.setattr(inpainter, "WARM", 2)

    class Stopped(Exception):
        pass

    def stop(step, terms):
        if step == 3:
            raise Stopped

    told = []
    whole, cut = tmp_path / "whole.onnx", tmp_path / "cut.onnx"
    inpainter.train(pool, whole, 5, 7, 1, lambda step, terms: told.append((step, terms)))
    assert [step for step, _ in told] == [1, 2, 3, 4, 5]
    assert all(np.isfinite(list(terms.values())).all() for _, terms in told)
    assert {"error", "coarse", "energy", "features", "verdict", "critic"} <= set(told[-1][1])
    with pytest.raises(Stopped):
        inpainter.train(pool, cut, 5, 7, 1, stop)
    assert not cut.exists()
    inpainter.train(pool, cut, 5, 7, 1, lambda step, terms: None)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["cut.onnx", "whole.onnx"]
    image = np.random.default_rng(1).random((1, 3, 64, 96), np.float32)
    mask = np.zeros((1, 1, 64, 96), np.float32)
    mask[..., 20:40, :] = 1
    fills = [
        onnxruntime.InferenceSession(path.read_bytes()).run(None, {"image": image, "mask": mask})[0]
        for path in (whole, cut)
    ]
    assert np.abs(fills[0] - fills[1]).max() < 1e-6
    assert np.abs(fills[0] - image).max() > 0.02


def test_what_another_training_left_behind_is_not_gone_on_from_nor_lost(pool, tmp_path, monkeypatch):
    monkeypatch.setattr(inpainter, "PATCH", 64)
    monkeypatch.setattr(inpainter, "BATCH", 1)
    monkeypatch.setattr(inpainter, "KEPT_EVERY", 1)

    def stop(step, terms):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        inpainter.train(pool, tmp_path / "a.onnx", 4, 1, 1, stop)
    with pytest.raises(InputError, match=r"a.onnx.state: a training with other options, .* was stopped at step 1"):
        inpainter.train(pool, tmp_path / "a.onnx", 2, 2, 1, lambda step, terms: None)


@pytest.mark.parametrize("size", [(8, 8), (96, 304), (200, 328)])
def test_onnxruntime_gives_what_torch_gives(size):
    torch.manual_seed(4)
    net = fourier.Filler().eval()
    with torch.no_grad():
        net.leave.weight *= 10
    session = onnxruntime.InferenceSession(inpainter.exported(net))
    image = np.random.default_rng(1).random((1, 3, *size), np.float32)
    mask = (np.random.default_rng(2).random((1, 1, *size)) > 0.7).astype(np.float32)
    (found,) = session.run(["filled"], {"image": image, "mask": mask})
    with torch.no_grad():
        wanted = net(torch.from_numpy(image), torch.from_numpy(mask)).numpy()
    assert np.abs(found - wanted).max() < 1e-5
    assert session.get_modelmeta().custom_metadata_map["pavemark"] == "inpainter 1"
