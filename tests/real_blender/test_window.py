"""The workflow in a window, by operators and clicks, from the installed zip; photographs are kept in $PHOTOGRAPHS."""

import json
import os
import shutil
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def workflow(blender, demo, tmp_path_factory):
    """What window.py told, and where its photographs are."""
    if not os.environ.get("DISPLAY"):
        pytest.skip("no window can be had: $DISPLAY is not set")
    out = tmp_path_factory.mktemp("window")
    size = ("-p", "0", "0", "1400", "900")
    # With plates of its own: those that a test before has made would be shown at once, and nothing be removed.
    own = {"PAVEMARK_CACHE": str(tmp_path_factory.mktemp("cache"))}
    blender.run(*size, "--enable-event-simulate", "-P", HERE / "window.py", "--", demo, out, **own)
    if kept := os.environ.get("PHOTOGRAPHS"):
        shutil.copytree(out, kept, dirs_exist_ok=True)
    return json.loads((out / "told.json").read_text()), out


def test_it_runs_from_end_to_end(workflow):
    told, _ = workflow
    assert "failed" not in told, told.get("failed")
    assert told["done"]
    assert told["trouble"] == ""


def test_the_view_shows_the_background(workflow):
    told, _ = workflow
    assert told["ground_seen"], f"still empty after {told['looks']} looks"


def test_markings_are_removed_while_blender_goes_on(workflow):
    told, _ = workflow
    assert told["removed"] == ["INFO", "Markings removed"]
    assert told["clean"]


def test_three_clicks_make_a_slot_where_they_were(workflow):
    told, _ = workflow
    assert told["with_new"] == told["drawn"] + 1
    # To the pixel of the window that was clicked on.
    corners = sorted(map(tuple, told["new_corners"][:2]))
    assert np.allclose(corners, [(-1.6, -3.0), (-1.6, -0.4)], atol=0.03)


def test_a_dragged_slot_takes_its_label_along_by_itself(workflow):
    told, _ = workflow
    moved = np.subtract(told["after_drag"], told["before_drag"])
    assert np.allclose(moved, (-0.25, 0.0), atol=1e-5)


def test_image_and_labels_are_saved(workflow):
    told, _ = workflow
    assert told["saved"] == [f"dataset/{kind}/000000.png" for kind in ("images", "masks", "slots")]


def test_the_batch_shows_progress_and_stops(workflow):
    told, out = workflow
    assert told["batch"][0] == "WARNING"
    assert list((out / "batch" / "images").glob("*.png"))
    assert told["opened"]


def test_every_step_was_photographed(workflow):
    _, out = workflow
    photographs = [cv2.imread(str(path)) for path in sorted(out.glob("*-*.png"))]
    assert len(photographs) == 8
    for before, after in pairwise(photographs):
        assert before.std() > 10
        assert before.shape != after.shape or np.abs(before.astype(int) - after).max() > 50
