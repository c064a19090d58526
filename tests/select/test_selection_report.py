"""The page of a selection, taken apart by a parser: pictures, figure and numbers are those of the selection."""

import base64
import re
import time
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest
from scored import scores

from detect.datasets import made
from pavemark.detect.example import Example
from pavemark.ground import Frame
from pavemark.select import losses, report
from pavemark.select.candidate import Candidate
from pavemark.select.choice import Wanted
from pavemark.select.selection import select


class Page(HTMLParser):
    """Headings, pictures under them, cells of tables, and whatever refers to something."""

    def __init__(self, text):
        super().__init__()
        self.under, self.open = {}, []
        self.pictures, self.headings, self.rows, self.refers, self.text = {}, [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        told = dict(attributes)
        self.refers += [told[name] for name in ("src", "href", "xlink:href") if name in told]
        if tag in ("h1", "h2", "h3", "td", "th"):
            self.open.append(tag)
        if tag in ("h1", "h2", "h3"):
            self.headings.append("")
            self.under[tag] = len(self.headings) - 1
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag == "img":
            under = self.headings[self.under["h2"]], self.headings[self.under["h3"]]
            self.pictures.setdefault(under, []).append((told["alt"], told["src"]))

    def handle_endtag(self, tag):
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_data(self, data):
        self.text += data
        if self.open and self.open[-1][0] == "h":
            self.headings[-1] += data
        elif self.open:
            self.rows[-1][-1] += data


@pytest.fixture
def page(tmp_path):
    dataset = made(tmp_path / "dataset", 60)
    # Image k is the k-th hardest; its domain has an angle bracket in its name, as a hostile file could.
    domains = ["<b>base", "noise+wet", None]
    told = [(f"images/{k:06d}", 0.9 - k / 100, f"plate{k % 13:02d}", domains[k % 3 if k else 0]) for k in range(60)]
    scored = scores(tmp_path / "scores", dataset, told)
    easiest = dataset / "images/000059.png"
    easiest.write_bytes(bytes(easiest.stat().st_size))
    select(dataset, scored, tmp_path / "kept", Wanted("cfds", 24))
    return (tmp_path / "kept" / "report.html").read_text()


def decoded(source):
    kind, _, data = source.partition(",")
    assert kind == "data:image/jpeg;base64"
    return cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)


def test_nothing_lies_outside_the_page(page):
    refers = [each for each in Page(page).refers if not each.startswith(("#", "data:image/"))]
    assert refers == []
    assert "http" not in re.sub(r'xmlns(:xlink)?="[^"]*"', "", page)


def test_galleries_show_kept_and_dropped_images(page):
    found = Page(page)
    assert found.headings[0] == "24 of 60 images"
    shown = {key: [int(alt[-6:]) for alt, _ in row] for key, row in found.pictures.items()}
    assert shown == {
        # The easiest of all cannot be read, which the page says in its place.
        ("Kept", "Easiest"): [58, 57, 56, 55, 54],
        ("Kept", "Median"): [50, 49, 48, 47, 46, 45],
        ("Kept", "Hardest"): [41, 40, 39, 38, 37, 36],
        ("Dropped", "Easiest"): [35, 34, 33, 32, 31, 30],
        ("Dropped", "Median"): [20, 19, 18, 17, 16, 15],
        ("Dropped", "Hardest"): [5, 4, 3, 2, 1, 0],
    }
    assert "cannot be read" in page and "loss 0.31" in found.text


def test_thumbnails_are_the_images_with_their_points(page):
    found = Page(page)
    for pictures in found.pictures.values():
        for alt, source in pictures:
            picture, number = decoded(source), int(alt[-6:])
            assert picture.shape == (96, 48, 3)
            assert abs(picture[3, 40].astype(int) - (60 + number)).max() <= 3
            for v in (20 + number, 60 + number):
                # A ring of 3 px around (10.5, v), where it lies in the picture, on a picture of one grey.
                if v < 92:
                    assert centre(picture[v - 8 : v + 8, 2:19], 60 + number) == pytest.approx((8.5, 8), abs=0.6)


def centre(picture, tone):
    """The middle, continuous, of what is not of a tone."""
    v, u = np.nonzero(np.abs(picture.astype(int) - tone).max(2) > 40)
    return u.mean() + 0.5, v.mean() + 0.5


