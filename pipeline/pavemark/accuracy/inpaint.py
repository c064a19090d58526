"""The inpainting stage: every method fills the same self-made holes, and is held against the truth below them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from pavemark import files
from pavemark.accuracy import measures
from pavemark.accuracy.apart import Answer
from pavemark.accuracy.cases import QUICK, Case, Sample, cases, some
from pavemark.accuracy.fills import Crew
from pavemark.accuracy.machine import machine, versions
from pavemark.accuracy.picture import grid
from pavemark.accuracy.report import Report
from pavemark.accuracy.speed import Speed, speeds
from pavemark.accuracy.table import as_csv, counted, markdown, spread
from pavemark.accuracy.watcher import Watcher
from pavemark.errors import InputError

BLANK = (255, 255, 255)
"""What stands in the hole in place of the truth: paint, the worst that could leak."""

PICTURED, TIMED = 6, 5
"""Images in the picture, and images that plates are timed with."""

REFERENCE = "patchmatch"
"""The method that the others are held against, image by image."""


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
        Processor time of the fill, one thread.
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


Fills = list[tuple[Case, dict[str, np.ndarray]]]


def report(sample: Sample, methods: Sequence[str], quick: bool, watcher: Watcher) -> Report:
    """Judge inpainters: inpaint.csv, inpaint.md, inpaint.png and speed.csv.

    Parameters
    ----------
    sample : Sample
    methods : sequence of str
        Names of inpainters.
    quick : bool
        With four images at most, and one to time plates with.
    watcher : Watcher

    Raises
    ------
    InputError
        When a method is not known, or no hole could be filled.
    """
    if quick:
        sample = attrs.evolve(sample, entries=some(sample.entries, QUICK))
    pictured = {entry.name for entry in some(sample.entries, PICTURED)}
    with Crew(methods, watcher.tell) as crew:
        scores, fills = judge(sample, crew, pictured, watcher)
        if not scores:
            raise InputError("accuracy", "no hole could be filled: the lines above say why")
        times = speeds(sample, crew, 1 if quick else TIMED, watcher)
    told = summary(scores, times)
    sheets = {"inpaint.png": files.png(grid(fills, crew.methods))} if fills else {}
    return Report(
        {"inpaint.csv": as_csv(scores, Score), "inpaint.md": told, "speed.csv": as_csv(times, Speed), **sheets}, told
    )


def judge(sample: Sample, crew: Crew, pictured: set[str], watcher: Watcher) -> tuple[list[Score], Fills]:
    """Let every method fill the self-made hole of every image.

    Parameters
    ----------
    sample : Sample
    crew : Crew
    pictured : set of str
        Names of the images whose fills are handed back.
    watcher : Watcher

    Returns
    -------
    scores : list of Score
        Image by image, in the order of the methods; what failed was told of and is in no row.
    fills : list of (Case, dict)
        Of the images to be pictured, by method.
    """
    scores, fills = [], []
    with watcher.of(len(sample.entries)):
        for case in cases(sample, watcher.tell):
            made = {} if case is None else _fills(case, crew, watcher)
            scores += [score(case, method, answer) for method, answer in made.items()]
            if case is not None and case.plate.name in pictured:
                fills.append((case, {method: answer.value for method, answer in made.items()}))
            watcher.step(len(made) < len(crew.methods))
    return scores, fills


def _fills(case: Case, crew: Crew, watcher: Watcher) -> dict[str, Answer]:
    image = case.plate.source.copy()
    image[case.hole.mask] = BLANK
    name = case.plate.name
    return dict(crew.fill(image, case.hole.mask, case.hole.keep_out, lambda line: watcher.tell(f"{name}: {line}")))


def score(case: Case, method: str, answer: Answer) -> Score:
    """Hold a fill against the truth."""
    fill, truth, hole = answer.value, case.plate.source, case.hole.mask
    height, width = hole.shape
    return Score(
        image=case.plate.name,
        method=method,
        width=width,
        height=height,
        hole=int(hole.sum()),
        share=case.hole.share,
        mask_of=case.mask_of,
        psnr=measures.psnr(fill, truth, hole),
        ssim=measures.ssim(fill, truth, hole),
        flip=measures.flip(fill, truth, hole),
        texture=measures.texture(fill, truth, hole),
        step=measures.step(fill, truth, hole, case.beside),
        seconds=answer.seconds,
        peak_mb=answer.peak_mb,
    )


def summary(scores: Sequence[Score], times: Sequence[Speed]) -> str:
    """What inpaint.md says."""
    parts = [
        "# Inpainting, on self-made holes",
        f"{counted(scores)}. {machine()}",
        versions(list(_by_method(scores))),
        "Median (quartiles) over the images; processor time; the most memory that the method's process has held.",
        *standing(scores),
    ]
    if times:
        parts += ["Plates per minute: markings found and hole filled, medians.", timed(times)]
    return "\n\n".join(parts) + "\n"


def standing(scores: Sequence[Score]) -> list[str]:
    """How the methods stand: their scores, and how often each beats the reference where it was among them."""
    methods = {row.method for row in scores}
    if REFERENCE not in methods or len(methods) == 1:
        return [scored(scores)]
    return [
        scored(scores),
        f"Share of the images on which a method does better than {REFERENCE}:",
        compared(scores),
    ]


def scored(scores: Sequence[Score]) -> str:
    """A row a method: each measure's median and quartiles."""
    head = ("method", "images", "PSNR dB ↑", "SSIM ↑", "FLIP ↓", "texture → 1", "step → 0", "seconds", "MB")
    rows = []
    for method, of in _by_method(scores).items():
        values = (
            spread([getattr(row, name) for row in of], digits)
            for name, digits in (("psnr", 1), ("ssim", 3), ("flip", 3), ("texture", 2), ("step", 2), ("seconds", 2))
        )
        rows.append((method, str(len(of)), *values, f"{max(row.peak_mb for row in of):.0f}"))
    return markdown(head, rows)


