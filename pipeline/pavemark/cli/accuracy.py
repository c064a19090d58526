"""`pavemark accuracy`: how good and how dear each stage is, measured on this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import click

from pavemark import files
from pavemark.accuracy.cases import Sample
from pavemark.accuracy.report import Report
from pavemark.background.index import index
from pavemark.background.inpainting import choices, inpainter
from pavemark.cli.words import Folder
from pavemark.errors import InputError
from pavemark.job.config import Inputs, merge, read_inputs, setting
from pavemark.job.folder import spare
from pavemark.job.progress import Progress, shown
from pavemark.job.worker import installed_renderer

INCOMPLETE = 1

ALL = "all"
OWN = ("render", "effects", "blend", "geometry", "labels")
OF_IMAGES = ("inpaint", "residue")
STAGES = (*OWN, *OF_IMAGES, ALL)
CALIBRATION = "calibration"

PAGE = "report.html"


class _Cleaned(click.ParamType):
    name = "NAME=DIR"

    def convert(self, value, param, ctx):
        name, equals, folder = value.partition("=")
        if not (name and equals and folder):
            self.fail(f"{value!r}: allowed is NAME=DIR, such as lama=others/lama", param, ctx)
        return name, Path(folder)


@click.command()
@click.option("--stage", type=click.Choice(STAGES), default=ALL, show_default=True, help="What is judged.")
@click.option("--out", metavar="REPORT", required=True, type=Folder(path_type=Path), help="Folder of the report.")
@click.option("--images", metavar="DIR", type=Folder(), help="Folder of real AVM images, for inpaint and residue.")
@click.option("--masks", metavar="DIR", type=Folder(), help="Folder of their masks: PNGs of the same names.")
@click.option("--methods", metavar="A,B", help="Inpainters, by name.  [all there are]")
@click.option("--cleaned", metavar="NAME=DIR", multiple=True, type=_Cleaned(), help="For residue: cleaned by others.")
@click.option("--scale", type=float, metavar="PX/M", help="Pixels per metre of the images.  [60]")
@click.option("--metres-per-pixel", type=float, metavar="M", help="The same, the other way round.")
@click.option("--segmenter", metavar="NAME", help="What finds markings and ground where there are no masks.")
@click.option("--set", "settings", metavar="FIELD=VALUE", multiple=True, help="A line of a job file: mask.ground = [0]")
@click.option("--calibrate", is_flag=True, help="Measure the table that render --max-error goes by: REPORT/rays.json.")
@click.option("--quick", is_flag=True, help="Less of everything: a few minutes, four images at most.")
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
def accuracy(
    stage: str,
    out: Path,
    methods: str | None,
    cleaned: tuple[tuple[str, Path], ...],
    settings: tuple[str, ...],
    calibrate: bool,
    quick: bool,
    quiet: bool,
    **options,
) -> int:
    """Measure on this machine what accuracy costs in time.

    Stages render, blend, geometry and labels need no images: error against time for rays, solvers, outlines and label
    files, in figures (REPORT/render.svg …) and tables (render.csv, render.md …). Stages inpaint and residue judge what
    fills the ground where markings were, on images of yours. REPORT/report.html has all of it on one page.

    --calibrate measures another thing, and alone: what rays promise, for render --max-error E --calibration
    REPORT/rays.json.
    """
    asked = f"--stage {stage}"
    if calibrate:
        if stage != ALL:
            raise InputError("--calibrate", f"says nothing to {asked}: it is a report of its own")
        stage, asked = CALIBRATION, "--calibrate"
    if cleaned and stage not in ("residue", ALL):
        raise InputError("--cleaned", f"says nothing to {asked}: --stage residue is allowed with it")
    twice = [name for name, _ in cleaned if [other for other, _ in cleaned].count(name) > 1]
    if twice:
        raise InputError("--cleaned", f"{twice[0]} is given twice: another name is allowed")
    _hold_other_names(name for name, _ in cleaned)
    for option, given in (("--images", options["images"]), ("--masks", options["masks"]), ("--methods", methods)):
        if given is not None and stage in (*OWN, CALIBRATION):
            raise InputError(option, f"says nothing to {asked}: {', '.join(OF_IMAGES)} or {ALL} is allowed with it")
    for option, given in (("--masks", options["masks"]), ("--methods", methods), ("--cleaned", cleaned or None)):
        if given is not None and options["images"] is None:
            raise InputError(option, NO_IMAGES)
    told: dict = {}
    for text in settings:
        told = merge(told, setting(text))
    inputs = read_inputs(told | {name: value for name, value in options.items() if value is not None})
    spare(out, (), (inputs.images, inputs.masks, *(folder for _, folder in cleaned)), "")
    files.writable(out)
    runs, pictures = _Counting(shown(quiet, "runs")), _Counting(shown(quiet))
    if stage in OF_IMAGES and not inputs.images:
        raise InputError(asked, NO_IMAGES)
    sample = _sample(inputs, pictures) if inputs.images else None
    judges = _judges(sample, _methods(methods) if sample else (), dict(cleaned), quick, runs, pictures)
    made, left_out = {}, ()
    if stage != ALL:
        made[stage] = judges[stage]()
    else:
        # A stage takes minutes to hours: what is judged is written before the next begins.
        made, left_out = _all(judges, runs, lambda made, left_out: _write(out, made, left_out))
    _write(out, made, left_out)
    runs.end(_summary(out, made, left_out))
    return INCOMPLETE if runs.lines or pictures.lines else 0


def _hold_other_names(cleaned: Iterable[str]) -> None:
    """Hold that none is called as a row of our own, with which its figures would be mixed."""
    from pavemark.accuracy.traces import BEFORE  # noqa: PLC0415 - as in _judges

    for name in cleaned:
        if name in (BEFORE, *choices()):
            raise InputError("--cleaned", f"{name} is what a row of our own is called: another name is allowed")


def _methods(given: str | None) -> tuple[str, ...]:
    """The inpainters asked for, or all whose files are there."""
    if given is not None:
        return tuple(dict.fromkeys(name.strip() for name in given.split(",") if name.strip())) or _none()
    found = []
    for name in choices():
        try:
            inpainter(name)
        except InputError:
            continue
        found.append(name)
    return tuple(found)


def _none() -> tuple[str, ...]:
    raise InputError("--methods", f"it is empty: allowed {', '.join(choices())}")


NO_IMAGES = "--images is missing: a folder of AVM images is needed"


def _sample(inputs: Inputs, watcher: _Counting) -> Sample:
    entries, unmatched = index(Path(inputs.images), None if inputs.masks is None else Path(inputs.masks))
    for path in unmatched:
        watcher.tell(f"{path}: nothing has its name in the other folder")
    return Sample(entries, inputs.pixels_per_metre, inputs.mask, inputs.segmenter)


def _judges(
    sample: Sample | None,
    methods: tuple[str, ...],
    cleaned: dict[str, Path],
    quick: bool,
    runs: _Counting,
    pictures: _Counting,
) -> dict[str, Callable[[], Report]]:
    """What judges each stage for which there is what it needs."""
    # matplotlib and the libraries of rivals take a second to load, and the other commands have no use for them.
    from pavemark.accuracy import (  # noqa: PLC0415
        blend,
        calibrate,
        effects,
        geometry,
        inpaint,
        labels,
        render,
        traces,
    )

    own = {
        "render": lambda: render.report(installed_renderer, quick, runs),
        "effects": lambda: effects.report(installed_renderer, quick, runs),
        "blend": lambda: blend.report(quick, runs),
        "geometry": lambda: geometry.report(quick, runs),
        "labels": lambda: labels.report(quick, runs),
    }
    of_images = {
        "inpaint": lambda: inpaint.report(sample, methods, quick, pictures),
        "residue": lambda: traces.report(sample, methods, cleaned, quick, pictures),
    }
    alone = {CALIBRATION: lambda: calibrate.report(installed_renderer, quick, runs)}
    return own | (of_images if sample else {}) | alone


def _all(
    judges: dict[str, Callable[[], Report]],
    watcher: _Counting,
    keep: Callable[[dict[str, Report], tuple[str, ...]], None],
) -> tuple[dict[str, Report], tuple[str, ...]]:
    """The reports of all that can be judged, and a line for each stage that cannot; kept as they come."""
    made, left_out = {}, []
    for stage in (name for name in judges if name != CALIBRATION):
        try:
            made[stage] = judges[stage]()
        except InputError as error:
            left_out.append(f"{stage}: not run: {error}")
            watcher.tell(left_out[-1])
        else:
            keep(made, tuple(left_out))
    left_out += [f"{stage}: not run: {NO_IMAGES}" for stage in OF_IMAGES if stage not in judges]
    return made, tuple(left_out)


def _write(out: Path, made: dict[str, Report], left_out: tuple[str, ...]) -> None:
    from pavemark.accuracy.page import page  # noqa: PLC0415 - as above

    for report in made.values():
        for name, data in report.files.items():
            files.write(out / name, data)
    files.write(out / PAGE, page(made, left_out))


def _summary(out: Path, made: dict[str, Report], left_out: tuple[str, ...]) -> str:
    written = [str(out / name) for report in made.values() for name in report.files]
    told = [report.told for report in made.values()]
    return "\n".join([*told, *left_out, ", ".join([*written, str(out / PAGE)])])


class _Counting:
    """A progress that counts what went wrong."""

    def __init__(self, progress: Progress) -> None:
        self.lines = 0
        self.of, self.step, self.end = progress.of, progress.step, progress.end
        self._tell = progress.tell

    def tell(self, line: str) -> None:
        self.lines += 1
        self._tell(line)
