"""Training of our own inpainter: what its fills are held against, the loop, and the export to ONNX.

The mean of all that may lie in a gap has the least error, and no texture. So the error is one term of the loss beside
three that ask for what ground looks like: the energy of the texture in bands and directions, the features of a critic
that learns to tell fills from ground, and its verdict.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.parametrizations import spectral_norm

from pavemark import files
from pavemark.training import gaps
from pavemark.training.fourier import CELL, Filler
from pavemark.training.state import hold_finite, keep, taken_up

PATCH = 192
"""Pixels a side of a patch."""

BATCH = 8

RATE, CRITIC_RATE = 8e-4, 3e-4
"""Learning rates of Adam at their highest."""

WARM = 200
"""Steps over which the rate rises; after them it falls to nothing as a cosine."""

AVERAGED = 0.998
"""Share of the averaged weights that a step leaves: the averaged ones are shipped."""

SOBER = 0.08
"""Share of the steps before the critic is heard."""

KEPT_EVERY = 250
"""Steps after which the state is kept: training that was cut off goes on from there."""

ERROR, COARSE, ENERGY, FEATURES, VERDICT = 1.0, 1.0, 0.6, 1.5, 0.15
"""Weights of the terms of the loss."""


class Critic(nn.Module):
    """Tells fills from ground, block by block of 8×8 pixels."""

    def __init__(self) -> None:
        super().__init__()
        sizes = ((3, 32, 4, 2), (32, 64, 4, 2), (64, 96, 4, 2), (96, 96, 3, 1))
        self.layers = nn.ModuleList(
            spectral_norm(nn.Conv2d(inward, outward, side, stride, padding=1))
            for inward, outward, side, stride in sizes
        )
        self.verdict = spectral_norm(nn.Conv2d(96, 1, 1))

    def forward(self, x: Tensor) -> tuple[Tensor, list[Tensor]]:
        """The verdict (B, 1, H / 8, W / 8), positive for ground, and what led to it."""
        features = []
        for layer in self.layers:
            x = functional.leaky_relu(layer(x), 0.2)
            features.append(x)
        return self.verdict(x), features


def train(
    pool: np.ndarray, out: Path, steps: int, seed: int, threads: int, tell: Callable[[int, dict[str, float]], None]
) -> None:
    """Train the inpainter and write it as ONNX.

    Beside it, until it is done, lies a state from which training that was cut off goes on.

    Parameters
    ----------
    pool : ndarray (N, SIDE, SIDE, 4) uint8
        As `pavemark.training.pool.drawn` returns it. Markings in it are no truth; views without any teach more.
    out : Path
        The ONNX file.
    steps : int
        Batches of 8 patches.
    seed : int
    threads : int
        On which the last bits of the result depend.
    tell : callable
        Told the step and the terms of its loss, each step.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    torch.set_num_threads(threads)
    torch.manual_seed(seed)
    state = out.with_name(out.name + ".state")
    net, average, critic = Filler(), Filler(), Critic()
    average.load_state_dict(net.state_dict())
    makers = torch.optim.Adam(net.parameters(), RATE, betas=(0.5, 0.99))
    judges = torch.optim.Adam(critic.parameters(), CRITIC_RATE, betas=(0.5, 0.99))
    parts = {"net": net, "average": average, "critic": critic, "makers": makers, "judges": judges}
    job = (len(pool), steps, seed, PATCH, BATCH)
    begin = taken_up(state, parts, job)
    net, critic = net.to(memory_format=torch.channels_last), critic.to(memory_format=torch.channels_last)
    for step in range(begin, steps):
        terms = _step(step, steps, seed, pool, net, average, critic, makers, judges)
        hold_finite(sum(terms.values()), step + 1)
        if (step + 1) % KEPT_EVERY == 0:
            keep(state, parts, job, step + 1)
        tell(step + 1, terms)
    files.write(out, exported(average))
    state.unlink(missing_ok=True)


