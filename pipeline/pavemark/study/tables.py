"""The tables of a study, as Markdown: means over the seeds, and how far they scatter."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence

from pavemark.study.judging import Verdict

FIGURES = {"precision": "precision", "recall": "recall", "f1": "F1", "average_precision": "AP"}


def tables(verdicts: Sequence[Verdict], judge: str) -> str:
    """Every table of a study under its heading, a line a row of the study.

    In % on the test places, the mean over the seeds and ± their standard deviation: precision, recall and F1 at the
    confidence that is best on the validation places; average precision; the precision where the recall is that of the
    row called `judge`, whatever the confidence, – where a seed never comes so far; for each test place F1. The last
    column is what the paper reports.
    """
    recall = statistics.mean(verdict.figures["test"]["recall"] for verdict in verdicts if verdict.name == judge)
    headings: dict[str, dict[str, list[Verdict]]] = {}
    for verdict in verdicts:
        headings.setdefault(verdict.row.table, {}).setdefault(verdict.name, []).append(verdict)
    return "\n".join(f"## {heading}\n\n{_table(rows, judge, recall)}" for heading, rows in headings.items())


def precision_at(curve: Mapping[str, Sequence[float | None]], recall: float) -> float | None:
    """The best precision of a curve, as JSON holds it, where its recall is at least so much; None where it never is."""
    pairs = zip(curve["precision"], curve["recall"], strict=True)
    return max(
        (precision for precision, there in pairs if None not in (precision, there) and there >= recall), default=None
    )


def _table(rows: dict[str, list[Verdict]], judge: str, recall: float) -> str:
    first = next(iter(rows.values()))[0]
    places = list(first.figures["places"])
    lines = [
        [
            "trained on",
            "real",
            "synthetic",
            "seeds",
            *FIGURES.values(),
            f"precision at the recall of {judge}",
            *(f"F1 {place}" for place in places),
            "paper P / R",
        ]
    ]
    lines.append(["---"] * len(lines[0]))
    for name, verdicts in rows.items():
        counts = [str(verdicts[0].real), str(verdicts[0].synthetic), str(len(verdicts))]
        overall = [spread([verdict.figures["test"][figure] for verdict in verdicts]) for figure in FIGURES]
        each = [spread([verdict.figures["places"][place]["f1"] for verdict in verdicts]) for place in places]
        reached = [precision_at(verdict.figures["curve"], recall) for verdict in verdicts]
        lines.append([name, *counts, *overall, spread(reached), *each, verdicts[0].row.paper])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def spread(values: Sequence[float | None]) -> str:
    """The mean in %, and ± the sample standard deviation where there are several; – where one is not known.

    A mean over the seeds that have a figure would flatter those that have none.
    """
    if None in values:
        return "–"
    found = [100 * value for value in values]
    spread = f" ± {statistics.stdev(found):.1f}" if len(found) > 1 else ""
    return f"{statistics.mean(found):.1f}{spread}"
