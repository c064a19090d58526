"""A detector from datasets to files."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Sequence
from pathlib import Path

import torch

from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.files import write
from pavemark.training.detectors.datasets import Lessons, digest, largest
from pavemark.training.detectors.export import exported
from pavemark.training.detectors.network import STRIDE
from pavemark.training.detectors.training import RATE, Tell, fresh, train_detector

FINE = 0.3
"""Share of the learning rate with which weights that have learnt already go on."""


def train(
    family: str,
    sets: Sequence[Sequence[Example]],
    out: Path,
    weights: Path,
    *,
    steps: int,
    seed: int,
    shares: Sequence[float] | None,
    batch: int,
    threads: int,
    pixels_per_metre: float,
    start: Path | None,
    trained_on: str,
    tell: Tell,
) -> None:
    """Train a detector and write it as ONNX, and its weights.

    The state is kept beside `out` as the training goes, and taken up again by the same call.

    Parameters
    ----------
    family, steps, seed, shares, batch, threads, tell
        As for `train_detector`.
    sets : sequence of sequence of Example
    out, weights : Path
        The model, and the weights that `start` may be.
    pixels_per_metre : float
        Scale that images are brought to.
    start : Path or None
        Weights to begin from.
    trained_on : str
        What the file says of its data.

    Raises
    ------
    InputError
        When an image cannot be read, or `start` is no weights of the family.
    """
    begun = None if start is None else _weights(start, family)
    state = out.with_suffix(".state")
    told = [digest(examples) for examples in sets]
    if start is not None:
        told.append(hashlib.sha256(start.read_bytes()).hexdigest())
    network = train_detector(
        family,
        [Lessons(examples, pixels_per_metre) for examples in sets],
        steps,
        seed,
        shares=shares,
        size=largest([example for examples in sets for example in examples], pixels_per_metre, STRIDE),
        batch=batch,
        threads=threads,
        rate=RATE if start is None else FINE * RATE,
        start=begun,
        state=state,
        data=" ".join([*told, f"{pixels_per_metre:g}", *(f"{share:g}" for share in shares or ())]),
        tell=tell,
    )
    made = f"pavemark train detector --family {family} --steps {steps} --batch {batch} --seed {seed}"
    stream = io.BytesIO()
    torch.save(network.state_dict(), stream)
    write(weights, stream.getvalue())
    write(out, exported(network, pixels_per_metre, made, trained_on))
    state.unlink(missing_ok=True)


def _weights(path: Path, family: str) -> dict[str, torch.Tensor]:
    try:
        kept = torch.load(path, weights_only=True)
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except Exception:  # what torch raises for a file that is none is not told anywhere
        kept = None
    if not (isinstance(kept, dict) and all(isinstance(each, torch.Tensor) for each in kept.values())):
        kept = {}
    wanted = fresh(family, 0).state_dict()
    points = fresh("dmpr", 0).state_dict()
    if not (
        points.keys() <= kept.keys()
        and all(kept[name].shape == wanted[name].shape for name in kept.keys() & wanted.keys())
    ):
        raise InputError(
            path, "holds no weights of a detector: a .pt file that pavemark train detector wrote is allowed"
        )
    if not all(torch.isfinite(each).all() for each in kept.values()):
        raise InputError(path, "holds weights that are no numbers: those of a training that went well are allowed")
    return kept
