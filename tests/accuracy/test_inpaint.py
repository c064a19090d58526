from contextlib import contextmanager

import attrs
import numpy as np
import pytest

from pavemark.accuracy.apart import Answer
from pavemark.accuracy.cases import Sample, cases
from pavemark.accuracy.holes import around
from pavemark.accuracy.inpaint import BLANK, Score, compared, judge, score, scored
from pavemark.accuracy.picture import grid, window
from pavemark.background.index import index
from pavemark.background.reading import MaskTable


class Watcher:
    def __init__(self):
        self.lines, self.steps = [], []

    @contextmanager
    def of(self, total):
        yield

    def step(self, lacking):
        self.steps.append(lacking)

    def tell(self, line):
        self.lines.append(line)


class Crew:
    """Inpainters of the test's own, in this process."""

    def __init__(self, **methods):
        self._made = methods
        self.methods = tuple(methods)

    def fill(self, image, hole, keep_out, refuse):
        for name, made in self._made.items():
            yield name, Answer(made(image, hole, keep_out), 0.5, 100.0)


@pytest.fixture
def sample(folders):
    entries, _ = index(folders / "images", folders / "masks")
    return Sample(entries, 30.0, MaskTable(ground=(0,)), "strokes")


def test_a_case_for_each_image_and_the_bare_one_borrows(sample):
    lines = []
    a, b, bare = cases(sample, lines.append)
    assert lines == []
    assert (a.mask_of, b.mask_of, bare.mask_of) == ("a", "b", "a")
    for case in (a, b, bare):
        assert case.hole.share == 1.0
        assert not (case.hole.mask & around(case.plate.markings, case.plate.frame)).any()
        assert not case.hole.mask[:, 95:].any()
        assert not case.beside[:, 95:].any()
        assert not (case.beside & case.hole.mask).any()


def test_images_without_a_marking_are_asked_once_for_one(sample, monkeypatch):
    """Not by each of the others again: of thousands without one, that would be millions of questions."""
    asked = []

    def bare(self, entry):
        asked.append(entry.name)
        return attrs.evolve(plate, markings=np.zeros_like(plate.markings))

    plate = sample.plate(sample.entries[0])
    many = attrs.evolve(sample, entries=sample.entries * 10)
    monkeypatch.setattr(Sample, "plate", bare)
    lines = []
    assert list(cases(many, lines.append)) == [None] * 30
    assert len(lines) == 30 and all("neither it nor any other image has a marking" in line for line in lines)
    assert len(asked) <= 2 * 30


def test_one_bad_image_is_told_of_and_the_others_are_judged(folders, sample):
    (folders / "images" / "a.png").write_bytes(b"no picture")
    watcher = Watcher()
    scores, _ = judge(sample, Crew(keep=lambda image, hole, keep_out: image), set(), watcher)
    assert [row.image for row in scores] == ["b", "bare"]
    assert watcher.steps == [True, False, False]
    (line,) = watcher.lines
    assert "a.png: not an image" in line


def test_the_truth_is_hidden_from_the_methods_and_the_real_markings_kept_out(sample):
    seen = {}

    def look(image, hole, keep_out):
        seen[len(seen)] = (image.copy(), hole, keep_out)
        return image

    judge(sample, Crew(look=look), set(), Watcher())
    image, hole, keep_out = seen[0]
    assert (image[hole] == BLANK).all()
    assert keep_out[10:60, 40:44].all()
    assert keep_out[:, 95:].all()
    assert not (hole & keep_out).any()


def test_a_perfect_and_a_flat_fill_have_the_scores_they_earn(sample):
    (case, *_) = cases(sample, print)
    truth = case.plate.source
    flat = truth.copy()
    flat[case.hole.mask] = truth[case.hole.mask].mean(0)
    perfect, poor = (score(case, "m", Answer(fill, 0.25, 99.0)) for fill in (truth, flat))
    assert (perfect.psnr, perfect.ssim, perfect.texture, perfect.step) == (float("inf"), 1.0, 1.0, 0.0)
    assert poor.psnr < 45
    assert poor.texture < 0.5
    assert (perfect.seconds, perfect.peak_mb, perfect.hole) == (0.25, 99.0, case.hole.mask.sum())


def row(image, method, **values):
    base = dict.fromkeys(("psnr", "ssim", "flip", "texture", "step"), 1.0)
    fixed = {"width": 9, "height": 9, "hole": 1, "share": 1.0, "mask_of": image, "seconds": 1.0, "peak_mb": 50.0}
    return Score(image=image, method=method, **{**base, **fixed, **values})


ROWS = [
    row("a", "patchmatch", psnr=20.0, texture=0.8, step=-2.0),
    row("a", "ours", psnr=22.0, texture=1.1, step=1.0, peak_mb=70.0),
    row("b", "patchmatch", psnr=20.0, texture=0.8, step=float("nan")),
    row("b", "ours", psnr=19.0, texture=2.0, step=1.0, peak_mb=90.0),
]


def test_the_table_holds_medians_and_the_most_memory():
    patchmatch, ours = scored(ROWS).splitlines()[2:]
    assert patchmatch.startswith("| patchmatch | 2 | 20.0 (20.0 to 20.0) |")
    assert "| -2.00 |" in patchmatch
    assert ours.startswith("| ours | 2 | 20.5 (19.8 to 21.2) |")
    assert ours.endswith("| 90 |")


def test_methods_are_compared_image_by_image():
    # Texture 1.1 is nearer to 1 than 0.8, 2.0 is not; a step of 1 is less than one of -2.
    assert compared(ROWS).splitlines()[2:] == ["| ours | 50% | 0% | 0% | 50% | 100% | 0% |"]


def test_the_window_is_where_most_of_the_hole_is():
    hole = np.zeros((50, 60), bool)
    hole[5, 5] = True
    hole[30:40, 41:55] = True
    rows, columns = window(hole, 20)
    assert hole[rows, columns].sum() == 140
    assert window(hole, 100) == (slice(0, 50), slice(0, 60))


def test_the_picture_shows_truth_hole_and_fills_pixel_for_pixel(sample):
    (case, *_) = cases(sample, print)
    fill = np.zeros_like(case.plate.source)
    sheet = grid([(case, {"m": fill})], ("m", "n"))
    assert sheet.shape[1] == 4 * (100 + 4)
    truth, hole, made, lacking = (sheet[18:98, k * 104 + 2 : k * 104 + 102] for k in range(4))
    assert np.array_equal(truth, case.plate.source)
    assert np.array_equal((hole == 255).all(-1), case.hole.mask | (truth == 255).all(-1))
    assert not made.any()
    assert (lacking == 24).all()
