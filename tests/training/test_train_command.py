"""`pavemark train` refuses before it draws anything."""

import importlib.util

import pytest

from pavemark import cli


def refused(capfd, *words):
    with pytest.raises(SystemExit) as left:
        cli.main(["train", *map(str, words)])
    assert left.value.code == 2
    said = capfd.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1
    return said.removeprefix("error: ").strip()


@pytest.mark.skipif(importlib.util.find_spec("torch") is not None, reason="torch is installed")
def test_without_torch_it_says_what_to_install(tmp_path, capfd):
    said = refused(capfd, "segmenter", "--out", tmp_path / "model.onnx", "--pool", tmp_path / "pool")
    assert "is missing: pip install 'pavemark[train]'" in said
    assert not (tmp_path / "pool").exists()


def test_a_network_that_there_is_not(tmp_path, capfd):
    assert "No such command 'segmenters'" in refused(capfd, "segmenters", "--out", "a.onnx")


def test_a_model_is_not_written_over(tmp_path, capfd):
    (tmp_path / "model.onnx").write_bytes(b"weeks of work")
    assert "is there already" in refused(capfd, "segmenter", "--out", tmp_path / "model.onnx")
    assert (tmp_path / "model.onnx").read_bytes() == b"weeks of work"


def test_where_nothing_can_be_written_nothing_is_begun(tmp_path, capfd):
    (tmp_path / "file").write_text("")
    for words in (("--out", tmp_path / "file" / "a.onnx"), ("--out", tmp_path / "a.onnx", "--pool", tmp_path / "file")):
        said = refused(capfd, "segmenter", *words)
        assert "cannot be written" in said or "is missing: pip install" in said
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_another_ending_is_refused(tmp_path, capfd):
    assert "a file ending in .onnx is allowed" in refused(capfd, "inpainter", "--out", tmp_path / "model.pt")


def test_a_detector_needs_data(tmp_path, capfd):
    assert "Missing option '--data'" in refused(capfd, "detector", "--out", tmp_path / "a.onnx")


def test_a_family_that_there_is_not(tmp_path, capfd):
    said = refused(capfd, "detector", "--family", "yolo", "--data", tmp_path, "--out", tmp_path / "a.onnx")
    assert "'yolo' is not one of 'dmpr', 'gcn', 'deepps'" in said


def test_a_share_for_each_dataset(tmp_path, capfd):
    words = ("--data", tmp_path, "--data", tmp_path, "--share", "0.5", "--out", tmp_path / "a.onnx")
    assert "1 for 2 datasets" in refused(capfd, "detector", *words)


def test_weights_are_not_written_over(tmp_path, capfd):
    (tmp_path / "a.pt").write_bytes(b"weeks of work")
    assert "a.pt: is there already" in refused(capfd, "detector", "--data", tmp_path, "--out", tmp_path / "a.onnx")
    assert (tmp_path / "a.pt").read_bytes() == b"weeks of work"
