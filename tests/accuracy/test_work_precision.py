"""What the figures are drawn from, and the figures: by hand-computed numbers."""

import re
import xml.etree.ElementTree as ET
from contextlib import contextmanager
from html.parser import HTMLParser

import attrs
import pytest

from pavemark.accuracy.apart import Answer
from pavemark.accuracy.figure import Axis, figure
from pavemark.accuracy.page import page
from pavemark.accuracy.race import Contender, Failure, Run, race
from pavemark.accuracy.report import Report
from pavemark.accuracy.work_precision import Point, duration, front, halving, points, power, sentences
from pavemark.accuracy.write_up import Wording, written
from pavemark.errors import InputError


class Watcher:
    def __init__(self):
        self.total, self.steps = 0, 0

    @contextmanager
    def of(self, total):
        self.total = total
        yield

    def step(self, lacking):
        self.steps += 1


def point(family, setting, error, seconds, problem="toy", ships=False, pareto=False):
    times = {"seconds": seconds, "lower": 0.9 * seconds, "upper": 1.2 * seconds, "rounds": 5}
    return Point(problem=problem, family=family, setting=setting, ships=ships, error=error, pareto=pareto, **times)


def test_contenders_take_turns_and_the_first_time_is_not_counted():
    calls = []

    def ask(contender):
        calls.append(contender.family)
        return Answer(f"{contender.family} {len(calls)}", float(len(calls)), 0.0)

    watcher = Watcher()
    runs, failed = race([Contender("p", "a"), Contender("p", "b")], ask, 3, watcher)
    assert calls == ["a", "b"] * 4
    assert [(run.value, run.seconds) for run in runs] == [("a 1", (3.0, 5.0, 7.0)), ("b 2", (4.0, 6.0, 8.0))]
    assert failed == []
    assert watcher.steps == watcher.total == 8


def test_what_does_not_run_is_told_and_the_others_are_raced():
    def ask(contender):
        if contender.family == "b":
            raise InputError("render", "no\nGPU")
        return Answer(0, 1.0, 0.0)

    b = Contender("p", "b", "16")
    runs, failed = race([Contender("p", "a"), b], ask, 1, Watcher())
    assert [run.contender.family for run in runs] == ["a"]
    assert failed == [Failure(b, "render: no GPU")]


def test_medians_and_quartiles():
    run = Run(Contender("p", "a"), None, (5.0, 1.0, 2.0, 4.0, 3.0))
    (made,) = points([run], Point, lambda _: {"error": 1.0})
    assert (made.lower, made.seconds, made.upper, made.rounds) == (2.0, 3.0, 4.0, 5)


def test_the_front_by_hand():
    errors, seconds = [8, 4, 5, 1, 0.9, 7], [1, 2, 3, 4, 4.1, 0.99]
    # The first is as quick as the last, and less exact; the fourth as quick as the fifth. The third loses in both.
    assert front(errors, seconds) == [False, True, False, False, True, True]


def test_rounding_and_chance_put_nothing_on_the_front():
    # The second is more exact by rounding alone; the fourth is quicker than the third by chance, and less exact.
    assert front([2e-13, 1e-13, 1.0, 1.5], [1.0, 9.0, 0.5, 0.49]) == [True, False, True, False]
    assert front([1.0, 0.99, 1.01], [1.0, 1.01, 0.99]) == [True, True, True]


def test_the_front_is_drawn_within_each_problem():
    runs = [
        Run(Contender(problem, family), error, (seconds, seconds))
        for problem, family, error, seconds in (("p", "a", 1.0, 1.0), ("p", "b", 2.0, 2.0), ("q", "a", 9.0, 9.0))
    ]
    made = points(runs, Point, lambda run: {"error": run.value})
    assert [one.pareto for one in made] == [True, False, True]


def test_slopes_by_hand():
    # Error ∝ time^-1/2: to halve it takes four times as long.
    of = [point("a", str(n), 8 / n**0.5, 0.1 * n) for n in (1, 4, 16, 64)]
    assert power([p.error for p in of], [p.seconds for p in of]) == pytest.approx(-0.5)
    assert halving(of) == pytest.approx(4.0)
    # Off a straight line: three points, log2 of time against log2 of error through (0, 0), (-1, 1), (-2, 3).
    # The least-squares slope is -3/2, so halving costs 2^1.5.
    bent = [point("a", "", e, s) for e, s in ((1.0, 1.0), (0.5, 2.0), (0.25, 8.0))]
    assert halving(bent) == pytest.approx(2**1.5)


def test_no_slope_where_there_is_none():
    assert halving([point("a", "", 1.0, 1.0), point("a", "", 0.6, 9.0)]) is None
    assert halving([point("a", "", 1e-12, 1.0), point("a", "", 0.0, 9.0)]) is None


