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
    torch.save({"job": _job(job), "step": step, "states": states}, stream)
    write(path, stream.getvalue())


def taken_up(path: Path, parts: Mapping[str, Any], job: Sequence) -> int:
    """The step that a job has come to, its parts put into their states; 0 where no state is kept.

    Raises
    ------
    InputError
        When the file is damaged, or is of another job: hours of work are not written over.
    """
    if not path.exists():
        return 0
    try:
        kept = torch.load(path, weights_only=True)
        alike, step = kept["job"] == _job(job), kept["step"]
        if alike:
            for name, part in parts.items():
                part.load_state_dict(kept["states"][name])
    except Exception:  # what torch raises for a file that is none is not told anywhere
        raise InputError(path, "is no whole state of a training: remove it, and it begins anew") from None
    if not alike:
        what = "with other options, of other images or by another version of torch"
        raise InputError(path, f"a training {what} was stopped at step {step}: remove it, or use another --out")
    return step


def _job(job: Sequence) -> list:
    """What a state is of: another version of torch gives other last bits."""
    return [str(torch.__version__), *job]


def hold_finite(loss: float, step: int) -> None:
    """Hold that a training has not gone astray.

    Raises
    ------
    InputError
        When the loss of a step, counted from 1, is no number.
    """
    if not torch.isfinite(torch.tensor(loss)):
        raise InputError(f"step {step}", f"the loss is {loss}: a finite number is allowed; another --seed may do")
