"""The inpainters at work, each in a process of its own, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack

import numpy as np

from pavemark.accuracy.apart import Answer, Apart
from pavemark.background.inpainting import inpainter
from pavemark.errors import InputError


class Crew:
    """A process an inpainter.

    Parameters
    ----------
    methods : sequence of str
        Names of inpainters.
    refuse : callable
        Told, in a line, of each that cannot fill even a small hole; it is left out.

    Attributes
    ----------
    methods : tuple of str
        Those that work. Each has filled a hole: to load a library or a network is not counted any more.

    Raises
    ------
    InputError
        When a name is not known.
    """

    def __init__(self, methods: Sequence[str], refuse: Callable[[str], None]) -> None:
        for method in methods:
            inpainter(method)
        self._refuse = refuse
        self._wanted = tuple(methods)
        self.methods: tuple[str, ...] = ()

    def __enter__(self) -> Crew:
        with ExitStack() as stack:
            self._processes = {method: stack.enter_context(Apart(fill, method)) for method in self._wanted}
            self.methods = tuple(method for method in self._wanted if self._works(method))
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def fill(
        self, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray, refuse: Callable[[str], None]
    ) -> Iterator[tuple[str, Answer]]:
        """Let each fill a hole; yields method and answer, and tells of those that fail."""
        for method in self.methods:
            try:
                yield method, self._processes[method](method, image, hole, keep_out)
            except InputError as error:
                refuse(str(error))

    def _works(self, method: str) -> bool:
        image = np.full((64, 64, 3), 128, np.uint8)
        hole = np.zeros((64, 64), bool)
        hole[30:34, 30:34] = True
        try:
            self._processes[method](method, image, hole, np.zeros_like(hole))
        except InputError as error:
            self._refuse(f"{error}; the method is left out")
            return False
        return True


def fill(method: str, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
    """As the inpainter of that name fills it: a function that a process of its own can import."""
    return inpainter(method).fill(image, hole, keep_out)