def test_points_on_a_picture_that_is_reduced(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), np.full((300, 800, 3), 90, np.uint8))
    frame = Frame(800, 300, 40.0)
    example = Example("a", tmp_path / "a.png", frame, np.array([[602.0, 122.0]]), None, None, None)
    found = decoded(Page("<h2></h2><h3></h3>" + report._thumbnail(example, "a")).pictures["", ""][0][1])
    assert found.shape == (75, 200, 3)
    assert centre(found, 90) == pytest.approx((150.5, 30.5), abs=0.6)


def test_the_table_counts_domains_and_plates(page):
    rows = {row[0]: row[1:] for row in Page(page).rows if row}
    assert rows["all domains"][0] == "24 / 60" and rows["all domains"][1] == "13 / 13"
    kept = [k for k in range(36, 60)]
    for domain, remainder in (("<b>base", 0), ("noise+wet", 1), ("not known", 2)):
        taken = [k for k in kept if k % 3 == remainder]
        assert rows[domain][0] == f"{len(taken)} / 20"
        plates = {k % 13 for k in taken}
        assert rows[domain][1] == f"{len(plates)} / {len({k % 13 for k in range(60) if k % 3 == remainder})}"
    head = rows["domain"]
    assert head[2] == "plate00" and head[-1] == "3 others"
    for plate in range(10):
        of = [k for k in range(60) if k % 13 == plate]
        column = head.index(f"plate{plate:02d}")
        assert rows["all domains"][column] == f"{len(set(of) & set(kept))} / {len(of)}"


def test_names_are_text_and_no_html(page):
    assert "<b>" not in page and "&lt;b&gt;base" in page


def test_the_figure_has_a_panel_a_domain(page):
    svg = page[page.index("<svg") : page.index("</svg>")]
    for title in (
        "&lt;b&gt;base: 8 of 20",
        "noise+wet: 8 of 20",
        "not known: 8 of 20",
        "point loss",
        "kept",
        "dropped",
    ):
        assert title in svg


def drawn(count, domains, kept=None, loss=None):
    rng = np.random.default_rng(1)
    loss = rng.random(count) if loss is None else np.asarray(loss, float)
    return losses.losses(loss, domains, np.arange(count) % 3 == 0 if kept is None else np.asarray(kept))


def test_rare_domains_share_a_panel():
    domains = [f"d{k:02d}" for k in range(20) for _ in range(20 - k)]
    assert losses.panels(domains) == [*(f"d{k:02d}" for k in range(11)), "others"]
    kept = np.arange(len(domains)) % 2 == 0
    rare = np.array([domain >= "d11" for domain in domains])
    assert f"others: {(kept & rare).sum()} of {rare.sum()}" in drawn(len(domains), domains, kept)
    assert losses.panels([f"d{k}" for k in range(3)] * 2) == ["d0", "d1", "d2"]


@pytest.mark.parametrize(
    "loss", [[0.0], [0.3, 0.3], [0.0, 1.0], [1e-9, 10.0], [1e-300, 1e-299], [5e-324, 1.0], [0.0, 0.0, 0.0]]
)
def test_losses_of_any_size_are_drawn(loss):
    edges, _ = losses._edges(np.array(loss))
    assert (np.diff(edges) > 0).all() and edges[0] <= min(loss) and edges[-1] >= max(loss)
    assert "</svg>" in drawn(len(loss), ["a"] * len(loss), loss=loss)


def test_all_kept_or_none():
    for kept in (True, False):
        assert "</svg>" in drawn(4, list("aabb"), [kept] * 4)


def test_the_figure_is_the_same_bytes():
    domains = ["a", "b"] * 10
    assert drawn(20, domains) == drawn(20, domains)


def test_a_selection_that_keeps_all(tmp_path):
    dataset = made(tmp_path / "dataset", 3)
    scored = scores(tmp_path / "scores", dataset, [(f"images/{k:06d}", 0.1) for k in range(3)])
    select(dataset, scored, tmp_path / "kept", Wanted("random", 3))
    text = (tmp_path / "kept" / "report.html").read_text()
    assert "No image was dropped." in text and len(Page(text).pictures[("Kept", "All, easiest first")]) == 3


def test_the_table_takes_no_longer_for_many_plates_in_many_domains():
    order = [Candidate(f"images/{k}", 0.1, f"p{k}", f"d{k}") for k in range(3000)]
    start = time.process_time()
    told = report._table(order, {"images/7"})
    assert time.process_time() - start < 3  # tens of seconds, were each plate looked up in each domain
    assert '<td>d7</td><td class="number">1 / 1</td><td class="number">1 / 1</td>' in told
