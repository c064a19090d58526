"""How detectors learn: the same steps for every family, for a command and for a study."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import nn

from pavemark.training.detectors.deepps import DeepPs
from pavemark.training.detectors.gcn import Gcn
from pavemark.training.detectors.lessons import Lesson, augmented, canvas, noise
from pavemark.training.detectors.network import STRIDE, Points
from pavemark.training.state import hold_finite, keep, taken_up

FAMILIES: dict[str, type[Points]] = {kind.family: kind for kind in (Points, Gcn, DeepPs)}

BATCH = 16
"""Images in a step."""

RATE, DECAY = 3e-3, 1e-2
"""Largest learning rate, and weight decay."""

AVERAGED = 0.05
"""Share of the steps over which weights are averaged."""

EVERY = 200
"""Steps from one keeping of the state to the next."""

Tell = Callable[[int, dict[str, float]], None]


def train_detector(
    family: str,
    sets: Sequence[Sequence[Lesson]],
    steps: int,
    seed: int,
    *,
    shares: Sequence[float] | None = None,
    size: tuple[int, int] | None = None,
    batch: int = BATCH,
    threads: int = 1,
    rate: float = RATE,
    start: dict[str, torch.Tensor] | None = None,
    state: Path | None = None,
    data: str = "",
    tell: Tell | None = None,
) -> Points:
    """Train a detector.

    With one thread the weights are the same, bit by bit, for the same arguments.

    Parameters
    ----------
    family : str
        A key of FAMILIES.
    sets : sequence of sequence of Lesson
        What is learnt from, at one scale. An image is cached as its set caches it.
    steps, seed : int
    shares : sequence of float, or None
        How much of what is learnt from comes from each set. None for as much as it has images.
    size : tuple of int, or None
        Width and height, whole strides, that images are cut or continued to. None for the largest of each: all images
        are looked at for that.
    batch : int
        Images in a step.
    threads : int
        Of torch. Another number gives other last bits.
    rate : float
        Largest learning rate; a part of RATE where the start is one that was trained.
    start : dict of str to Tensor, or None
        Weights (`state_dict`) to begin from, those of its family or of the points alone.
    state : Path or None
        Where the state is kept as the training goes, and taken up again by the same call. It stays, for
        the caller to remove once the network is kept.
    data : str
        What tells these sets, and the start, from others: a state kept for others is not taken up.
    tell : callable or None
        Told every step, counted from 1, and the parts of its loss.

    Returns
    -------
    Points
        The network with the averaged weights, ready to look.

    Raises
    ------
    ValueError
        When there is nothing to learn from.
    InputError
        When the kept state is damaged, or the loss is no number.
    """
    if not any(map(len, sets)):
        raise ValueError("no images: at least one to learn from is allowed")
    torch.set_num_threads(threads)
    cv2.setNumThreads(1)
    network = fresh(family, seed)
    if start is not None:
        network.load_state_dict(start, strict=False)
    network = network.to(memory_format=torch.channels_last)
    kept = 1 - 1 / max(2.0, AVERAGED * steps)

    def average(old: torch.Tensor, new: torch.Tensor, count: torch.Tensor) -> torch.Tensor:
        # The first weights are no better than chance: they must not weigh as much as later ones.
        return old + (1 - torch.clamp((1 + count) / (10 + count), max=kept)) * (new - old)

    averaged = torch.optim.swa_utils.AveragedModel(network, avg_fn=average, use_buffers=True)
    optimiser = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=DECAY)
    # A tenth of ten steps is one, between whose beginning and end torch divides by nought.
    rise = 0.11 if steps == 9 else 0.1
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1, pct_start=rise)
    parts = {"network": network, "averaged": averaged, "optimiser": optimiser, "schedule": schedule}
    job = [family, steps, seed, batch, rate, data, *map(len, sets)]
    first = 0 if state is None else taken_up(state, parts, job)
    if size is None:
        size = canvas([lesson for lessons in sets for lesson in lessons], STRIDE)
    drawn = _batches(sets, _chances(sets, shares), size, batch, seed, range(first, steps))
    network.train()
    for step, (image, lessons) in enumerate(drawn, first):
        losses = network.loss(image, lessons)
        loss = sum(losses.values())
        hold_finite(loss.item(), step + 1)
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimiser.step()
        schedule.step()
        averaged.update_parameters(network)
        if state is not None and step % EVERY == EVERY - 1:
            keep(state, parts, job, step + 1)
        if tell is not None:
            tell(step + 1, {name: part.item() for name, part in losses.items()})
    if state is not None and first < steps:
        keep(state, parts, job, steps)
    return averaged.module.eval()


def fresh(family: str, seed: int) -> Points:
    """A network that has learnt nothing. Torch's own random state is left as it is."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return FAMILIES[family]()


def _chances(sets: Sequence[Sequence[Lesson]], shares: Sequence[float] | None) -> np.ndarray:
    chances = np.array([len(lessons) for lessons in sets], np.float64)
    if shares is not None:
        chances = np.array(shares) * (chances > 0)
    return chances / chances.sum()


def _batches(
    sets: Sequence[Sequence[Lesson]],
    chances: np.ndarray,
    size: tuple[int, int],
    batch: int,
    seed: int,
    steps: range,
) -> Iterator[tuple[torch.Tensor, list[Lesson]]]:
    """What is learnt from at each step, made while the step before is learnt from."""
    grain = noise(seed)

    def made(step: int) -> tuple[torch.Tensor, list[Lesson]]:
        rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(1, step))))
        chosen = rng.choice(len(sets), batch, p=chances)
        lessons = [augmented(sets[which][int(rng.integers(len(sets[which])))], size, rng, grain) for which in chosen]
        return tensor([lesson.image for lesson in lessons]), lessons

    with ThreadPoolExecutor(1) as crew:
        ahead = deque(crew.submit(made, step) for step in steps[:1])
        for step in steps:
            ready = ahead.popleft().result()
            if step + 1 in steps:
                ahead.append(crew.submit(made, step + 1))
            yield ready


def tensor(images: Sequence[np.ndarray]) -> torch.Tensor:
    """Images (H, W, 3) uint8 of one size as a network takes them: (N, 3, H, W), 0 to 1."""
    stacked = torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2)
    return stacked.float().div_(255).contiguous(memory_format=torch.channels_last)
