"""How many images to keep: the arithmetic of the peak, what is refused, and a sweep from its command to its files."""

import json
import math
import re
import shutil
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from detect.datasets import SIZE, listed, made
from pavemark import cli
from pavemark.detect.reading import examples
from pavemark.errors import InputError
from pavemark.select import shards
from pavemark.select.origin import dataset_hash, mark, selection_hash
from pavemark.select.shards import Origin, Row
from pavemark.study import quantity, runs
from pavemark.study import sweep as sweeping
from pavemark.study.design import Training
from pavemark.study.leakage import hold_no_plate
from pavemark.study.peak import against, not_told_apart, p_value, peak
from pavemark.study.sweep import Sweep, Trial, sweep

LOSSES = (0.3, 0.1, 0.4, 0.2, 0.5, 0.6)
"""Of the images of a dataset, in its order: close to far, they are 1, 3, 0, 2, 4, 5."""


def student(t, df):
    """Two-sided p of Student's t, its density summed: an implementation that shares nothing with SciPy's."""
    x = np.linspace(0, abs(t), 200_001)
    scale = math.exp(math.lgamma((df + 1) / 2) - math.lgamma(df / 2)) / math.sqrt(df * math.pi)
    return 1 - 2 * float(np.trapezoid(scale * (1 + x * x / df) ** (-(df + 1) / 2), x))


def test_the_p_value_by_hand():
    # Means 2 and 5, variances 1 and 7.5, three and four seeds.
    one, other = [1.0, 2.0, 3.0], [2.0, 8.0, 3.5, 6.5]
    assert np.var(other, ddof=1) == 7.5
    t = -3 / math.sqrt(1 / 3 + 7.5 / 4)
    df = (1 / 3 + 7.5 / 4) ** 2 / ((1 / 3) ** 2 / 2 + (7.5 / 4) ** 2 / 3)
    assert p_value(one, other) == pytest.approx(student(t, df), abs=1e-8)
    assert p_value(other, one) == pytest.approx(p_value(one, other))
    # One degree of freedom, arctan: t = 1 is p = 1/2.
    assert p_value([1.0, 1.0], [1.0, 2.0]) == pytest.approx(0.5)


def test_the_p_value_without_noise():
    assert p_value([0.5, 0.5], [0.5, 0.5]) == 1.0
    assert p_value([0.5, 0.5], [0.6, 0.6]) == 0.0
    assert p_value([0.5], [0.6, 0.7]) is None and p_value([0.5, 0.6], [0.5]) is None


def test_the_peak_and_what_is_like_it():
    figures = {30: [0.90, 0.91, 0.92], 10: [0.10, 0.11, 0.12], 20: [0.85, 0.91, 0.95], 40: [0.80, 0.81, 0.82]}
    assert peak(figures) == 30
    assert not_told_apart(figures) == [20]
    assert against(figures).keys() == {10, 20, 40}
    # 30 against 40: t = 0.1 / sqrt(2 · 0.0001 / 3), four degrees of freedom.
    assert against(figures)[40] == pytest.approx(student(0.1 / math.sqrt(0.0002 / 3), 4), abs=1e-8)


def test_of_equals_the_least_is_the_peak():
    assert peak({40: [0.5, 0.7], 20: [0.6, 0.6], 30: [0.7, 0.5], 10: [0.1, 0.1]}) == 20
    assert not_told_apart({40: [0.5, 0.7], 20: [0.6, 0.6]}) == [40]


def test_one_seed_tells_nothing_of_noise():
    assert not_told_apart({10: [0.5], 20: [0.6]}) is None
    assert against({10: [0.5], 20: [0.6]}) == {10: None}
    assert not_told_apart({10: [0.5]}) == []


def trials(**f1):
    """Trials with these F1 at each seed, keep = n10 …; precision is a half, recall is F1, and AP is not known."""
    return [
        Trial(
            int(keep[1:]),
            seed,
            Path(f"models/{keep}-{seed}.onnx"),
            {"test": {"precision": 0.5, "recall": value, "f1": value, "average_precision": None}, "threshold": 0.25},
        )
        for keep, values in f1.items()
        for seed, value in enumerate(values)
    ]