def compared(scores: Sequence[Score]) -> str:
    """A row a method: the share of the images on which it does better than the reference."""
    by_method = _by_method(scores)
    reference = {row.image: row for row in by_method.pop(REFERENCE)}
    rows = []
    for method, of in by_method.items():
        pairs = [(row, reference[row.image]) for row in of if row.image in reference]
        rows.append((method, *(_share(pairs, better) for better in BETTER.values())))
    return markdown(("method", *BETTER), rows)


def _share(pairs: Sequence[tuple[Score, Score]], error) -> str:
    known = [(error(row), error(other)) for row, other in pairs]
    known = [(a, b) for a, b in known if not (np.isnan(a) or np.isnan(b))]
    return f"{np.mean([a < b for a, b in known]):.0%}" if known else "–"


BETTER = {
    "PSNR": lambda row: -row.psnr,
    "SSIM": lambda row: -row.ssim,
    "FLIP": lambda row: row.flip,
    "texture": lambda row: abs(np.log(max(row.texture, 1e-9))),
    "step": lambda row: abs(row.step),
    "seconds": lambda row: row.seconds,
}
"""What is smaller for the better of two fills; texture is as bad at half the truth's energy as at twice."""


def timed(times: Sequence[Speed]) -> str:
    """A row for each size and way to make a plate."""
    head = ("pixels", "markings found by", "filled by", "images", "finding s", "filling s", "plates a minute")
    return markdown(
        head,
        [
            (
                f"{row.width}×{row.height}",
                row.segmenter,
                row.inpainter,
                str(row.images),
                f"{row.segment_seconds:.3f}",
                f"{row.fill_seconds:.3f}",
                f"{row.plates_per_minute:.1f}",
            )
            for row in times
        ],
    )


def _by_method(scores: Sequence[Score]) -> Mapping[str, list[Score]]:
    by_method: dict[str, list[Score]] = {}
    for row in scores:
        by_method.setdefault(row.method, []).append(row)
    return by_method
