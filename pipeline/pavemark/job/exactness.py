"""How exact a job's images are to be: its `max_error`, and the table that says what that takes."""

from __future__ import annotations

import math
from pathlib import Path

import attrs

from pavemark.calibration import Calibration, read, shipped
from pavemark.errors import InputError
from pavemark.job.config import Job
from pavemark.plate import Plate
from pavemark.records import within
from pavemark.scene import Scene


@attrs.frozen
class Exactness:
    """What a job promises of the edges of its markings.

    Attributes
    ----------
    error : float
        8-bit levels, see `pavemark.calibration.Calibration.fewest`.
    table : Calibration
    """

    error: float = attrs.field(validator=within(0.0, 255.0))
    table: Calibration

    def met(self, scene: Scene, plate: Plate) -> Scene:
        """The scene with the rays that it takes."""
        return attrs.evolve(scene, rays=self.table.fewest(scene, plate, self.error))


def exactness(job: Job) -> Exactness | None:
    """What a job promises; None where it asks for nothing.

    Raises
    ------
    InputError
        When its table cannot be used, or no number of rays in it meets the error.
    """
    if job.max_error is None:
        if job.calibration is not None:
            raise InputError("calibration", f"{job.calibration}: says nothing without max_error")
        return None
    table = shipped() if job.calibration is None else read(Path(job.calibration))
    if job.max_error < table.least:
        raise InputError(
            "max_error",
            f"{job.max_error:g} 8-bit levels: allowed from {_up(table.least):g}, the least that can be promised, "
            f"with {table.rays[-1].number} rays a pixel",
        )
    return Exactness(job.max_error, table)


def _up(error: float) -> float:
    """A number to read that is allowed itself: rounded up to hundredths."""
    return math.ceil(100 * error) / 100