def test_sentences_come_from_the_data():
    of = [
        point("rays", "4", 8.0, 0.1, pareto=True),
        point("rays", "16", 4.0, 0.4, pareto=True),
        point("rays", "64", 2.0, 1.6, pareto=True, ships=True),
        point("blur", "", 9.0, 2.0),
    ]
    assert sentences(of, "levels") == [
        "From rays 4 (8 levels in 100 ms) to rays 64 (2 levels in 1.6 s), along what is worth its time, halving the "
        "error costs 4× the time.",
        "What ships is rays 64 (2 levels in 1.6 s).",
        "Never worth the time here: blur.",
    ]
    best = [point("exact", "", 0.1, 0.1, pareto=True), point("rays", "4", 8.0, 0.2, ships=True)]
    assert sentences(best, "px") == [
        "Nothing is quicker or more exact than exact (0.1 px in 100 ms).",
        "What ships, rays 4 (8 px in 200 ms), is dominated by exact.",
        "Never worth the time here: rays.",
    ]
    chance = [point("exact", "", 0.1, 0.2, pareto=True), point("rays", "4", 8.0, 0.199, ships=True)]
    assert sentences(chance, "px")[1] == "What ships, rays 4 (8 px in 199 ms), is dominated by exact."
    near = [point("a", "", 1.0, 1.0, pareto=True), point("b", "", 0.75, 2.0, pareto=True)]
    assert sentences(near, "px")[0].endswith("the error falls by 25% only: nothing halves it.")


def test_durations():
    assert [duration(s) for s in (123.0, 0.999, 0.02, 1e-3, 2.5e-7)] == ["123 s", "999 ms", "20 ms", "1 ms", "0.25 µs"]


MADE = [
    point("rays", "4", 8.0, 0.1, pareto=True),
    point("rays", "16", 4.0, 0.4, ships=True, pareto=True),
    point("exact <&>", "", 0.0, 0.5, pareto=True),
    point("rays", "16", 3.0, 0.4, problem="another"),
    point("other", "", 2.0, 0.4, problem="another", pareto=True),
]


def texts(svg):
    return {"".join(text.itertext()) for text in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")}


def test_the_figure_names_all_and_refers_to_nothing():
    svg = figure("toy", MADE, Axis("error, levels", ("second", lambda made: 2 * made.error)), 2)
    wanted = {"rays", "exact <&>", "other", "toy", "another", "error, levels", "processor time", "second", "16"}
    assert wanted <= texts(svg)
    assert "dc:date" not in svg and "Matplotlib" not in svg
    body = svg[svg.index("<svg") :]
    addresses = set(re.findall(r'https?://[^"\s]+', body))
    assert addresses <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_the_same_points_give_the_same_bytes():
    assert figure("toy", MADE, Axis("error"), 2) == figure("toy", MADE, Axis("error"), 2)


def test_families_of_a_panel_are_told_apart():
    made = [point(family, "", 1.0, 1.0, problem=p) for p, family in (("p", "a"), ("p", "b"), ("q", "c"), ("q", "b"))]
    svg = figure("toy", made, Axis("error"), 2)
    root = ET.fromstring(svg)
    assert root.tag.endswith("svg")
    # b is the second of both panels, so c is not of its colour.
    assert {"#0072b2", "#d55e00"} <= set(re.findall(r"#[0-9a-f]{6}", svg))


WORDING = Wording(
    unit="levels", axis=Axis("error, levels"), intro="A toy.", columns={"twice": lambda p: str(2 * p.error)}
)


def test_a_stage_writes_its_figure_its_numbers_and_what_they_say():
    failed = [Failure(Contender("toy", "EEVEE", n), "no GPU") for n in ("16", "64")]
    report = written("toy", "A toy stage", MADE, attrs.evolve(WORDING, remarks=("By the way.",), failed=failed))
    assert report.files.keys() == {"toy.svg", "toy.csv", "toy.md"}
    assert report.files["toy.csv"].splitlines()[1] == "toy,rays,4,False,8,0.1,0.09,0.12,5,True"
    assert "to exact <&> (0 levels in 500 ms), along what is worth its time, halving the error costs" in report.told
    assert "EEVEE 16, 64, toy: not run: no GPU." in report.told
    assert "By the way." in report.told
    assert "| rays | 16 | 4 | 400 ms (360 ms to 480 ms) | 8.0 | ships, Pareto |" in report.told
    assert "1 thread a method" in report.told


class Page(HTMLParser):
    """What a page refers to, its ids, and its words."""

    def __init__(self, text):
        super().__init__()
        self.references, self.ids, self.words, self.tags = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            if name in ("src", "href", "xlink:href", "data", "srcset"):
                self.references.append(value)
            if name == "id":
                self.ids.append(value)

    def handle_data(self, data):
        self.words.append(data)


def test_the_page_is_whole_in_itself():
    reports = {name: written(name, f"Stage {name}", MADE, WORDING) for name in ("one", "two")}
    reports["old"] = Report({"old.png": b"\x89PNG", "old.csv": ""}, "# Old\n\n| a |\n| --- |\n| <script>x</script> |\n")
    shown = Page(page(reports, ("render: not run: no <Blender>",)))
    assert shown.tags.count("svg") == 2
    assert shown.tags.count("table") == 2 * 2 + 1
    assert "script" not in shown.tags
    assert all(reference.startswith(("#", "data:image/png;base64,")) for reference in shown.references)
    assert any(reference.startswith("data:image/png") for reference in shown.references)
    inner = {reference[1:] for reference in shown.references if reference.startswith("#")}
    assert inner <= set(shown.ids)
    assert len(set(shown.ids)) == len(shown.ids)
    words = " ".join(shown.words)
    for word in ("rays", "exact <&>", "Stage two", "render: not run: no <Blender>", "<script>x</script>"):
        assert word in words
