"""Models that users bring, from the command line to the plate."""

import builtins
import hashlib
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from onnx import TensorProto, helper, save

from networks import KINDS, network
from pavemark import assets, cli, onnx
from pavemark.background import models
from pavemark.background.inpainting import METHODS, choices, inpainter
from pavemark.background.plates import make_plate
from pavemark.background.reading import MaskTable
from pavemark.errors import InputError
from pavemark.job.config import Job, read


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("PAVEMARK_MODELS", str(tmp_path / "models"))
    monkeypatch.setenv("PAVEMARK_CACHE", str(tmp_path / "cache"))
    return tmp_path / "models"


def pavemark(capfd, *words):
    """Exit code, stdout and stderr of a command, in this process."""
    with pytest.raises(SystemExit) as left:
        cli.main([str(word) for word in words], [])
    said = capfd.readouterr()
    return left.value.code, said.out, said.err


def refused(capfd, *words):
    code, out, err = pavemark(capfd, *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ") and err.count("\n") == 1, err
    return err[len("error: ") : -1]


@pytest.mark.parametrize("kind", KINDS)
def test_add_list_and_remove(tmp_path, home, capfd, kind):
    file = network(tmp_path / "my_net-1.onnx", **KINDS[kind])
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    code, out, err = pavemark(capfd, "models", "add", file, "--licence", "ours")
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == "my_net-1"
    for told in (f"{kind}, white is {KINDS[kind]['white']:g}", digest, "no, not one of", "ours", str(file)):
        assert told in out
    record = json.loads((home / "my_net-1.json").read_text())
    assert record == {
        "name": "my_net-1",
        "file": str(file),
        "sha256": digest,
        "bytes": file.stat().st_size,
        "contract": kind,
        "white": KINDS[kind]["white"],
        "licence": "ours",
    }
    assert pavemark(capfd, "models", "list") == (0, out, "")
    assert choices() == (*METHODS, "pavemark", "my_net-1")
    assert pavemark(capfd, "models", "remove", "my_net-1") == (0, "", "")
    assert file.exists() and not list(home.iterdir())
    assert pavemark(capfd, "models", "list")[1].startswith("none:")
    assert refused(capfd, "models", "remove", "my_net-1").startswith("model 'my_net-1': is not recorded: allowed none")


def test_a_published_file_is_known_by_its_hash(tmp_path, capfd, monkeypatch):
    file = network(tmp_path / "net.onnx", **KINDS["migan"])
    monkeypatch.setitem(models.KNOWN, onnx.sha256(file), models.Known("MI-GAN", "a place", "MIT"))
    out = pavemark(capfd, "models", "add", file, "--name", "migan")[1]
    assert "MI-GAN of a place" in out and models.read("migan").licence == "MIT"
    assert pavemark(capfd, "models", "add", file, "--name", "two", "--licence", "bought")[0] == 0
    assert models.read("two").licence == "bought"


def test_the_published_files_are_pinned():
    assert all(len(digest) == 64 and int(digest, 16) for digest in models.KNOWN)
    page = (Path(__file__).parents[2] / "docs" / "models.md").read_text()
    for digest, known in models.KNOWN.items():
        assert digest in page and known.licence in page and known.source.split(",")[0] in page


BAD = {
    "empty": (lambda good: b"", "is empty: an ONNX model is allowed"),
    "text": (lambda good: b"version https://git-lfs.github.com/spec/v1\n", "is not an ONNX model that can be opened: "),
    "truncated": (lambda good: good[: len(good) // 2], "is not an ONNX model that can be opened: "),
    "cut by three bytes": (lambda good: good[:-3], "is not an ONNX model that can be opened: "),
    "picture": (lambda good: cv2.imencode(".png", np.zeros((9, 9), np.uint8))[1].tobytes(), "is not an ONNX model"),
}


@pytest.mark.parametrize("bad", BAD)
def test_what_is_no_model_is_refused(tmp_path, home, capfd, bad):
    spoil, told = BAD[bad]
    good = network(tmp_path / "good.onnx", **KINDS["pavemark"]).read_bytes()
    file = tmp_path / "bad.onnx"
    file.write_bytes(spoil(good))
    assert refused(capfd, "models", "add", file).startswith(f"{file}: {told}")
    assert not home.exists()


def test_a_missing_file_and_a_folder_are_refused(tmp_path, capfd):
    assert refused(capfd, "models", "add", tmp_path / "no.onnx").endswith(
        "no.onnx: cannot be read: No such file or directory"
    )
    assert refused(capfd, "models", "add", tmp_path).endswith("cannot be read: Is a directory")


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("lama-512", {"side": 256}),
        ("lama-512", {"output": "inpainted"}),
        ("lama-512", {"shape": [1, 512, 512, None], "fill": "shown"}),
        ("lama-512", {"batch": 2}),
        ("lama-dynamic", {"shape": [1, None, 512, "width"]}),
        ("migan", {"side": 512}),
        ("migan", {"output": "output"}),
        ("pavemark", {"byte": True}),
    ],
)
def test_a_graph_of_no_kind_is_told_with_what_is_allowed(tmp_path, home, capfd, kind, changes):
    file = network(tmp_path / "net.onnx", **KINDS[kind] | changes)
    said = refused(capfd, "models", "add", file)
    assert said.startswith(f"{file}: has image {'uint8' if kind == 'migan' or 'byte' in changes else 'float'} [")
    assert "allowed are lama-512: image float [1, 3, 512, 512]" in said and "migan: image uint8 [1, 3, ?, ?]" in said
    assert not home.exists()


def test_a_graph_without_outputs_is_of_no_kind(tmp_path, home, capfd):
    ports = (("image", 3), ("mask", 1))
    inputs = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, deep, "h", "w"]) for name, deep in ports]
    graph = helper.make_graph([helper.make_node("Identity", ["image"], ["filled"])], "none", inputs, [])
    file = tmp_path / "net.onnx"
    save(helper.make_model(graph, ir_version=8, opset_imports=[helper.make_opsetid("", 17)]), file)
    said = refused(capfd, "models", "add", file)
    assert said.startswith(f"{file}: has image float [1, 3, ?, ?], mask float [1, 1, ?, ?] → : allowed are lama-512: ")
    assert not home.exists()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("changes", [{"flip": True}, {"white": 7.0}, {"outside": "fill"}, {"bgr": True}])