def _step(step, steps, seed, pool, net, average, critic, makers, judges) -> dict[str, float]:
    # Each step has streams of its own: training that was cut off goes on as if it had not been.
    image, gap, judged = _batch(step, seed, pool)
    noise = torch.Generator().manual_seed(seed * 1_000_003 + step)
    grain = torch.randn(len(image), CELL * CELL, PATCH // CELL, PATCH // CELL, generator=noise)
    share = min(1.0, (step + 1) / WARM) * 0.5 * (1 + math.cos(math.pi * step / steps))
    heard = min(1.0, max(0.0, (step / steps - SOBER) / SOBER))
    for optimizer, rate in ((makers, RATE), (judges, CRITIC_RATE)):
        for group in optimizer.param_groups:
            group["lr"] = rate * share
    with torch.no_grad():
        smooth, strength = net.guess(image, gap)
        base = net.membrane(image, gap, smooth)
        truth = ((image - smooth) / strength).clamp(-8, 8)
        begun = ((base - smooth) / strength).clamp(-8, 8)
    with torch.autocast("cpu", torch.bfloat16):
        made = net.detail(base, gap, smooth, strength, grain)
    made = begun + made.float()
    filled = torch.where(judged > 0, made, truth)
    terms = {
        "error": _error(made, truth, judged, 1 - gap),
        "coarse": _coarse_error(made, truth, judged),
        "energy": _energy_error(filled, truth, judged),
    }
    loss = ERROR * terms["error"] + COARSE * terms["coarse"] + ENERGY * terms["energy"]
    if heard:
        fake = (functional.avg_pool2d(judged, 8) > 0.1).float()
        critic.requires_grad_(False)
        with torch.autocast("cpu", torch.bfloat16):
            with torch.no_grad():
                _, wanted = critic(truth)
            verdict, features = critic(filled)
        terms["features"] = _feature_error(features, wanted, judged)
        terms["verdict"] = -_mean(verdict.float(), fake)
        loss = loss + heard * (FEATURES * terms["features"] + VERDICT * terms["verdict"])
    makers.zero_grad(set_to_none=True)
    loss.backward()
    nn.utils.clip_grad_norm_(net.parameters(), 5.0)
    makers.step()
    if step / steps > SOBER / 2:
        fake = (functional.avg_pool2d(judged, 8) > 0.1).float()
        critic.requires_grad_(True)
        with torch.autocast("cpu", torch.bfloat16):
            verdict, _ = critic(torch.cat([truth, filled.detach()]))
        real, made_up = verdict.float().chunk(2)
        terms["critic"] = _mean((1 - real).relu(), torch.ones_like(fake)) + _mean((1 + made_up).relu(), fake)
        judges.zero_grad(set_to_none=True)
        terms["critic"].backward()
        judges.step()
    with torch.no_grad():
        kept = min(AVERAGED, (step + 1) / (step + 20))
        for slow, fast in zip(average.parameters(), net.parameters(), strict=True):
            slow.lerp_(fast, 1 - kept)
    return {name: float(term.detach()) for name, term in terms.items()}


def _batch(step: int, seed: int, pool: np.ndarray) -> tuple[Tensor, Tensor, Tensor]:
    """Images (B, 3, S, S) from 0 to 1, gaps and what of them is judged (B, 1, S, S), 0 and 1."""
    patches = []
    for number in range(BATCH):
        rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(step, number))))
        patches.append(gaps.sample(rng, pool, PATCH))
    image = (
        torch.from_numpy(np.stack([patch.image for patch in patches])).permute(0, 3, 1, 2).contiguous().float() / 255
    )
    gap, judged = (
        torch.from_numpy(np.stack(masks)[:, None]).float()
        for masks in ([patch.gap for patch in patches], [patch.judged for patch in patches])
    )
    return image, gap, judged


def _mean(x: Tensor, weight: Tensor) -> Tensor:
    """Weighted mean of arrays (B, C, H, W) under weights (B, 1, H, W)."""
    return (x * weight).sum() / (weight.sum() * x.shape[1]).clamp_min(1e-6)


