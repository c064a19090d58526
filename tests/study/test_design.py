"""A study file is read as it stands, and what is wrong with one is told."""

import re

import pytest
from real import STUDY, study

from pavemark.errors import InputError
from pavemark.study import pools
from pavemark.study.design import only, read


def test_a_study_file(tmp_path):
    found = study(tmp_path)
    assert found.real == str(tmp_path / "real")
    assert found.scale == 10.0
    assert [row.name for row in found.rows] == ["real", "easiest"]
    assert found.rows[1].keep == 3 and found.rows[1].seeds == (0,)


def test_some_rows_alone(tmp_path):
    found = study(tmp_path)
    assert only(found, ()) is found
    assert [row.name for row in only(found, ("easiest",)).rows] == ["real", "easiest"]
    assert [row.name for row in only(found, ("real",)).rows] == ["real"]
    with pytest.raises(InputError, match="--only: 'hardest': allowed real, easiest"):
        only(found, ("hardest",))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('test = ["east"]', 'test = ["north"]', "'north' is listed twice"),
        ('test = ["east"]', "test = []", "test = \\[\\]: at least one place"),
        ('judge = "real"', 'judge = "easiest"', "judge = 'easiest': the name of a row of real images alone"),
        ('judge = "real"', 'judge = "nobody"', "judge = 'nobody'"),
        ("keep = 3", "", "strategy = 'cfds': pools and keep are needed"),
        ('strategy = "cfds"', "", "keep = 3: with a strategy"),
        ('strategy = "cfds"', 'strategy = "best"', "strategy"),
        ('"cfds"', '"learnable"\nscored_by = "learner"', "easiest: scored_by = 'learner': with 'learnable' it is not"),
        ('"cfds"', '"like-real"\nscored_by = "learner"', "easiest: scored_by = 'learner': with 'like-real' it is not"),
        ('"cfds"', '"cfds"\nscored_by = "nobody"', "scored_by"),
        ("real = 1.0", "", "real: neither real nor pools"),
        ("real = 1.0", "real = 1.5", "1.5"),
        ("real = 1.0", "real = 1.0\nseeds = []", "seeds = \\[\\]"),
        ("real = 1.0", "real = 1.0\nseeds = [1, 1]", "each once"),
        ("real = 1.0", "real = 1.0\nfine_tune = true", "fine_tune: both pools"),
        ('pools = ["base"]', 'pools = ["bass"]', "easiest: pools: 'bass': allowed base"),
        ('name = "easiest"', 'name = "real"', "'real' is there twice"),
        ("height = 6.4", "", "height"),
        ("steps = 4", "steps = 0", "steps = 0"),
        ("real = 1.0", "real = 1.0\nseeds = [0, -1]", "0 or more"),
        ("frame = [48, 64]", "frame = [0, 64]", "frame = \\[0, 64\\]"),
        ("[pools.base]\ncount = 6", "[pools]\nbase = 6", "pools.base = 6: a table"),
        ("[pools.base]", '[pools."../base"]', "pools: '../base': the name of a folder"),
        ('pools = ["base"]', 'pools = ["base"]\nreal = 1.0\nfine_tune = true\nparts = 2', "fine_tune: with parts = 2"),
        ("batch = 2", "bach = 2", "bach"),
        ("batch = 2", "batch = 1", "batch = 1"),
        ("real = 1.0", "real = 1.0\nseeds = [4294967296]", "up to 4294967295"),
        ("frame = [48, 64]", "frame = [7680, 10240]", "height = 6.4: 1600 pixels a metre"),
        ("[places]", "[places", "not a TOML file"),
    ],
)
def test_a_study_file_that_is_wrong(tmp_path, old, new, said):
    assert STUDY.count(old)
    with pytest.raises(InputError, match=rf"study.toml: .*{said}"):
        study(tmp_path, STUDY.replace(old, new, 1))


def test_no_study_file(tmp_path):
    with pytest.raises(InputError, match=re.escape(f"{tmp_path / 'none.toml'}: cannot be read")):
        read(tmp_path / "none.toml")


def test_pools_that_no_row_learns_from_are_not_made(tmp_path):
    more = STUDY + '\n[pools.bent]\nlike = "base"\n'
    assert pools.there(study(tmp_path, more), tmp_path) == {"base": tmp_path / "pools" / "base"}
    assert pools.there(only(study(tmp_path, more), ("real",)), tmp_path) == {}
    # And no plates for them.
    assert pools.make(only(study(tmp_path, more), ("real",)), (), tmp_path / "out", 1) == {}
    assert not (tmp_path / "out").exists()


def test_a_pool_starts_from_another(tmp_path):
    text = STUDY + '\n[every_pool]\nseed = 5\n\n[pools.bent]\nlike = "base"\ncurvature = { rate = 1.0 }\n'
    found = study(tmp_path, text)
    like, base = (pools.job(found, pool, tmp_path) for pool in ("bent", "base"))
    assert (like.count, like.seed, like.curvature.rate) == (6, 5, 1.0)
    assert base.curvature.rate == 0.5 and base.plates == str(tmp_path) and base.formats == ("dmpr",)
    wrong = study(tmp_path, STUDY + '\n[pools.bent]\nlike = "later"\n')
    with pytest.raises(InputError, match=r"pools.bent: like = 'later': a pool before it is allowed: base"):
        pools.job(wrong, "bent", tmp_path)
    wrong = study(tmp_path, STUDY + "\n[pools.bent]\nnoize = 3\n")
    with pytest.raises(InputError, match=r"pools.bent: .*noize"):
        pools.job(wrong, "bent", tmp_path)
    with pytest.raises(InputError, match=r"pools.bent: .*noize"):
        pools.make(wrong, (), tmp_path / "out", 1)
    assert not (tmp_path / "out").exists()
