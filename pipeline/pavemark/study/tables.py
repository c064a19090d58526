"""The tables of a study, as Markdown: means over the seeds, and how far they scatter."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence

from pavemark.study.judging import Verdict

FIGURES = {"precision": "precision", "recall": "recall", "f1": "F1", "average_precision": "AP"}


def tables(verdicts: Iterable[Verdict]) -> str:
    """Every table of a study under its heading, a line a row of the study.

    In % on the test places, the mean over the seeds and ± their standard deviation; for each test place F1. The last
    column is what the paper reports.
    """
    headings: dict[str, dict[str, list[Verdict]]] = {}
    for verdict in verdicts:
        headings.setdefault(verdict.row.table, {}).setdefault(verdict.name, []).append(verdict)
    return "\n".join(f"## {heading}\n\n{_table(rows)}" for heading, rows in headings.items())


def _table(rows: dict[str, list[Verdict]]) -> str:
    first = next(iter(rows.values()))[0]
    places = list(first.figures["places"])
    lines = [
        [
            "trained on",
            "real",
            "synthetic",
            "seeds",
            *FIGURES.values(),
            *(f"F1 {place}" for place in places),
            "paper P / R",
        ]
    ]
    lines.append(["---"] * len(lines[0]))
    for name, verdicts in rows.items():
        counts = [str(verdicts[0].real), str(verdicts[0].synthetic), str(len(verdicts))]
        overall = [spread([verdict.figures["test"][figure] for verdict in verdicts]) for figure in FIGURES]
        each = [spread([verdict.figures["places"][place]["f1"] for verdict in verdicts]) for place in places]
        lines.append([name, *counts, *overall, *each, verdicts[0].row.paper])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def spread(values: Sequence[float | None]) -> str:
    """The mean of what is known, in %, and ± its sample standard deviation where there are several."""
    known = [100 * value for value in values if value is not None]
    if not known:
        return "–"
    spread = f" ± {statistics.stdev(known):.1f}" if len(known) > 1 else ""
    return f"{statistics.mean(known):.1f}{spread}"
