"""`pavemark accuracy`: how good and how dear each stage is, measured on this machine."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
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
from pavemark.job.progress import Progress, shown
from pavemark.job.worker import installed_renderer

INCOMPLETE = 1

ALL = "all"
OWN, OF_IMAGES = ("render", "blend", "geometry"), ("inpaint", "residue")
STAGES = (*OWN, *OF_IMAGES, ALL)

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
@click.option("--quick", is_flag=True, help="Less of everything: about a minute, four images at most.")
@click.option("--quiet", is_flag=True, help="Say only what goes wrong.")
def accuracy(
    stage: str,
    out: Path,
    methods: str | None,
    cleaned: tuple[tuple[str, Path], ...],
    settings: tuple[str, ...],
    quick: bool,
    quiet: bool,
    **options,
) -> int:
    """Measure on this machine what accuracy costs in time.

    Stages render, blend and geometry need no images: error against time for rays, solvers and outlines, in figures
    (REPORT/render.svg …) and tables (render.csv, render.md …). Stages inpaint and residue judge what fills the ground
    where markings were, on images of yours. REPORT/report.html has all of it on one page.
    """
    _writable(out)
    told: dict = {}
    for text in settings:
        told = merge(told, setting(text))
    inputs = read_inputs(told | {name: value for name, value in options.items() if value is not None})
    watcher = _Counting(shown(quiet))
    if stage in OF_IMAGES and not inputs.images:
        raise InputError(f"--stage {stage}", NO_IMAGES)
    sample = _sample(inputs, watcher) if inputs.images else None
    judges = _judges(sample, _methods(methods) if sample else (), dict(cleaned), quick, watcher)
    made, left_out = {}, ()
    if stage != ALL:
        made[stage] = judges[stage]()
    else:
        made, left_out = _all(judges, watcher)
    _write(out, made, left_out)
    watcher.end(_summary(out, made, left_out))
    return INCOMPLETE if watcher.lines else 0


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
    sample: Sample | None, methods: tuple[str, ...], cleaned: dict[str, Path], quick: bool, watcher: _Counting
) -> dict[str, Callable[[], Report]]:
    """What judges each stage for which there is what it needs."""
    # matplotlib and the libraries of rivals take a second to load, and the other commands have no use for them.
    from pavemark.accuracy import blend, geometry, inpaint, render, traces  # noqa: PLC0415

    own = {
        "render": lambda: render.report(installed_renderer, quick, watcher),
        "blend": lambda: blend.report(quick, watcher),
        "geometry": lambda: geometry.report(quick, watcher),
    }
    of_images = {
        "inpaint": lambda: inpaint.report(sample, methods, quick, watcher),
        "residue": lambda: traces.report(sample, methods, cleaned, quick, watcher),
    }
    return own | of_images if sample else own


def _all(judges: dict[str, Callable[[], Report]], watcher: _Counting) -> tuple[dict[str, Report], tuple[str, ...]]:
    """The reports of all that can be judged, and a line for each stage that cannot."""
    made, left_out = {}, []
    for stage, judge in judges.items():
        try:
            made[stage] = judge()
        except InputError as error:
            left_out.append(f"{stage}: not run: {error}")
            watcher.tell(left_out[-1])
    left_out += [f"{stage}: not run: {NO_IMAGES}" for stage in OF_IMAGES if stage not in judges]
    return made, tuple(left_out)


def _writable(out: Path) -> None:
    """Refuse, before minutes are spent, a folder that could not be written in the end."""
    if out.exists() and not out.is_dir():
        raise InputError(out, "is there and no folder: a folder, or a name that is not taken, is allowed")
    there = next(path for path in (out.absolute(), *out.absolute().parents) if path.exists())
    try:
        # Only to try tells: permissions are not all that can be in the way.
        tempfile.TemporaryDirectory(dir=there).cleanup()
    except OSError as error:
        raise InputError(there, f"cannot be written in: {error.strerror}") from None


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
