"""The state of a training: kept beside what it makes, so that the same call goes on where it was cut off."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch

from pavemark.errors import InputError
from pavemark.files import write


def keep(path: Path, parts: Mapping[str, Any], job: Sequence, step: int) -> None:
    """Keep the states of all parts (networks, optimisers, schedules) after so many steps of a job.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    stream = io.BytesIO()
    states = {name: part.state_dict() for name, part in parts.items()}
    torch.save({"job": list(job), "step": step, "states": states}, stream)
    write(path, stream.getvalue())


def taken_up(path: Path, parts: Mapping[str, Any], job: Sequence) -> int:
    """The step that a job has come to, its parts put into their states; 0 where no state of it is kept.

    Raises
    ------
    InputError
        When the file is damaged.
    """
    if not path.exists():
        return 0
    try:
        kept = torch.load(path, weights_only=True)
        if kept["job"] != list(job):
            return 0
        for name, part in parts.items():
            part.load_state_dict(kept["states"][name])
        return kept["step"]
    except Exception:  # what torch raises for a file that is none is not told anywhere
        raise InputError(path, "is no whole state of a training: remove it, and it begins anew") from None


def hold_finite(loss: float, step: int) -> None:
    """Hold that a training has not gone astray.

    Raises
    ------
    InputError
        When the loss of a step, counted from 1, is no number.
    """
    if not torch.isfinite(torch.tensor(loss)):
        raise InputError(f"step {step}", f"the loss is {loss}: a finite number is allowed; another --seed may do")