def test_the_table():
    lines = quantity.table(trials(n10=[0.1, 0.2], n20=[0.8, 0.9], n30=[0.8, 0.88])).splitlines()
    assert lines[0] == "| images | precision | recall | F1 | AP | against the peak |"
    # The sample standard deviation of two values is their distance / √2.
    assert lines[2].startswith("| 10 | 50.0 ± 0.0 | 15.0 ± 7.1 | 15.0 ± 7.1 | – | lower, p = 0.01")
    assert lines[3] == "| **20** | 50.0 ± 0.0 | 85.0 ± 7.1 | 85.0 ± 7.1 | – | peak |"
    assert lines[4].startswith("| 30 | 50.0 ± 0.0 | 84.0 ± 5.7 | 84.0 ± 5.7 | – | not told apart, p = 0.89 |")
    assert lines[6] == (
        "Peak: 20 images, F1 85.0 ± 7.1 %, 2 seeds. Not told apart from it "
        "(F1, Welch's t-test over the seeds, two-sided, p ≥ 0.05): 30."
    )


def test_the_table_of_one_seed():
    written = quantity.table(trials(n10=[0.1], n20=[0.8]))
    assert "| 10 | 50.0 | 10.0 | 10.0 | – | one seed: noise unknown |" in written
    assert written.endswith("Peak: 20 images, F1 80.0 %, 1 seed. One seed: noise unknown.\n")
    assert "No other number" in quantity.table(trials(n10=[0.1, 0.2]))


def test_the_drawing():
    some = trials(n10=[0.1, 0.2], n20=[0.8, 0.9])
    text = quantity.drawing(some)
    assert quantity.drawing(some) == text
    assert "peak, 20 images" in text and "standard deviation" in text and "images learned from" in text
    ElementTree.fromstring(text)
    assert "noise unknown" in quantity.drawing(trials(n10=[0.1], n20=[0.8]))


def scored(folder, dataset, losses=LOSSES):
    """Scores of a dataset."""
    return scored_as(folder, dataset, dict(enumerate(losses)))


def scored_as(folder, dataset, losses):
    marks = [mark(example) for example in examples(dataset)]
    rows = [Row(f"images/{k:06d}", loss, {}, (1.0, 0.0), marks[k]) for k, loss in losses.items()]
    origin = Origin("model", "dmpr", dataset_hash(dataset), selection_hash(dataset), {})
    shards.write(shards.path_of(folder, 0), 0, rows, origin)
    return folder


def real(folder, *names, points=((10.5, 20.0),)):
    width, height = SIZE
    listed(folder, *({"image": f"{name}.png", "w": width, "h": height, "points": points} for name in names))
    for name in names:  # no two alike
        rng = np.random.default_rng(zlib.crc32(f"{folder.name}/{name}".encode()))
        cv2.imwrite(str(folder / f"{name}.png"), rng.integers(0, 255, (height, width, 3), np.uint8))
    return folder


@pytest.fixture
def wanted(tmp_path):
    """A sweep over a dataset of six images, a test set of two, and one to choose the confidence."""
    dataset = made(tmp_path / "dataset", len(LOSSES))
    return Sweep(
        dataset,
        scored(tmp_path / "scores", dataset),
        real(tmp_path / "test", "east_0", "east_1"),
        real(tmp_path / "validation", "south_0"),
        (4, 2),
        seeds=2,
        training=Training(steps=4, batch=2),
        height=4.2,
        scale=5.0,
    )


@pytest.fixture
def taught(monkeypatch):
    """The runs that would be trained; none is."""
    told = []

    def train_all(wanted, folder, workers, tell):
        told.extend(wanted)
        raise InputError("training", "is another matter")

    monkeypatch.setattr(sweeping, "train_all", train_all)
    return told


