"""`pavemark accuracy`: how good and how dear each stage is, measured on the user's own images."""

from __future__ import annotations

from pathlib import Path

import click

from pavemark import files
from pavemark.accuracy import inpaint, traces
from pavemark.accuracy.cases import Sample
from pavemark.accuracy.report import Report
from pavemark.background.index import index
from pavemark.background.inpainting import choices, inpainter
from pavemark.cli.words import Folder
from pavemark.errors import InputError
from pavemark.job.config import merge, read_inputs, setting
from pavemark.job.folder import spare
from pavemark.job.progress import Progress, shown

INCOMPLETE = 1

STAGES = ("inpaint", "residue")


class _Cleaned(click.ParamType):
    name = "NAME=DIR"

    def convert(self, value, param, ctx):
        name, equals, folder = value.partition("=")
        if not (name and equals and folder):
            self.fail(f"{value!r}: allowed is NAME=DIR, such as lama=others/lama", param, ctx)
        return name, Path(folder)


@click.command()
@click.option("--stage", type=click.Choice(STAGES), default=STAGES[0], show_default=True, help="What is judged.")
@click.option("--images", metavar="DIR", required=True, type=Folder(), help="Folder of real AVM images.")
@click.option("--masks", metavar="DIR", type=Folder(), help="Folder of their masks: PNGs of the same names.")
@click.option("--out", metavar="REPORT", required=True, type=Folder(path_type=Path), help="Folder of the report.")
@click.option("--methods", metavar="A,B", help="Inpainters, by name.  [all there are]")
@click.option("--cleaned", metavar="NAME=DIR", multiple=True, type=_Cleaned(), help="For residue: cleaned by others.")
@click.option("--scale", type=float, metavar="PX/M", help="Pixels per metre of the images.  [60]")
@click.option("--metres-per-pixel", type=float, metavar="M", help="The same, the other way round.")
@click.option("--segmenter", metavar="NAME", help="What finds markings and ground where there are no masks.")
@click.option("--set", "settings", metavar="FIELD=VALUE", multiple=True, help="A line of a job file: mask.ground = [0]")
@click.option("--quick", is_flag=True, help="With four images at most.")
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
    """Judge what fills the ground where markings were.

    Stage inpaint: the hole of each image's markings is moved to bare ground of the image, filled by every method and
    held against the truth; REPORT/inpaint.csv, .md and .png, and speed.csv. Stage residue: the real markings are taken
    off, and what is left of them is measured; REPORT/residue.csv, .md, and profile.csv.
    """
    if cleaned and stage != "residue":
        raise InputError("--cleaned", f"says nothing to --stage {stage}: --stage residue is allowed with it")
    twice = [name for name, _ in cleaned if [other for other, _ in cleaned].count(name) > 1]
    if twice:
        raise InputError("--cleaned", f"{twice[0]} is given twice: another name is allowed")
    told: dict = {}
    for text in settings:
        told = merge(told, setting(text))
    inputs = read_inputs(told | {name: value for name, value in options.items() if value is not None})
    spare(out, (), (inputs.images, inputs.masks, *(folder for _, folder in cleaned)), "")
    files.writable(out)
    names = _methods(methods)
    entries, unmatched = index(Path(inputs.images), None if inputs.masks is None else Path(inputs.masks))
    watcher = _Counting(shown(quiet))
    for path in unmatched:
        watcher.tell(f"{path}: nothing has its name in the other folder")
    sample = Sample(entries, inputs.pixels_per_metre, inputs.mask, inputs.segmenter)
    if stage == "inpaint":
        made = inpaint.report(sample, names, quick, watcher)
    else:
        made = traces.report(sample, names, dict(cleaned), quick, watcher)
    _write(out, made)
    watcher.end(f"{made.told}\n{', '.join(str(out / name) for name in made.files)}")
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


def _write(out: Path, made: Report) -> None:
    for name, data in made.files.items():
        files.write(out / name, data)


class _Counting:
    """A progress that counts what went wrong."""

    def __init__(self, progress: Progress) -> None:
        self.lines = 0
        self.of, self.step, self.end = progress.of, progress.step, progress.end
        self._tell = progress.tell

    def tell(self, line: str) -> None:
        self.lines += 1
        self._tell(line)
