"""From a run to a detector: the only module of the study that needs torch."""

from __future__ import annotations

import io
from pathlib import Path

import torch

from pavemark.study.runs import Run
from pavemark.training.detectors.datasets import Lessons
from pavemark.training.detectors.export import exported
from pavemark.training.detectors.training import RATE, train_detector

LICENCE = "as that of the images it learned from, which may be none"


def learnt(run: Run, begun: bytes | None, state: Path) -> tuple[bytes, bytes]:
    """Train the detector of a run, with one thread.

    Parameters
    ----------
    run : Run
    begun : bytes or None
        Weights to begin with, as they are returned.
    state : Path
        Where the training is kept as it goes.

    Returns
    -------
    bytes, bytes
        The ONNX file, and its weights for others to begin with.
    """
    lessons = Lessons(run.examples, run.scale)
    network = train_detector(
        run.training.family,
        [lessons],
        run.steps,
        run.seed,
        batch=run.training.batch,
        threads=1,
        rate=RATE if begun is None else RATE / 10,
        start=None if begun is None else torch.load(io.BytesIO(begun), weights_only=True),
        state=state,
    )
    stream = io.BytesIO()
    torch.save(network.state_dict(), stream)
    told = f"{len(lessons)} images, seed {run.seed}"
    return exported(network, run.scale, "pavemark study", told, LICENCE), stream.getvalue()