def test_fewer_images_are_the_first_of_more(wanted, tmp_path, taught):
    with pytest.raises(InputError, match="another matter"):
        sweep(wanted, tmp_path / "out", 1, print, print)
    assert [(name, [each.image.stem[-1] for each in run.examples], run.seed) for name, run in taught] == [
        ("2 images, seed 0", ["1", "3"], 0),
        ("2 images, seed 1", ["1", "3"], 1),
        ("4 images, seed 0", ["1", "3", "0", "2"], 0),
        ("4 images, seed 1", ["1", "3", "0", "2"], 1),
    ]
    assert {(run.steps, run.scale, run.start) for _, run in taught} == {(4, 5.0, None)}


def test_an_image_that_cannot_be_read_is_left_out_and_told(wanted, tmp_path, taught):
    picture = wanted.dataset / "images" / "000003.png"
    picture.write_bytes(b"no picture")
    losses = {number: loss for number, loss in enumerate(LOSSES) if number != 3}
    scored_as(tmp_path / "five", wanted.dataset, losses)
    lines = []
    with pytest.raises(InputError, match="another matter"):
        sweep(attrs.evolve(wanted, scores=tmp_path / "five"), tmp_path / "out", 1, print, lines.append)
    assert [each.image.stem[-1] for each in taught[2][1].examples] == ["1", "0", "2", "4"]
    assert len(lines) == 1 and lines[0].startswith(f"left out: {picture}: ")


@pytest.mark.parametrize(("given", "scale"), [(22.7, 22.7), (60.0, 30.0)])
def test_the_scale_is_that_of_the_images_up_to_the_finest(wanted, tmp_path, taught, given, scale):
    dataset = made(tmp_path / "dataset", len(LOSSES), given)
    scores = scored(tmp_path / "scores", dataset)
    with pytest.raises(InputError, match="another matter"):
        sweep(attrs.evolve(wanted, dataset=dataset, scores=scores, scale=None), tmp_path / "out", 1, print, print)
    assert {run.scale for _, run in taught} == {scale}


def test_results_are_of_the_split_that_they_were_judged_by(wanted, tmp_path, monkeypatch):
    """An image that is moved from the validation to the test images leaves none of the others' results."""
    asked = []

    def judge(detectors, vote, parts, tolerance):
        asked.append({part: [each.name for each in found] for part, found in parts.items()})
        return {"asked": len(asked)}

    monkeypatch.setattr(sweeping, "judge", judge)
    monkeypatch.setattr(sweeping, "opened", Path)
    monkeypatch.setattr(sweeping, "train_all", lambda *given: None)
    monkeypatch.setattr(runs, "model", lambda run, folder: folder / "model.onnx")
    splits = [(("a", "b"), ("c", "d")), (("a",), ("b", "c", "d")), (("a", "b"), ("c", "d"))]
    found = []
    for number, (validation, test) in enumerate(splits):
        folder = tmp_path / str(number)
        given = {"validation": real(folder / "v", *validation), "test": real(folder / "t", *test)}
        for part in given.values():
            for path in part.glob("*.png"):  # the same picture wherever it lies
                cv2.imwrite(str(path), np.full((*SIZE[::-1], 3), ord(path.stem), np.uint8))
        trials = sweep(attrs.evolve(wanted, keep=(2,), seeds=1, **given), tmp_path / "out", 1, print, print)
        found.append(trials[0].figures["asked"])
    assert found == [1, 2, 1]
    assert asked == [{"validation": list(v), "test": list(t)} for v, t in splits[:2]]


def test_a_random_order_is_of_the_seed_of_the_selection(wanted, tmp_path, taught):
    for seed in (0, 0, 1):
        with pytest.raises(InputError, match="another matter"):
            sweep(attrs.evolve(wanted, strategy="random", seed=seed), tmp_path / "out", 1, print, print)
    orders = [[each.name for each in run.examples] for name, run in taught if name.startswith("4 images")]
    assert orders[0] == orders[1] == orders[2] == orders[3] and orders[4] == orders[5] != orders[0]


@pytest.mark.parametrize("part", ["test", "validation"])
def test_a_plate_of_an_image_that_is_judged_by_is_refused(wanted, tmp_path, taught, part):
    # The plates of the dataset are plate0 and plate1.
    leaking = attrs.evolve(wanted, **{part: real(tmp_path / "leak", "west_0", "plate1")})
    with pytest.raises(InputError, match=r"dataset: images/00000\d: its plate, plate1, is that of .*plate1.png"):
        sweep(leaking, tmp_path / "out", 1, print, print)
    assert not taught


