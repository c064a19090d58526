"""The network that finds markings and free ground: a small U-Net, trained on views of our own alone."""

from __future__ import annotations

import io
import math
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import onnx
import torch
from torch import nn
from torch.nn import functional

from pavemark.background.contrast import evened
from pavemark.colour import quantise
from pavemark.files import write
from pavemark.training.canvas import SIDE
from pavemark.training.pool import GROUND, MARKING
from pavemark.training.state import hold_finite, keep, taken_up
from pavemark.training.views import KINDS, SCALE, Kind

CROP, BATCH = 256, 12
"""Pixels a side of what is learnt from at a time, and how many in a step."""

WIDTHS = (24, 40, 64, 96, 128)
"""Channels at 2, 4, 8, 16 and 32 pixels a cell: 1.0 million weights."""

DEEPEST = 2 ** len(WIDTHS)
"""The network takes sides that are multiples of this."""

DECAY, KEPT = 1e-2, 0.998
"""Weight decay, and how much of the averaged weights stays at a step."""

HELD_OUT = 50
"""Views, the last ones, that are judged by and not learnt from."""

RATE, LAST = 2e-3, 3e-4
"""The largest learning rate, and the one that stays at the end. Were it to fall to nothing, the network would settle on
what is peculiar to drawn views: real markings are found better by the mean of weights that still wander."""

RISE, FALL = 400, 4500
"""Steps until the learning rate is largest, and until it has come down to LAST. It does not depend on how many steps
there are: a longer training goes on where a shorter one stops."""

ZOOM = (0.55, 2.0)
"""Between what factors views are enlarged: no user's scale is quite known, and that of lanes often not at all."""

SHARES: dict[Kind, float] = {"any": 0.30, "garage": 0.25, "pavers": 0.20, "crossing": 0.15, "full": 0.10}
"""How much of what is learnt from is of each kind of view."""

AHEAD = 2
"""Steps for which the pieces of views are made ahead."""

TELL, EVERY = 20, 200
"""Steps from one telling, and from one keeping of the state, to the next."""

Tell = Callable[[int, dict[str, float]], None]


class Segmenter(nn.Module):
    """Display RGB (N, 3, H, W), 0 to 1 → logits (N, 2, H, W): marking, ground. H and W are multiples of DEEPEST."""

    def __init__(self) -> None:
        super().__init__()
        self.down = nn.ModuleList(
            _block(before, width) for before, width in zip((12, *WIDTHS[:-1]), WIDTHS, strict=True)
        )
        self.up = nn.ModuleList(
            _block(below + width, width) for below, width in zip(WIDTHS[:0:-1], WIDTHS[-2::-1], strict=True)
        )
        self.head = nn.Conv2d(WIDTHS[0], 2 * 4, 3, padding=1)
        # Markings are a twentieth of the pixels, ground four fifths: to begin with that costs a hundred steps.
        with torch.no_grad():
            self.head.bias.copy_(torch.tensor([-3.0] * 4 + [1.4] * 4))

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        features, seen = functional.pixel_unshuffle(image - 0.4, 2), []
        for depth, block in enumerate(self.down):
            features = block(features if depth == 0 else functional.max_pool2d(features, 2))
            seen.append(features)
        for block, finer in zip(self.up, seen[-2::-1], strict=True):
            features = block(torch.cat([functional.interpolate(features, scale_factor=2.0), finer], 1))
        return functional.pixel_shuffle(self.head(features), 2)