def test_a_graph_that_does_not_do_what_its_kind_does_is_refused(tmp_path, home, capfd, kind, changes):
    told = KINDS[kind]
    if "flip" in changes:
        changes = {"hole_is": 1.0 - told.get("hole_is", 1.0)}
    file = network(tmp_path / "net.onnx", **told | changes)
    assert "misses pixels that it is shown by" in refused(capfd, "models", "add", file)
    assert not home.exists()


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "migan"])
def test_a_graph_that_fills_nothing_is_refused(tmp_path, home, capfd, kind):
    file = network(tmp_path / "net.onnx", **KINDS[kind] | {"fill": (0, 0, 0)})
    assert refused(capfd, "models", "add", file) == (
        f"{file}: leaves the hole black, as it was shown it: a network that fills it is allowed"
    )
    assert not home.exists()


def test_a_licence_is_a_line_of_text(tmp_path, home, capfd):
    file = network(tmp_path / "net.onnx", **KINDS["pavemark"])
    assert refused(capfd, "models", "add", file, "--licence", "a\nb\x1b[31m") == (
        "--licence: a\\nb\\x1b[31m: a line of printable text is allowed"
    )
    assert not home.exists()


def test_a_damaged_record_does_not_hide_the_others(tmp_path, home, capfd):
    for name in ("first", "second", "third"):
        models.add(network(tmp_path / f"{name}.onnx", **KINDS["pavemark"]), None, None, ())
    (home / "second.json").write_text("{")
    code, out, err = pavemark(capfd, "models", "list")
    assert code == 1 and "first.onnx" in out and "third.onnx" in out
    assert err.startswith(f"{home}/second.json: not a JSON file") and "pavemark models remove second" in err


def test_a_graph_without_numbers_is_refused(tmp_path, home, capfd):
    file = network(tmp_path / "net.onnx", fill=(0.5, np.nan, 0.5), **KINDS["pavemark"])
    assert "no finite numbers" in refused(capfd, "models", "add", file)
    assert not home.exists()


@pytest.mark.parametrize("name", ["", "../x", "a b", ".x", "x" * 65, "é"])
def test_names_that_are_none(tmp_path, capfd, name):
    file = network(tmp_path / "net.onnx", **KINDS["pavemark"])
    assert "--name: " in refused(capfd, "models", "add", file, "--name", name)


@pytest.mark.parametrize("name", [*METHODS, "pavemark", "mine"])
def test_names_that_are_taken(tmp_path, capfd, name):
    file = network(tmp_path / "net.onnx", **KINDS["pavemark"])
    models.add(file, "mine", None, ())
    assert refused(capfd, "models", "add", file, "--name", name) == f"--name: {name!r} is taken: another one is allowed"


def test_a_file_that_moved_or_changed_is_an_error(tmp_path, capfd):
    file = network(tmp_path / "net.onnx", fill=(1, 0, 0), **KINDS["pavemark"])
    models.add(file, None, None, ())
    assert inpainter("net").name == "net"
    network(file, fill=(0, 1, 0), **KINDS["pavemark"])
    with pytest.raises(InputError, match=r"net\.onnx: has changed, sha256 was .* and is .*: model 'net' was recorded"):
        inpainter("net")
    job = ("render", "--images", tmp_path, "--out", tmp_path / "out", "--inpainter", "net")
    assert refused(capfd, *job).startswith(f"command line: {file}: has changed")
    file.rename(tmp_path / "elsewhere.onnx")
    assert refused(capfd, *job).startswith(f"command line: {file}: is missing: model 'net' was recorded from it")
    assert ", is missing" in pavemark(capfd, "models", "list")[1]
    assert not (tmp_path / "out").exists()


