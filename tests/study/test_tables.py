"""Tables of a study against figures reckoned by hand."""

import pytest

from pavemark.study.design import Row
from pavemark.study.judging import Verdict
from pavemark.study.tables import precision_at, spread, tables

CURVE = {"precision": [1.0, 0.9, 0.95, 0.5, None], "recall": [0.1, 0.5, 0.55, 0.9, None]}


def verdict(row: Row, seed: int, precision: float, recall: float) -> Verdict:
    f1 = 2 * precision * recall / (precision + recall)
    test = {"precision": precision, "recall": recall, "f1": f1, "average_precision": None}
    figures = {"test": test, "places": {"east": test}, "curve": CURVE}
    return Verdict(row.name, row, seed, 4, 7, figures)


def test_a_row_is_the_mean_of_its_seeds_and_how_they_scatter():
    real, more = Row("real", real=1.0, seeds=(0,)), Row("more", "Others", real=1.0, seeds=(0, 1), paper="91 / 83")
    written = tables([verdict(real, 0, 0.8, 0.5), verdict(more, 0, 0.6, 0.4), verdict(more, 1, 0.8, 0.6)], "real")
    assert written.index("## Strategies") < written.index("## Others")
    (line,) = [line for line in written.splitlines() if line.startswith("| more")]
    # The sample standard deviation of 0.6 and 0.8 is 0.1414; at a recall of 0.5 the curve's best precision is 0.95.
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells == [
        *("more", "4", "7", "2", "70.0 ± 14.1", "50.0 ± 14.1", "58.3 ± 14.5", "–", "95.0 ± 0.0"),
        *("58.3 ± 14.5", "91 / 83"),
    ]
    assert "| real | 4 | 7 | 1 | 80.0 | 50.0 |" in written


@pytest.mark.parametrize(("recall", "precision"), [(0.0, 1.0), (0.1, 1.0), (0.11, 0.95), (0.55, 0.95), (0.56, 0.5)])
def test_the_precision_at_a_recall(recall, precision):
    assert precision_at(CURVE, recall) == precision


def test_a_figure_that_a_seed_lacks():
    assert spread([0.5, 0.7]) == "60.0 ± 14.1" and spread([0.5]) == "50.0"
    assert spread([None, 0.9]) == spread([None]) == "–"


def test_a_recall_that_is_never_reached():
    assert precision_at(CURVE, 0.91) is None
