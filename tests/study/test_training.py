"""Many runs are trained at a time, each once, and whoever stops them leaves nothing behind."""

import importlib.metadata
import re

import attrs
import numpy as np
import pretended
import psutil
import pytest

from pavemark.detect.example import Example
from pavemark.errors import InputError
from pavemark.ground import Frame
from pavemark.study import runs
from pavemark.study.design import Training
from pavemark.study.runs import Run
from pavemark.study.training import train_all


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Of one image, one step and seed 0; no torch is needed."""
    monkeypatch.setattr(importlib.metadata, "version", lambda package: "2")
    monkeypatch.setattr(runs, "model", pretended.model)
    monkeypatch.setattr(runs, "train", pretended.trained)
    image = tmp_path / "a.png"
    image.write_bytes(b"a")
    example = Example("a", image, Frame(48, 64, 10.0), np.array([[3.0, 4.0]]), None, None, None)
    return Run((example,), 1, 0, Training(), 10.0)


def models(folder):
    return sorted(path.name for path in (folder / "models").iterdir())


def test_each_is_trained_once(tmp_path, run):
    lines = []
    wanted = [("a", run), ("again", attrs.evolve(run)), ("b", attrs.evolve(run, seed=1))]
    train_all(wanted, tmp_path, 2, lines.append)
    assert models(tmp_path) == ["1-0.onnx", "1-1.onnx"]
    assert sorted(line.split(": ")[1] for line in lines) == ["again", "b"]
    assert [line.split(":")[0] for line in lines] == ["trained 1/2", "trained 2/2"]
    train_all(wanted, tmp_path, 2, lines.append)
    assert len(lines) == 2


def test_what_others_start_from_comes_first(tmp_path, run):
    lines = []
    others = [attrs.evolve(run, steps=2, seed=seed, start=run) for seed in (0, 1)]
    train_all([("a", others[0]), ("b", others[1])], tmp_path, 2, lines.append)
    assert models(tmp_path) == ["1-0.onnx", "2-0.onnx", "2-1.onnx"]
    assert lines[0].startswith("trained 1/1")


def test_what_stops_it_leaves_no_process_and_no_half_file(tmp_path, run, monkeypatch):
    monkeypatch.setattr(runs, "train", pretended.slow)
    wanted = [(f"{steps}", attrs.evolve(run, steps=steps)) for steps in (9, 1, 8, 7)]

    def stop(line):
        assert [path for path in (tmp_path / "models").iterdir() if path.suffix == ".part"]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_all(wanted, tmp_path, 2, stop)
    assert models(tmp_path) == ["1-0.onnx"]
    assert not [each for each in psutil.Process().children() if "spawn_main" in " ".join(each.cmdline())]


def test_what_a_process_is_refused_is_told(tmp_path, run, monkeypatch):
    monkeypatch.setattr(runs, "train", pretended.refused)
    with pytest.raises(InputError, match=rf"^{re.escape(str(tmp_path))}: steps = 1: fewer are allowed$"):
        train_all([("a", run)], tmp_path, 1, print)


def test_a_process_that_is_killed(tmp_path, run, monkeypatch):
    monkeypatch.setattr(runs, "train", pretended.killed)
    with pytest.raises(InputError, match=r"^--workers: 1: one was ended, as where memory runs out"):
        train_all([("a", run)], tmp_path, 1, print)


def test_without_torch(tmp_path, run, monkeypatch):
    def none(package):
        raise importlib.metadata.PackageNotFoundError(package)

    monkeypatch.setattr(importlib.metadata, "version", none)
    with pytest.raises(InputError, match=r"torch is missing: pip install 'pavemark\[train\]'"):
        train_all([("a", run)], tmp_path, 1, print)
