"""A job with a network of the user's own."""

import numpy as np

from commandline import contents, pavemark
from networks import KINDS, network
from pavemark import onnx
from pavemark.background import models


def test_the_number_of_workers_does_not_matter(inputs, arguments, tmp_path, monkeypatch):
    monkeypatch.setenv("PAVEMARK_MODELS", str(tmp_path / "models"))
    models.add(network(tmp_path / "net.onnx", fill="mean", **KINDS["lama-dynamic"]), "mine", None, ())
    made = []
    for workers in (1, 2):
        out = tmp_path / str(workers)
        words = [*arguments, "--inpainter", "mine", "--workers", str(workers), "--count", "4", "--out", out]
        done = pavemark(*words, PAVEMARK_CACHE=str(tmp_path / f"cache{workers}"))
        assert (done.returncode, done.stderr) == (0, "")
        made.append(contents(out))
    assert made[0] == made[1] and any(name.startswith("images/") for name in made[0])


def test_a_network_that_gives_nothing_of_use_makes_no_image(inputs, arguments, tmp_path, monkeypatch):
    monkeypatch.setenv("PAVEMARK_MODELS", str(tmp_path / "models"))
    file = network(tmp_path / "net.onnx", **KINDS["lama-dynamic"])
    model = models.add(file, "mine", None, ())
    network(file, fill=(0.5, np.nan, 0.5), **KINDS["lama-dynamic"])
    record = tmp_path / "models" / "mine.json"
    record.write_text(record.read_text().replace(model.sha256, onnx.sha256(file)))
    done = pavemark(
        *arguments, "--inpainter", "mine", "--out", tmp_path / "out", PAVEMARK_CACHE=str(tmp_path / "cache")
    )
    assert done.returncode == 2
    # Of which image, too: the network may be of use on the others.
    for name in ("a", "b", "c"):
        image = inputs / "images" / f"{name}.png"
        assert f"left out: {image}: net.onnx: output holds values that are no finite numbers" in done.stderr
    assert not list((tmp_path / "out").rglob("*.png")) and "Traceback" not in done.stderr
