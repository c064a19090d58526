"""`pavemark evaluate`: how good detectors are, by labelled images."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from pavemark import files
from pavemark.cli.words import File, Folder, Number
from pavemark.detect.example import Example
from pavemark.detect.learned import opened
from pavemark.detect.reading import count, examples, hold_labelled, of_both
from pavemark.errors import InputError, one_line
from pavemark.evaluate.bootstrap import DRAWS, LEVEL
from pavemark.evaluate.curve import best_threshold
from pavemark.evaluate.ensembles import VOTES
from pavemark.evaluate.judge import Alike, Finder, finder, of_found
from pavemark.evaluate.matching import SCALE, TOLERANCE
from pavemark.evaluate.results import COLUMNS, Result, cells, markdown, plain, plain_curve, result
from pavemark.evaluate.tally import Judged
from pavemark.evaluate.worst import COLUMNS as VIEWS
from pavemark.evaluate.worst import Mistakes, worst
from pavemark.job.contact_sheet import drawn
from pavemark.job.folder import spare
from pavemark.job.progress import Progress, shown

THRESHOLD = 0.5
"""Confidence of what counts where none is told."""

WORST = 12
"""Images on the sheet of mistakes."""

ALL = "all"

WIDE = 130
"""Letters of a line where there is no terminal."""


@click.command()
@click.argument("dataset", metavar="DATASET", type=Folder(path_type=Path))
@click.option(
    "--model",
    "models",
    metavar="FILE.onnx",
    multiple=True,
    required=True,
    type=File(path_type=Path),
    help="The detector; several, each with --model, judge together.",
)
@click.option("--vote", type=click.Choice(list(VOTES)), help="What several detectors keep: found by any, all, most.")
@click.option("--threshold", type=Number(0.0, 1.0), metavar="F", help=f"Confidence of what counts.  [{THRESHOLD}]")
@click.option(
    "--threshold-from", "chosen_on", metavar="DATASET", type=Folder(path_type=Path), help="Choose it there, by best F1."
)
@click.option(
    "--tolerance",
    type=Number(0.0, min_open=True),
    default=TOLERANCE,
    show_default=True,
    metavar="PX",
    help=f"How near is right, pixels at {SCALE:g} px/m.",
)
@click.option("--height", type=Number(0.1), metavar="M", help="Metres a picture is high, if no label says.")
@click.option("--by", "groups", metavar="A,B", help="Results by place, scene, side, domain, plate … as well.")
@click.option("--cluster", metavar="GROUP", help="What images are drawn by for the intervals, as place.  [one by one]")
@click.option("--out", metavar="FOLDER", type=Folder(path_type=Path), help="For results, curves and worst images.")
@click.option("--quiet", is_flag=True, help="Say only what goes wrong, and the table.")
def evaluate(
    dataset: Path,
    models: tuple[Path, ...],
    vote: str | None,
    threshold: float | None,
    chosen_on: Path | None,
    tolerance: float,
    height: float | None,
    groups: str | None,
    cluster: str | None,
    out: Path | None,
    quiet: bool,
) -> None:
    """Judge a detector, or several together, by a dataset's labels.

    Precision, recall and F1 at a confidence, average precision, and their 95 % bootstrap intervals, of slots where they
    are labelled and of marking points. A slot is right when both points together lie within the tolerance (Eq. 3).
    """
    if len(models) > 1 and vote is None:
        raise InputError("--vote", f"is missing for {len(models)} models: {', '.join(VOTES)} are allowed")
    if len(models) == 1 and vote is not None:
        raise InputError("--vote", "says nothing to one model: several, each with --model, are allowed with it")
    if threshold is not None and chosen_on is not None:
        raise InputError("--threshold", "and --threshold-from are both given: one of them is allowed")
    if chosen_on is not None and chosen_on.resolve() == dataset.resolve():
        raise InputError("--threshold-from", f"{chosen_on}: is what is judged: another dataset is allowed")
    if cluster is not None and not cluster.strip():
        raise InputError("--cluster", "it is empty: a group of the dataset, as place, is allowed")
    wanted = _words(groups)
    if out is not None:
        spare(out, (), (str(dataset), None if chosen_on is None else str(chosen_on)), "")
        files.writable(out)
    detectors = [opened(model) for model in models]
    _hold_labelled(dataset, chosen_on, {*wanted, *([cluster] if cluster else [])}, height)
    progress = shown(quiet)
    judge = _Judge(finder(detectors, vote, tolerance), tolerance, height, progress)
    judged = judge.of(dataset)
    thresholds = dict.fromkeys(judged.kinds, THRESHOLD if threshold is None else threshold)
    if chosen_on is not None:
        elsewhere = judge.of(chosen_on).kinds
        thresholds = {kind: best_threshold(elsewhere[kind]) for kind in thresholds}
        for kind in thresholds:
            if not elsewhere[kind].hit.any():
                progress.tell(f"{chosen_on}: no {kind} found there are right: no confidence is better than another")
    parts = {ALL: {"": judged}, **{group: judged.by(group) for group in wanted}}
    tables = {
        kind: {
            group: {name: _result(part, kind, thresholds[kind], cluster) for name, part in named.items()}
            for group, named in parts.items()
        }
        for kind in judged.kinds
    }
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else WIDE)
    for kind, table in tables.items():
        console.print(_table(_heading(kind, thresholds[kind]), table))
    if out is None:
        return
    told = {
        "dataset": str(dataset),
        "models": [
            {"file": str(path), "family": detector.family, "version": detector.version}
            for path, detector in zip(models, detectors, strict=True)
        ],
        "vote": vote,
        "tolerance": tolerance,
        "threshold_from": None if chosen_on is None else str(chosen_on),
        "intervals": {"level": LEVEL, "draws": DRAWS, "seed": 0, "drawn_by": cluster or "image"},
    }
    _write(out, told, judged, tables)
    sheet = judge.sheet(dataset, worst(judged, thresholds, WORST), thresholds)
    if sheet is None:
        (out / "worst.png").unlink(missing_ok=True)  # of a run before this
    else:
        files.write(out / "worst.png", sheet)
    progress.end(str(out))


def _words(text: str | None) -> list[str]:
    if text is None:
        return []
    words = list(dict.fromkeys(word.strip() for word in text.split(",") if word.strip()))
    if not words or ALL in words:
        raise InputError("--by", f"{text!r}: groups of the dataset, as place,scene, are allowed")
    return words


def _hold_labelled(dataset: Path, chosen_on: Path | None, groups: set[str], height: float | None) -> None:
    """Hold, before long work, that all labels can be judged by and tell what is asked for."""
    judged, missing, there = Alike(), set(groups), set()
    for example in _held(dataset, height, judged):
        missing -= {group for group, name in example.groups.items() if name}
        there |= example.groups.keys()
    if chosen_on is not None:
        choosing = Alike()
        for example in of_both(_held(chosen_on, height, choosing), examples(dataset, height)):
            raise InputError("--threshold-from", f"{chosen_on}: {example.name} is judged by: other images are allowed")
        if judged.labelled and not choosing.labelled:
            raise InputError("--threshold-from", f"{chosen_on}: has points alone: slots need a threshold as well")
    if missing:
        raise InputError(
            dataset,
            f"tells no {', '.join(sorted(missing))} of its images: {', '.join(sorted(there)) or 'none'} is told",
        )


def _held(dataset: Path, height: float | None, alike: Alike) -> Iterator[Example]:
    for example in examples(dataset, height):
        hold_labelled(example)
        alike.hold(example)
        yield example


@attrs.frozen
class _Judge:
    """What finds points and slots, and what it is judged by."""

    find: Finder
    tolerance: float
    height: float | None
    progress: Progress

    def of(self, dataset: Path) -> Judged:
        found = ((example, self.find(example)) for example in self._counted(dataset))
        with self.progress.of(count(dataset)):
            return of_found(found, self.tolerance)

    def _counted(self, dataset: Path) -> Iterator[Example]:
        for example in examples(dataset, self.height):
            yield example
            self.progress.step(False)

    def sheet(self, dataset: Path, names: list[str], thresholds: dict[str, float]) -> bytes | None:
        """A contact sheet of some images, in this order; looked at once more, for what was found was not kept."""
        if not names:
            return None
        chosen = {example.name: example for example in examples(dataset, self.height, lambda _, name: name in names)}
        strips = [Mistakes(chosen[name], self.find(chosen[name]), thresholds, self.tolerance) for name in names]
        return files.png(drawn(strips, VIEWS))


def _result(part: Judged, kind: str, threshold: float, cluster: str | None) -> Result:
    return result(part.kinds[kind], threshold, part.clusters(cluster))


def _heading(kind: str, threshold: float) -> str:
    return f"{kind} at confidence {threshold:.3g}, % (95 % interval)"


def _rows(table: dict[str, dict[str, Result]]) -> Iterator[tuple[str, Result]]:
    for group, named in table.items():
        for name, each in named.items():
            # A place may be called anything, and a name is one line of a terminal and of a page.
            yield group if group == ALL else one_line(f"{group} {name or 'not known'}"), each


def _table(heading: str, table: dict[str, dict[str, Result]]) -> Table:
    shown_ = Table(title=heading, title_justify="left")
    # A name that is cut could be another's.
    shown_.add_column("", overflow="fold")
    for column in COLUMNS:
        shown_.add_column(column, justify="right", no_wrap=True)
    for name, each in _rows(table):
        # What a dataset calls its places is no markup.
        shown_.add_row(Text(name), *cells(each))
    return shown_


def _write(out: Path, told: dict[str, Any], judged: Judged, tables: dict[str, dict[str, dict[str, Result]]]) -> None:
    # matplotlib takes a second to load, and without --out there is no use for it.
    from pavemark.evaluate.figure import figure  # noqa: PLC0415

    for kind, table in tables.items():
        groups = {
            group: {name: plain(each) for name, each in named.items()} for group, named in table.items() if group != ALL
        }
        told[kind] = plain(table[ALL][""]) | {"by": groups, "curve": plain_curve(judged.kinds[kind])}
    files.write(out / "results.json", json.dumps(told, indent=1, ensure_ascii=False) + "\n")
    pages = [
        f"## {_heading(kind, table[ALL][''].threshold)}\n\n{markdown(list(_rows(table)), '')}"
        for kind, table in tables.items()
    ]
    files.write(out / "results.md", "\n".join([*pages, "![Precision over recall](curve.svg)\n"]))
    kinds = [(kind, judged.kinds[kind], table[ALL][""]) for kind, table in tables.items()]
    files.write(out / "curve.svg", figure(kinds))
