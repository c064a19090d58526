"""The residue stage: every method takes the real markings off, and what is left of them is looked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import attrs
import numpy as np

from pavemark.accuracy.cases import QUICK, Sample, some
from pavemark.accuracy.fills import Crew
from pavemark.accuracy.holes import around
from pavemark.accuracy.machine import machine, versions
from pavemark.accuracy.report import Report
from pavemark.accuracy.residue import BINS, Residue, residue
from pavemark.accuracy.table import as_csv, counted, markdown, spread
from pavemark.accuracy.watcher import Watcher
from pavemark.background.index import EXTENSIONS, listed
from pavemark.background.reading import read_image
from pavemark.errors import InputError
from pavemark.plate import Plate

BEFORE = "before"
"""The image as taken: what a trace of everything looks like."""


@attrs.frozen
class Trace:
    """A row of residue.csv: see `Residue`.

    Attributes
    ----------
    image, method : str
    """

    image: str
    method: str
    paint: float
    left: float
    noise: float
    worst: float
    z: float
    auc: float
    rim: float
    texture: float


@attrs.frozen
class Profile:
    """A row of profile.csv: what stands out between two distances from the stroke's edge (metres), in ΔE*ab."""

    image: str
    method: str
    nearer: float
    further: float
    contrast: float


def report(
    sample: Sample, methods: Sequence[str], cleaned: Mapping[str, Path], quick: bool, watcher: Watcher
) -> Report:
    """Look for residue: residue.csv, residue.md and profile.csv.

    Parameters
    ----------
    sample : Sample
    methods : sequence of str
        Names of inpainters.
    cleaned : mapping of str to Path
        Folders of images that others have cleaned, by a name to call them by; files of the images' own names.
    quick : bool
        With four images at most.
    watcher : Watcher

    Raises
    ------
    InputError
        When a method or a folder is not known, or nothing could be measured.
    """
    if quick:
        sample = attrs.evolve(sample, entries=some(sample.entries, QUICK))
    others = {name: listed(folder, EXTENSIONS, "image") for name, folder in cleaned.items()}
    for name, there in others.items():
        if not any(entry.name in there for entry in sample.entries):
            raise InputError(cleaned[name], f"has no image that is called as one of those judged ({name})")
    found: list[tuple[str, str, Residue]] = []
    with Crew(methods, watcher.tell) as crew, watcher.of(len(sample.entries)):
        for entry in sample.entries:
            try:
                rows = list(_residues(sample.plate(entry), crew, others, watcher))
            except InputError as error:
                watcher.tell(str(error))
                rows = []
            found += rows
            watcher.step(not rows)
    if not found:
        raise InputError("accuracy", "no residue could be measured: the lines above say why")
    traces = [
        Trace(image, method, **attrs.asdict(one, filter=lambda field, _: field.name != "profile"))
        for image, method, one in found
    ]
    profiles = [
        Profile(image, method, *between, contrast)
        for image, method, one in found
        for between, contrast in zip(pairwise(BINS), one.profile, strict=True)
    ]
    told = summary(traces, profiles, crew.methods)
    files = {"residue.csv": as_csv(traces, Trace), "residue.md": told, "profile.csv": as_csv(profiles, Profile)}
    return Report(files, told)


def _residues(
    plate: Plate, crew: Crew, others: Mapping[str, Mapping[str, Path]], watcher: Watcher
) -> Iterator[tuple[str, str, Residue]]:
    for method, after in _cleaned(plate, crew, others, watcher):
        found = residue(plate.source, after, plate.markings, plate.ground, plate.frame)
        if found is None:
            watcher.tell(f"{plate.name}: no paint stands out, or bare ground has no room for the same strokes")
            return
        yield plate.name, method, found


def _cleaned(
    plate: Plate, crew: Crew, others: Mapping[str, Mapping[str, Path]], watcher: Watcher
) -> Iterator[tuple[str, np.ndarray]]:
    yield BEFORE, plate.source
    for name, files in others.items():
        if plate.name in files:
            after = read_image(files[plate.name])
            if after.shape != plate.source.shape:
                size, wanted = (f"{shape[1]}×{shape[0]}" for shape in (after.shape, plate.source.shape))
                raise InputError(files[plate.name], f"is {size} pixels: the image is {wanted}")
            yield name, after
    hole = around(plate.markings, plate.frame) & plate.ground
    told = crew.fill(plate.source, hole, ~plate.ground, lambda line: watcher.tell(f"{plate.name}: {line}"))
    for method, answer in told:
        yield method, answer.value


def summary(traces: Sequence[Trace], profiles: Sequence[Profile], used: Sequence[str]) -> str:
    """What residue.md says; `used` are the inpainters among the methods."""
    head = ("method", "images", "paint", "left → 0", "worst tenth", "ground's noise", "z", "AUC → 0.5", "rim → 0")
    names = ("paint", "left", "worst", "noise", "z", "auc", "rim")
    methods = list(dict.fromkeys(row.method for row in traces))
    rows, lines = [], []
    for method in methods:
        of = [row for row in traces if row.method == method]
        texture = spread([row.texture for row in of], 2)
        rows.append((method, str(len(of)), *(spread([getattr(row, name) for row in of], 2) for name in names), texture))
        there = [row for row in profiles if row.method == method]
        means = [[row.contrast for row in there if row.nearer == low] for low in BINS[:-1]]
        lines.append((method, *(f"{np.nanmean(values):.2f}" if np.isfinite(values).any() else "–" for values in means)))
    parts = [
        "# What is left of removed markings",
        f"{counted(traces)}. {machine()}",
        versions(used),
        "Median (quartiles) over the images, in ΔE*ab along the paint's colour.",
        markdown((*head, "texture → 1"), rows),
        "By the distance from the stroke's edge in cm, below 0 within it; mean over the images.",
        markdown(("method", *(f"{100 * low:.0f} to {100 * high:.0f}" for low, high in pairwise(BINS))), lines),
    ]
    return "\n\n".join(parts) + "\n"
