"""max_error in a job: rays an image, from the table that ships or a file, and a record that says which."""

import json

import attrs
import pytest

from commandline import PROGRAM, contents, pavemark
from pavemark import calibration, cli
from pavemark.calibration import shipped
from pavemark.records import to_json


@pytest.fixture
def job(arguments):
    """A job with worn paint in every image."""
    effects = [f"texture.{name}.rate = 1.0" for name in ("grain", "wear", "chips")]
    worn = [word for line in (*effects, "layout.empty_rate = 0.0") for word in ("--set", line)]
    return [*arguments, "--count", "4", *worn]


@pytest.fixture
def table(tmp_path):
    """A table that trusts nothing: with one ray an effect is off by all there is."""
    path = tmp_path / "rays.json"
    strict = shipped()
    effects = dict.fromkeys(calibration.STRENGTH, 9.0)
    path.write_text(to_json(attrs.evolve(strict, one_ray=[attrs.evolve(row, **effects) for row in strict.one_ray])))
    return path


def rays(out):
    """Of each image that has paint; some of these small ones have no room for any."""
    scenes = [json.loads(path.read_text()) for path in sorted((out / "scenes").iterdir())]
    assert all("rays" not in scene for scene in scenes if "markings" not in scene)
    return [scene.get("rays", 1) for scene in scenes if "markings" in scene]


def refused(capfd, *words):
    """The one line that a command is refused with, in this process."""
    with pytest.raises(SystemExit) as left:
        cli.main([str(word) for word in words], [*PROGRAM, "--worker"])
    said = capfd.readouterr()
    assert left.value.code == 2
    assert said.err.startswith("error: ") and said.err.count("\n") == 1, said.err
    return said.err[len("error: ") : -1]


def test_a_smaller_error_takes_more_rays_and_nothing_else_changes(job, tmp_path):
    outs = {}
    for error in ("none", "1", "4", "200"):
        outs[error] = tmp_path / error
        asked = () if error == "none" else ("--max-error", error)
        assert pavemark(*job, *asked, "--out", outs[error]).returncode == 0
    found = {error: rays(out) for error, out in outs.items()}
    assert found["none"] == found["200"] == [1] * len(found["1"]) != []
    assert min(found["1"]) > 1 and sum(found["1"]) > sum(found["4"])
    plain, exact = (contents(outs[error]) for error in ("none", "1"))
    for name in plain:
        if name.startswith("scenes/"):
            scene = json.loads(exact[name])
            assert (scene.pop("rays", 1) > 1) == ("markings" in scene) and scene == json.loads(plain[name])
        elif name != "job.json":
            assert exact[name] == plain[name], "this renderer is exact with any number of rays"
    assert not {"max_error", "calibration", "rays"} & json.loads(plain["job.json"]).keys()
    told = json.loads(exact["job.json"])
    assert (told["max_error"], told["calibration"]) == (1.0, None)
    assert told["rays"] == {"versions": shipped().versions, "sha256": shipped().sha256}


def test_the_job_file_says_it_too_and_names_a_table_beside_it(job, table, tmp_path):
    (tmp_path / "job.toml").write_text('max_error = 8.0\ncalibration = "rays.json"\n')
    done = pavemark("render", tmp_path / "job.toml", *job[1:], "--out", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert min(rays(tmp_path / "out")) > 1
    told = json.loads((tmp_path / "out/job.json").read_text())
    assert told["calibration"] == "../rays.json" and told["rays"]["sha256"] != shipped().sha256
    assert pavemark("preview", tmp_path / "out").returncode == 0


def test_a_folder_goes_on_with_the_table_that_it_was_begun_with(job, table, tmp_path, capfd):
    asked = [*job, "--max-error", "8", "--calibration", table, "--out", tmp_path / "out"]
    assert pavemark(*asked).returncode == 0
    moved = table.rename(tmp_path / "moved.json")
    asked[asked.index(table)] = moved
    assert pavemark(*asked).returncode == 0
    moved.write_text(to_json(attrs.evolve(calibration.read(moved), views=1)))
    assert "holds another job: rays.sha256 was " in refused(capfd, *asked)
    assert "max_error was 8.0 and is None" in refused(capfd, *job, "--out", tmp_path / "out")


def test_what_cannot_be_promised_is_refused_before_any_work(job, table, tmp_path, capfd):
    least = shipped().least
    most = shipped().rays[-1].number
    told = refused(capfd, *job, "--max-error", "0.01", "--out", tmp_path / "out")
    assert told.startswith("max_error: 0.01 8-bit levels: allowed from ")
    assert told.endswith(f"the least that can be promised, with {most} rays a pixel")
    allowed = float(told.split("allowed from ")[1].split(",")[0])
    assert least <= allowed < least + 0.01
    for words, line in (
        (("--calibration", table), f"calibration: {table}: says nothing without max_error"),
        (("--max-error", "4", "--calibration", tmp_path / "no.json"), f"{tmp_path / 'no.json'}: cannot be read: "),
        (("--max-error", "-1"), "command line: max_error = -1.0: allowed 0 to 255"),
        (("--max-error", "nan"), "command line: max_error: nan is not a finite number"),
        (("--max-error", "much"), "Invalid value for '--max-error': "),
    ):
        assert refused(capfd, *job, *words, "--out", tmp_path / "out").startswith(line)
    table.write_text(table.read_text().replace('"pavemark": "', '"pavemark": "0.'))
    told = refused(capfd, *job, "--max-error", "4", "--calibration", table, "--out", tmp_path / "out")
    assert told.startswith(f"{table}: was measured with pavemark 0.")
    assert not (tmp_path / "out").exists()