def test_plates_of_painted_images_are_held_apart(tmp_path, wanted):
    other = made(tmp_path / "other")
    assert [each.groups["plate"] for each in sweeping.examples(other)] == ["plate0.png", "plate1.png", "plate0.png"]
    with pytest.raises(InputError, match="its plate, plate0,"):
        hold_no_plate(wanted.dataset, sweeping.examples(other))
    # Numbers that images are called by are no plates.
    lines = (other / "manifest.jsonl").read_text().replace('"plate', '"else')
    (other / "manifest.jsonl").write_text(lines)
    hold_no_plate(wanted.dataset, sweeping.examples(other))


@pytest.mark.parametrize("copied", [False, True])
def test_a_picture_that_is_judged_by_is_not_learned_from(wanted, tmp_path, taught, copied):
    """Images 1, 3, 0 and 2 are learned from, 5 is not."""
    width, height = SIZE
    for image, refused in (("000000", True), ("000005", False)):
        folder = tmp_path / image
        folder.mkdir()
        where = f"../dataset/images/{image}.png"
        if copied:
            where = "other.png"
            shutil.copy(wanted.dataset / "images" / f"{image}.png", folder / where)
        line = {"image": where, "w": width, "h": height, "points": [[10.5, 20.0]]}
        (folder / "labels.jsonl").write_text(json.dumps(line))
        with pytest.raises(InputError, match="000000.png: is of DATASET, and the same" if refused else "another m"):
            sweep(attrs.evolve(wanted, test=folder), tmp_path / "out", 1, print, print)
    assert len(taught) == 4


def test_what_cannot_be_judged_by_is_told_before_anything_is_trained(wanted, tmp_path, taught):
    def refused(said, **changed):
        with pytest.raises(InputError, match=said):
            sweep(attrs.evolve(wanted, **changed), tmp_path / "out", 1, print, print)

    gone, other = real(tmp_path / "gone", "west_0", "west_1"), real(tmp_path / "other", "west_0", "west_1")
    (gone / "west_1.png").unlink()
    refused("west_1.png: .*cannot be read|west_1.png: .*no such", test=gone)
    cv2.imwrite(str(other / "west_1.png"), np.zeros((9, 9, 3), np.uint8))
    refused("west_1.png: is 9×9 px: 48×96", validation=other)
    refused("west_0: is in the set twice", test=real(tmp_path / "twice", "west_0", "west_0"))
    assert not taught


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"keep": ()}, "--keep: is missing"),
        ({"keep": (2, 3, 2)}, "--keep: 2 is given twice: each number once is allowed"),
        ({"keep": (0,)}, "--keep: 0: 1 or more is allowed"),
        ({"seeds": 0}, "--seeds: 0: 1 or more is allowed"),
        ({"keep": (2, 7)}, "--keep: 7: 6 of 6 images are left to choose from: at most so many are allowed"),
    ],
)
def test_numbers_that_are_refused(wanted, tmp_path, taught, changed, said):
    with pytest.raises(InputError, match=f"^{re.escape(said)}"):
        sweep(attrs.evolve(wanted, **changed), tmp_path / "out", 1, print, print)
    assert not taught


def test_datasets_that_are_refused(wanted, tmp_path, taught):
    def refused(said, **changed):
        with pytest.raises(InputError, match=said):
            sweep(attrs.evolve(wanted, **changed), tmp_path / "out", 1, print, print)

    fewer = scored(tmp_path / "scores5", wanted.dataset, LOSSES[:5])
    refused("scores5: lacks 1 of the images of .*dataset, the first is images/000005", scores=fewer)
    refused("holds no scores", scores=tmp_path / "none")
    refused("none: is no folder", test=tmp_path / "none")
    refused("has no scale", height=None)
    refused("--validation: .*test: is the test set", validation=wanted.test)
    refused("--test .*bare: has no marking point", test=real(tmp_path / "bare", "west_1", points=()))
    refused("--validation .*bare2: has no marking", validation=real(tmp_path / "bare2", "west_2", points=()))
    (tmp_path / "again").mkdir()
    line = json.loads((wanted.test / "labels.jsonl").read_text().splitlines()[0]) | {"image": "../test/east_0.png"}
    (tmp_path / "again" / "labels.jsonl").write_text(json.dumps(line))
    refused("east_0.png: is of --test, and the same picture as .*, of --validation", validation=tmp_path / "again")
    assert not taught