def test_a_damaged_record_is_an_error_and_can_be_removed(tmp_path, home, capfd):
    models.add(network(tmp_path / "net.onnx", **KINDS["pavemark"]), None, None, ())
    record = home / "net.json"
    good = record.read_text()
    for bad, told in (
        ("{", "not a JSON file"),
        (good.replace("pavemark", "lamb"), "contract = 'lamb': allowed lama-512"),
        (good.replace('"net"', '"ten"'), "name = 'ten': allowed is 'net'"),
        (good.replace('"contract": "pavemark"', '"contract": "migan"'), "is of the kind pavemark: migan is recorded"),
    ):
        record.write_text(bad)
        with pytest.raises(InputError, match=told):
            models.checked(models.read("net"))
    assert pavemark(capfd, "models", "remove", "net")[0] == 0


def test_a_job_takes_recorded_names(tmp_path):
    models.add(network(tmp_path / "net.onnx", **KINDS["pavemark"]), None, None, ())
    assert read(None, {"images": str(tmp_path), "inpainter": "net"}).inpainter == "net"
    with pytest.raises(ValueError, match=r"inpainter = 'nit': allowed patchmatch, fsr, navier-stokes, pavemark, net$"):
        Job(images="x", inpainter="nit")


def test_our_own_network_is_found_among_the_assets(tmp_path, monkeypatch):
    file = network(tmp_path / "inpainter.onnx", fill=(1, 0, 0), **KINDS["pavemark"])
    monkeypatch.setattr(assets, "path", lambda name: {"models/inpainter.onnx": file}[name])
    ours = inpainter("pavemark")
    assert ours.name == "pavemark" and onnx.sha256(file) in ours.version
    hole = np.zeros((30, 40), bool)
    hole[10, 10:20] = True
    assert (ours.fill(np.full((30, 40, 3), 90, np.uint8), hole, ~hole & False)[hole] == (255, 0, 0)).all()


def test_plates_of_another_network_under_the_same_name_are_made_anew(tmp_path):
    image, mask = np.full((60, 60, 3), 90, np.uint8), np.zeros((60, 60), np.uint8)
    mask[30:33, 20:40] = 1
    (tmp_path / "masks").mkdir()
    cv2.imwrite(str(tmp_path / "a.png"), image)
    cv2.imwrite(str(tmp_path / "masks" / "a.png"), mask)
    for fill in ((1, 0, 0), (0, 0, 1)):
        models.add(network(tmp_path / f"{fill[0]}.onnx", fill=fill, **KINDS["pavemark"]), "net", None, ())
        plate = make_plate(tmp_path / "a.png", tmp_path / "masks" / "a.png", 20.0, MaskTable(ground=(0,)), "net")
        assert (plate.image[mask > 0] == np.multiply(fill, 255)).all()
        models.remove("net")


def test_files_are_opened_once_and_again_when_they_changed(tmp_path):
    file = network(tmp_path / "net.onnx", **KINDS["pavemark"])
    first = onnx.opened(file)
    assert onnx.opened(file) is first
    network(file, fill="mean", **KINDS["pavemark"])
    assert onnx.opened(file).sha256 == hashlib.sha256(file.read_bytes()).hexdigest() != first.sha256
    assert [str(port) for port in first.inputs] == ["image float [1, 3, ?, ?]", "mask float [1, 1, ?, ?]"]


def test_weights_in_other_files_are_refused(tmp_path, monkeypatch):
    import onnx as library  # noqa: PLC0415

    model = library.load(network(tmp_path / "net.onnx", **KINDS["pavemark"]))
    library.save(model, tmp_path / "ext.onnx", save_as_external_data=True, location="w.data", size_threshold=0)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"ext\.onnx: is not an ONNX model that can be opened: .*External data"):
        onnx.opened(tmp_path / "ext.onnx")


def test_without_onnxruntime_it_says_what_needs_no_network(tmp_path, monkeypatch):
    def without(name, *rest, **more):
        if name.startswith("onnxruntime"):
            raise ImportError(name)
        return real(name, *rest, **more)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", without)
    onnx._opened.cache_clear()
    with pytest.raises(InputError, match=r'package is missing.*segmenter = "strokes", inpainter = "patchmatch"'):
        onnx.opened(network(tmp_path / "net.onnx", **KINDS["pavemark"]))


def test_where_models_are_recorded(monkeypatch):
    monkeypatch.delenv("PAVEMARK_MODELS")
    monkeypatch.setenv("XDG_DATA_HOME", "/somewhere")
    assert models.folder() == Path("/somewhere/pavemark/models")
    monkeypatch.delenv("XDG_DATA_HOME")
    monkeypatch.setenv("HOME", "/home/me")
    assert models.folder() == Path("/home/me/.local/share/pavemark/models")


def test_a_record_that_cannot_be_written_leaves_nothing(tmp_path, home, capfd):
    home.write_text("a file")
    file = network(tmp_path / "net.onnx", **KINDS["pavemark"])
    assert "cannot be written" in refused(capfd, "models", "add", file)
    shutil.copy(file, tmp_path / "copy.onnx")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy.onnx", "models", "net.onnx"]