def _error(made: Tensor, truth: Tensor, judged: Tensor, known: Tensor) -> Tensor:
    return _mean((made - truth).abs(), judged + 0.05 * known)


def _coarse_error(made: Tensor, truth: Tensor, judged: Tensor) -> Tensor:
    """The error of means over 4×4 and 16×16 pixels: shading and tone, which the eye sees first."""
    error, total = (made - truth) * judged, 0.0
    for side in (4, 16):
        total = total + functional.avg_pool2d(error, side).abs().sum() * side**2 / (judged.sum() * 3).clamp_min(1)
    return total


def _energy_error(filled: Tensor, truth: Tensor, judged: Tensor) -> Tensor:
    """How far the texture's strength, band by band and direction by direction, is from the ground's.

    Differences of neighbours in four directions, at three resolutions, of brightness and of red against blue; their
    strength is the root mean square over about 12 pixels. Where exactly a grain lies does not count, how strong it is
    does.
    """
    total, weight = 0.0, judged
    made, true = (torch.stack([x.mean(1), x[:, 0] - x[:, 2]], 1) for x in (filled, truth))
    for octave in range(3):
        window = 12 >> octave
        held = functional.avg_pool2d(weight, window, window // 2)
        pairs = zip(_strengths(made, window), _strengths(true, window), strict=True)
        error = sum((one - other).abs() for one, other in pairs)
        total = total + 2**octave * _mean(error, held)
        made, true, weight = (functional.avg_pool2d(x, 2) for x in (made, true, weight))
    return total


def _strengths(x: Tensor, window: int) -> list[Tensor]:
    found = []
    for one, other in (
        (x[..., 1:], x[..., :-1]),
        (x[..., 1:, :], x[..., :-1, :]),
        (x[..., 1:, 1:], x[..., :-1, :-1]),
        (x[..., 1:, :-1], x[..., :-1, 1:]),
    ):
        lacking = (0, x.shape[-1] - one.shape[-1], 0, x.shape[-2] - one.shape[-2])
        square = functional.pad((one - other).square(), lacking)
        found.append((functional.avg_pool2d(square, window, window // 2) + 1e-3).sqrt())
    return found


def _feature_error(made: list[Tensor], wanted: list[Tensor], judged: Tensor) -> Tensor:
    total = 0.0
    for number, (one, other) in enumerate(zip(made, wanted, strict=True)):
        near = functional.adaptive_max_pool2d(judged, one.shape[-2:])
        scale = other.float().abs().mean().clamp_min(1e-3)
        total = total + _mean((one.float() - other.float()).abs(), near) / scale * (0.5 if number == 0 else 1.0)
    return total / len(made)


def exported(net: Filler) -> bytes:
    """The network as an ONNX file.

    Inputs `image` float32 (1, 3, H, W), display sRGB from 0 to 1, and `mask` float32 (1, 1, H, W), 1 in the hole; H and
    W are multiples of 8, and free. Output `filled` float32 (1, 3, H, W).
    """
    import onnx  # noqa: PLC0415

    net = net.eval()
    sides = {2: "height", 3: "width"}
    held = io.BytesIO()
    torch.onnx.export(
        net,
        (torch.rand(1, 3, 96, 128), torch.zeros(1, 1, 96, 128)),
        held,
        input_names=["image", "mask"],
        output_names=["filled"],
        dynamic_axes={"image": sides, "mask": sides, "filled": sides},
        opset_version=17,
        dynamo=False,
    )
    model = onnx.load_from_string(held.getvalue())
    # The exporter gives up on the sides that are fixed.
    for side, length in zip(model.graph.output[0].type.tensor_type.shape.dim[:2], (1, 3), strict=True):
        side.dim_value = length
    onnx.helper.set_model_props(model, {"pavemark": "inpainter 1"})
    model.producer_name, model.producer_version = "pavemark", ""
    onnx.checker.check_model(model, full_check=True)
    return model.SerializeToString()