def words(wanted, out, *more):
    told = ["--scores", wanted.scores, "--test", wanted.test, "--validation", wanted.validation, "--out", out]
    told += ["--steps", 4, "--batch", 2, "--height", 4.2, "--scale", 22.7, "--workers", 1, *more]
    return ["sweep", str(wanted.dataset), *map(str, told)]


def run(capfd, *given):
    with pytest.raises(SystemExit) as left:
        cli.main(given)
    said = capfd.readouterr()
    return left.value.code, said.err if left.value.code else said.out


def test_the_command_refuses_in_one_line(wanted, tmp_path, capfd, monkeypatch):
    out = tmp_path / "out"
    code, said = run(capfd, *words(wanted, out, "--keep", 2, "--keep", 2))
    assert (code, said) == (2, "error: --keep: 2 is given twice: each number once is allowed\n")
    code, said = run(capfd, *words(wanted, out))
    assert code == 2 and "--keep" in said
    code, said = run(capfd, *words(wanted, out, "--keep", 2, "--seeds", 0))
    assert code == 2 and "--seeds" in said
    code, said = run(capfd, *words(wanted, wanted.scores, "--keep", 2))
    assert code == 2 and "is the folder of the inputs" in said

    def none(package):
        raise runs.importlib.metadata.PackageNotFoundError(package)

    monkeypatch.setattr(runs.importlib.metadata, "version", none)
    code, said = run(capfd, *words(wanted, out, "--keep", 2))
    assert (code, said) == (2, "error: study: torch is missing: pip install 'pavemark[train]'\n")
    assert not out.exists()


def test_from_the_command_to_the_files(wanted, tmp_path, capfd, monkeypatch):
    pytest.importorskip("torch", reason="torch is not installed: pip install 'pavemark[train]'")
    out = tmp_path / "out"
    given = words(wanted, out, "--keep", 3, "--keep", 2, "--seeds", 2)
    code, said = run(capfd, *given)
    assert code == 0, said
    assert said.count("trained ") == 4 and said.endswith("sweep.md\n")
    told = json.loads((out / "sweep.json").read_text())
    assert [(each["keep"], each["seed"]) for each in told["runs"]] == [(2, 0), (2, 1), (3, 0), (3, 1)]
    models = {path: path.stat().st_mtime_ns for path in (out / "models").glob("*.onnx")}
    assert {out / each["model"] for each in told["runs"]} == models.keys() and len(models) == 4
    for each in told["runs"]:
        assert (each["test"]["images"], each["test"]["truths"], each["validation"]["images"]) == (2, 2, 1)
    for number in told["numbers"]:
        f1 = [each["test"]["f1"] for each in told["runs"] if each["keep"] == number["keep"]]
        assert number["f1"] == {"mean": pytest.approx(np.mean(f1)), "deviation": pytest.approx(np.std(f1, ddof=1))}
    assert told["peak"] == min(told["numbers"], key=lambda each: (-each["f1"]["mean"], each["keep"]))["keep"]
    assert (out / "sweep.md").read_text().count("\n| ") == 3 and "peak" in (out / "sweep.svg").read_text()

    # All is there: nothing is trained or judged, and the same is written.
    written = {path.name: path.read_bytes() for path in out.glob("sweep.*")}
    monkeypatch.setattr(sweeping, "judge", None)
    code, said = run(capfd, *given)
    assert code == 0 and "trained " not in said and "judged" not in said
    assert {path.name: path.read_bytes() for path in out.glob("sweep.*")} == written
    assert {path: path.stat().st_mtime_ns for path in models} == models
    assert {path.suffix for path in out.rglob("*") if path.is_file()} == {".onnx", ".pt", ".json", ".md", ".svg"}
