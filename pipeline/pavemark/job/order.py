"""Which plate serves which image: every input once, in an order of its own, before any comes again."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

PLATES = 100
"""The stream of the order; no stage of an image has this number."""


def place(index: int, inputs: int, seed: int) -> int:
    """The input that image `index` is made from.

    Parameters
    ----------
    index : int
        Number of the image in its job.
    inputs : int
        How many inputs there are.
    seed : int
        Of the job.

    Returns
    -------
    int
        0 to `inputs` - 1.

    Examples
    --------
    >>> sorted(place(index, 5, seed=7) for index in range(5, 10))
    [0, 1, 2, 3, 4]
    """
    epoch, turn = divmod(index, inputs)
    return int(_permutation(epoch, inputs, seed)[turn])


@lru_cache(maxsize=4)
def _permutation(epoch: int, inputs: int, seed: int) -> np.ndarray:
    stream = np.random.SeedSequence(seed, spawn_key=(epoch, PLATES))
    return np.random.Generator(np.random.PCG64(stream)).permutation(inputs)