def _block(before: int, width: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for channels in (before, width):
        layers += [nn.Conv2d(channels, width, 3, padding=1, bias=False), nn.BatchNorm2d(width), nn.ReLU()]
    return nn.Sequential(*layers)


def train(pool: np.ndarray, out: Path, steps: int, seed: int, threads: int, tell: Tell) -> None:
    """Train the network and write it as ONNX.

    The state is kept beside `out` as the training goes, and taken up again by the same call.

    Parameters
    ----------
    pool : ndarray (N, SIDE, SIDE, 4) uint8
        From `pavemark.training.pool.drawn`.
    out : Path
        The model.
    steps, seed : int
    threads : int
        Of torch. Another number gives other last bits.
    tell : callable
        Told, every TELL steps, the step and the loss; when the state is kept, also the F1 of markings and the IoU of
        ground on held-out views, from the averaged weights.
    """
    torch.manual_seed(seed)
    torch.set_num_threads(threads)
    cv2.setNumThreads(1)
    job = (steps, seed, len(pool))
    state = out.with_suffix(".state")
    network = Segmenter().to(memory_format=torch.channels_last)
    averaged = torch.optim.swa_utils.AveragedModel(network, avg_fn=_average, use_buffers=True)
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.LambdaLR(optimiser, _share_of_rate)
    parts = {"network": network, "averaged": averaged, "optimiser": optimiser, "schedule": schedule}
    first = taken_up(state, parts, job)
    held_out = max(1, len(pool) - HELD_OUT)
    for step, (image, truth) in enumerate(_batches(pool[:held_out], seed, range(first, steps)), first):
        told = {"loss": _step(network, optimiser, image, truth)}
        hold_finite(told["loss"], step + 1)
        schedule.step()
        averaged.update_parameters(network)
        if step % EVERY == EVERY - 1:
            told |= judged(averaged.module, pool[held_out:])
            keep(state, parts, job, step + 1)
        if step % TELL == TELL - 1:
            tell(step + 1, told)
    write(out, exported(averaged.module, f"steps {steps}, seed {seed}, views {len(pool)}"))
    state.unlink(missing_ok=True)


def _share_of_rate(step: int) -> float:
    """The learning rate at a step, in parts of RATE."""
    if step < RISE:
        return (step + 1) / RISE
    fallen = min(1.0, (step - RISE) / (FALL - RISE))
    return LAST / RATE + (1 - LAST / RATE) * (1 + math.cos(math.pi * fallen)) / 2


def _step(network: nn.Module, optimiser: torch.optim.Optimizer, image: torch.Tensor, truth: torch.Tensor) -> float:
    """One step of learning; the loss before it."""
    network.train()
    with torch.autocast("cpu", torch.bfloat16):
        logits = network(image)
    value = loss(logits.float(), truth)
    optimiser.zero_grad()
    value.backward()
    nn.utils.clip_grad_norm_(network.parameters(), 1.0)
    optimiser.step()
    return value.item()


def _average(kept: torch.Tensor, new: torch.Tensor, count: torch.Tensor) -> torch.Tensor:
    # The first weights are no better than chance: they must not weigh as much as later ones.
    share = torch.clamp((1 + count) / (10 + count), max=KEPT)
    return kept + (1 - share) * (new - kept)


def loss(logits: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Cross entropy and soft Dice of both classes. `logits`, `truth`: (N, 2, H, W)."""
    # A marking missed stays in the plate for good; ground taken for marking is filled, and hardly to be seen.
    entropy = functional.binary_cross_entropy_with_logits(
        logits, truth, pos_weight=torch.tensor([2.0, 1.0]).view(1, 2, 1, 1)
    )
    chance = torch.sigmoid(logits)
    both = (chance * truth).sum((0, 2, 3))
    dice = 1 - (2 * both + 1) / (chance.sum((0, 2, 3)) + truth.sum((0, 2, 3)) + 1)
    return entropy + dice[0] + 0.3 * dice[1]


def _batches(pool: np.ndarray, seed: int, steps: range) -> Iterator[tuple[torch.Tensor, torch.Tensor]]:
    """What is learnt from at each step, made while the step before is learnt from."""
    with ThreadPoolExecutor(1) as crew:
        ahead = deque(crew.submit(_batch, pool, seed, step) for step in steps[:AHEAD])
        for step in steps:
            batch = ahead.popleft().result()
            if step + AHEAD in steps:
                ahead.append(crew.submit(_batch, pool, seed, step + AHEAD))
            yield batch


def _batch(pool: np.ndarray, seed: int, step: int) -> tuple[torch.Tensor, torch.Tensor]:
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(1, step))))
    samples = [augmented(pool[_number(rng, len(pool))], rng) for _ in range(BATCH)]
    image = torch.from_numpy(np.stack([image for image, _ in samples])).permute(0, 3, 1, 2)
    truth = torch.from_numpy(np.stack([bits for _, bits in samples]))
    truth = torch.stack([(truth & bit) > 0 for bit in (MARKING, GROUND)], 1).float()
    return image.contiguous(memory_format=torch.channels_last), truth


def _number(rng: np.random.Generator, count: int) -> int:
    """Draw one of the first `count` views, whose kinds come in turn, by the share of its kind."""
    turns = np.flatnonzero(np.arange(len(KINDS)) < count)
    chances = np.array([SHARES[KINDS[turn]] / KINDS.count(KINDS[turn]) for turn in turns])
    turn = int(rng.choice(turns, p=chances / chances.sum()))
    return turn + len(KINDS) * int(rng.integers(-(-(count - turn) // len(KINDS))))


def augmented(view: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A piece of a view as another camera might have shown it.

    Parameters
    ----------
    view : ndarray (SIDE, SIDE, 4) uint8
        As in a pool.
    rng : Generator

    Returns
    -------
    image : ndarray (CROP, CROP, 3) float32
        Display RGB, 0 to 1.
    bits : ndarray (CROP, CROP) uint8
    """
    factor = float(np.exp(rng.uniform(*np.log(ZOOM))))
    turn = float(rng.normal(0, 0.1)) if rng.random() < 0.4 else 0.0
    size = CROP / factor
    middle = rng.uniform(size / 2, SIDE - size / 2, 2) if size < SIDE else np.full(2, SIDE / 2)
    c, s = factor * math.cos(turn), factor * math.sin(turn)
    matrix = np.array([[c, s, 0], [-s, c, 0]])
    matrix[:, 2] = CROP / 2 - matrix[:, :2] @ middle
    warp = {"M": matrix, "dsize": (CROP, CROP), "borderMode": cv2.BORDER_REFLECT_101}
    image = cv2.warpAffine(np.ascontiguousarray(view[..., :3]), flags=cv2.INTER_LINEAR, **warp)
    bits = cv2.warpAffine(np.ascontiguousarray(view[..., 3]), flags=cv2.INTER_NEAREST, **warp)
    if rng.random() < 0.5:
        image, bits = image[:, ::-1], bits[:, ::-1]
    turns = int(rng.integers(4))
    image, bits = np.rot90(image, turns), np.rot90(bits, turns)
    return _spoilt(np.ascontiguousarray(image), rng), np.ascontiguousarray(bits)


def _spoilt(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Other light, other colours, less sharpness, noise, compression: (CROP, CROP, 3) uint8 → float32, 0 to 1."""
    if rng.random() < 0.5:
        # Half-views have 22 pixels a metre, and are enlarged.
        small = max(32, int(CROP / rng.uniform(1.0, 2.6)))
        image = cv2.resize(image, (small, small), interpolation=cv2.INTER_AREA)
        image = _compressed(image, rng)
        image = cv2.resize(image, (CROP, CROP), interpolation=cv2.INTER_LINEAR)
    light = image.astype(np.float32) / 255
    grey = light.mean(-1, keepdims=True)
    light = grey + (light - grey) * np.float32(rng.uniform(0.2, 1.7))
    light = np.clip(light, 0, 1) ** np.float32(np.exp(rng.normal(0, 0.25)))
    light = light * (np.exp(rng.normal(0, 0.3)) * (1 + rng.normal(0, 0.05, 3))).astype(np.float32)
    if rng.random() < 0.3:
        light = light * np.float32(rng.uniform(0.4, 1.0)) + np.float32(rng.uniform(0.0, 0.4))
    if rng.random() < 0.3:
        light = cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.4, 2.0)))
    if rng.random() < 0.3:
        light = light + rng.uniform(0.3, 1.5) * (light - cv2.GaussianBlur(light, (0, 0), 1.5))
    if rng.random() < 0.5:
        noise = rng.standard_normal((CROP, CROP, 3), np.float32)
        if rng.random() < 0.5:
            noise = noise.mean(-1, keepdims=True)
        light = light + noise * np.float32(rng.uniform(0, 0.07))
    if rng.random() < 0.4:
        light = _compressed(quantise(light * 255), rng).astype(np.float32) / 255
    if rng.random() < 0.3:
        # Pictures are also looked at with their contrast made even: here one to four tiles a side, a piece is small.
        light = evened(quantise(light * 255), SCALE / 2 / float(rng.uniform(*ZOOM)), float(rng.uniform(1.5, 4.0))) / 255
    return np.clip(light, 0, 1).astype(np.float32)


def _compressed(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    coded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(25, 95))])[1]
    return cv2.imdecode(coded, cv2.IMREAD_COLOR)


def judged(network: nn.Module, views: np.ndarray) -> dict[str, float]:
    """F1 of markings and IoU of ground over views (N, SIDE, SIDE, 4), at a probability of one half."""
    network.eval()
    counts = np.zeros((2, 3))
    with torch.no_grad():
        for view in views:
            image = torch.from_numpy(view[None, ..., :3].astype(np.float32) / 255).permute(0, 3, 1, 2)
            found = (network(image)[0] > 0).numpy()
            for k, bit in enumerate((MARKING, GROUND)):
                there = (view[..., 3] & bit) > 0
                counts[k] += (found[k] & there).sum(), found[k].sum(), there.sum()
    (both, found, there), (both_ground, found_ground, there_ground) = counts
    return {"F1": 2 * both / max(found + there, 1), "IoU": both_ground / (found_ground + there_ground - both_ground)}


class _Whole(nn.Module):
    """The network with what belongs to it: the probabilities rather than logits."""

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return torch.sigmoid(self.network(image))


def exported(network: nn.Module, made: str) -> bytes:
    """The network as an ONNX file: `image` (1, 3, H, W) → `probability` (1, 2, H, W), both float32, 0 to 1."""
    stream = io.BytesIO()
    torch.onnx.export(
        _Whole(network).eval(),
        (torch.zeros(1, 3, 4 * DEEPEST, 4 * DEEPEST),),
        stream,
        input_names=["image"],
        output_names=["probability"],
        dynamic_axes={name: {2: "height", 3: "width"} for name in ("image", "probability")},
        opset_version=17,
        dynamo=False,
    )
    model = onnx.load_from_string(stream.getvalue())
    onnx.helper.set_model_props(
        model,
        {"pavemark": "segmenter 1", "pixels_per_metre": f"{SCALE:g}", "made": made, "licence": "GPL-3.0-or-later"},
    )
    onnx.checker.check_model(model)
    return model.SerializeToString()
