"""Synthetic images of a study: plates of the train places, and a dataset of each pool on them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from pavemark.detect.example import Example
from pavemark.detect.reading import examples
from pavemark.errors import InputError
from pavemark.geometry.elastic import displace
from pavemark.job import plates
from pavemark.job.config import Inputs, Job, merge, read
from pavemark.job.journal import Shard
from pavemark.job.progress import shown
from pavemark.job.run import Machine, run
from pavemark.records import from_json
from pavemark.scene import Scene
from pavemark.study.design import Study
from pavemark.study.places import name, write_views

WORKER = (sys.executable, "-m", "pavemark.job.worker")
"""Starts a worker with the renderer that is installed."""


def make(study: Study, train: Sequence[Example], folder: Path, workers: int) -> dict[str, Path]:
    """Make what the pools of a study still lack that its rows learn from.

    Parameters
    ----------
    study : Study
    train : sequence of Example
        Real images of the train places.
    folder : Path
        Of the study: views, plates and pools go there.
    workers : int

    Returns
    -------
    dict of str to Path
        The dataset of each pool.

    Raises
    ------
    InputError
        When a job cannot be done.
    KeyboardInterrupt
        When one was stopped by a signal: the same call goes on with it.
    """
    views, stock = folder / "views", folder / "plates"
    jobs = {pool: job(study, pool, stock) for pool in study.pools}  # a table that is wrong is told before hours of work
    made = there(study, folder)
    if not made:
        return {}
    write_views(train, study.frame, views)
    inputs = Inputs(images=str(views), scale=study.scale)
    _done(plates.make(inputs, stock, Machine(plates.WORKER, workers), shown(False, "plates")))
    for pool in made:
        print(f"pool {pool}", flush=True)
        _done(run(jobs[pool], made[pool], Shard(), Machine(WORKER, workers), shown(False)))
    return made


def there(study: Study, folder: Path) -> dict[str, Path]:
    """Where the dataset of each pool is that a row learns from; nothing is made."""
    used = {pool for row in study.rows for pool in row.pools}
    return {pool: folder / "pools" / pool for pool in study.pools if pool in used}


def job(study: Study, pool: str, stock: Path) -> Job:
    """The job of a pool.

    Raises
    ------
    InputError
        When its tables are not those of a job.
    """
    tables = _tables(study, pool)
    try:
        return read(None, merge(tables, {"plates": str(stock), "formats": ["dmpr"]}))
    except InputError as error:
        raise InputError(f"pools.{pool}", error.what) from None


def _tables(study: Study, pool: str) -> dict[str, Any]:
    own = dict(study.pools[pool])
    like = own.pop("like", None)
    if like is None:
        return merge(study.every_pool, own)
    before = list(study.pools)[: list(study.pools).index(pool)]
    if like not in before:
        raise InputError(
            f"pools.{pool}", f"like = {like!r}: a pool before it is allowed: {', '.join(before) or 'none'}"
        )
    return merge(_tables(study, like), own)


def learnt_from(pool: Path, train: Sequence[Example]) -> list[Example]:
    """The labelled images of a pool, each of a plate of a train place.

    Where an image has its plate's own markings painted anew it has no slots of its own, and the marking points are
    those of the real image, moved as its curvature moves the paint.

    Raises
    ------
    InputError
        When the plate of an image is not of a train place: what is judged by must not be learnt from.
    """
    real = {name(example): example for example in train}
    found = []
    for example in examples(pool):
        plate = Path(example.groups["plate"]).stem
        if plate not in real:
            raise InputError(pool, f"{example.name}: its plate, {plate}, is of no train place: those alone are allowed")
        place = real[plate].groups["place"]
        evolved = attrs.evolve(example, name=f"{pool.name}/{example.name}", groups=example.groups | {"place": place})
        if example.groups["kind"] == "original":
            scene = from_json(Scene, pool / "scenes" / f"{example.image.stem}.json")
            evolved = attrs.evolve(
                evolved, points=_own_points(real[plate], scene), directions=None, l_shaped=None, slots=None, known=True
            )
        found.append(evolved)
    return found


def _own_points(real: Example, scene: Scene) -> np.ndarray:
    """The marking points of a real image where the scene has painted them, those in the picture."""
    frame = scene.plate.frame
    ratio = (frame.width / real.frame.width, frame.height / real.frame.height)
    moved = frame.to_image(displace(scene.curvature, frame.to_world(real.points * ratio)))
    return moved[frame.contains(moved)]


def _done(code: int) -> None:
    # 1 says that images were left out, each told already; more, that a signal stopped it, which is told as well.
    if code > 1:
        raise KeyboardInterrupt
