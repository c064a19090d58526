"""The inpainting stage: every method fills the same self-made holes, and is held against the truth below them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from typing import Protocol

import attrs
import numpy as np

from pavemark.accuracy import measures
from pavemark.accuracy.apart import Apart
from pavemark.accuracy.cases import Case, Sample, cases
from pavemark.background.inpainting import inpainter
from pavemark.errors import InputError


class Watcher(Protocol):
    """Who is told how it goes: `pavemark.job.progress.Progress` is one."""

    def of(self, total: int) -> AbstractContextManager:
        """Entered while so many images are worked on."""
        ...

    def step(self, lacking: bool) -> None:
        """One image is done, or will be lacking."""
        ...

    def tell(self, line: str) -> None:
        """Report what went wrong."""
        ...


@attrs.frozen
class Score:
    """How a method filled a hole: a row of inpaint.csv.

    Attributes
    ----------
    image, method : str
    width, height : int
        Of the picture, in pixels.
    hole : int
        Pixels filled.
    share : float
        Share of the marking's hole that found bare ground.
    mask_of : str
        The image whose marking lent the hole its shape.
    psnr, ssim, flip, texture, step : float
        See `pavemark.accuracy.measures`; nan where a measure does not apply.
    seconds : float
        Wall time of the fill, one thread.
    peak_mb : float
        Most memory the method's process has held up to then, in 10⁶ bytes.
    """

    image: str
    method: str
    width: int
    height: int
    hole: int
    share: float
    mask_of: str
    psnr: float
    ssim: float
    flip: float
    texture: float
    step: float
    seconds: float
    peak_mb: float


def fill(method: str, image: np.ndarray, hole: np.ndarray, keep_out: np.ndarray) -> np.ndarray:
    """As the inpainter of that name fills it. A function of a module, for a process of its own."""
    return inpainter(method).fill(image, hole, keep_out)


def judge(
    sample: Sample, methods: Sequence[str], pictured: Sequence[str], watcher: Watcher
) -> tuple[list[Score], list[tuple[Case, dict[str, np.ndarray]]]]:
    """Let every method fill the self-made hole of every image.

    Each method works in a process of its own, one after the other, and has filled a small hole before it is measured:
    to load a library or a network is not counted.

    Parameters
    ----------
    sample : Sample
    methods : sequence of str
        Names of inpainters.
    pictured : sequence of str
        Names of the images whose fills are handed back.
    watcher : Watcher

    Returns
    -------
    scores : list of Score
        Image by image, in the order of the methods; what failed was told of and is in no row.
    fills : list of (Case, dict)
        Of the images to be pictured, by method.

    Raises
    ------
    InputError
        When a method's name is not known.
    """
    for method in methods:
        inpainter(method)
    scores, fills = [], []
    with ExitStack() as stack:
        crew = {method: stack.enter_context(Apart(fill, method)) for method in methods}
        ready = [method for method in methods if _ready(method, crew[method], watcher)]
        with watcher.of(len(sample.entries)):
            for case in cases(sample, watcher.tell):
                made = {} if case is None else dict(_filled(case, ready, crew, watcher))
                scores += [row for row, _ in made.values()]
                if case is not None and case.plate.name in pictured:
                    fills.append((case, {method: result for method, (_, result) in made.items()}))
                watcher.step(len(made) < len(methods))
    return scores, fills


def score(case: Case, method: str, result: np.ndarray, seconds: float, peak_mb: float) -> Score:
    """Hold a fill against the truth."""
    truth, hole = case.plate.source, case.hole.mask
    height, width = hole.shape
    return Score(
        image=case.plate.name,
        method=method,
        width=width,
        height=height,
        hole=int(hole.sum()),
        share=case.hole.share,
        mask_of=case.mask_of,
        psnr=measures.psnr(result, truth, hole),
        ssim=measures.ssim(result, truth, hole),
        flip=measures.flip(result, truth, hole),
        texture=measures.texture(result, truth, hole),
        step=measures.step(result, truth, hole, case.beside),
        seconds=seconds,
        peak_mb=peak_mb,
    )


def _ready(method: str, apart: Apart, watcher: Watcher) -> bool:
    image = np.full((64, 64, 3), 128, np.uint8)
    hole = np.zeros((64, 64), bool)
    hole[30:34, 30:34] = True
    try:
        apart(method, image, hole, np.zeros_like(hole))
    except InputError as error:
        watcher.tell(f"{error}; the method is left out")
        return False
    return True


def _filled(
    case: Case, methods: Sequence[str], crew: dict[str, Apart], watcher: Watcher
) -> Iterator[tuple[str, tuple[Score, np.ndarray]]]:
    for method in methods:
        # The real marking below the hole's truth is nowhere near; what lies in the hole itself must not be seen.
        image = case.plate.source.copy()
        image[case.hole.mask] = BLANK
        try:
            answer = crew[method](method, image, case.hole.mask, case.hole.keep_out)
        except InputError as error:
            watcher.tell(f"{case.plate.name}: {error}")
            continue
        yield method, (score(case, method, answer.value, answer.seconds, answer.peak_mb), answer.value)


BLANK = (255, 255, 255)
"""What stands in the hole in place of the truth: paint, the worst that could leak."""
