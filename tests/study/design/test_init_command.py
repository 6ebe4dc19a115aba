"""hmdwarp study init: a plan to begin with."""

from __future__ import annotations

import re

import pytest
from commands import hmdwarp

from hmdwarp.study.design import load_design, notes


def test_the_plan_is_accepted_as_it_is(tmp_path):
    assert "hmdwarp study plan mine.toml" in hmdwarp("study", "init", "mine", folder=tmp_path).stdout
    design = load_design(str(tmp_path / "mine.toml"))
    assert design.name == "mine"
    assert [condition.name for condition in design.parts[0].conditions] == [
        "latency200-none", "latency200-forward", "latency400-none", "latency400-forward", "reference",
    ]  # fmt: skip
    assert {condition.settings["view"] for condition in design.parts[0].conditions} == {"flat"}
    assert all("odd number" in note for note in notes(design)), notes(design)


def test_files_are_overwritten_only_by_force(tmp_path):
    (tmp_path / "mine.toml").write_text("mine", encoding="utf-8")
    told = hmdwarp("study", "init", "mine", folder=tmp_path)
    assert told.returncode == 2 and "mine.toml exists already: " in told.stderr and "--force" in told.stderr
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == "mine"
    assert hmdwarp("study", "init", "mine", "--force", folder=tmp_path).returncode == 0
    assert load_design(str(tmp_path / "mine.toml")).name == "mine"


@pytest.mark.parametrize("name", ["", "a/b", "..", "mine.toml", "a b"])
def test_a_name_that_no_study_has_is_refused(tmp_path, name):
    told = hmdwarp("study", "init", name, folder=tmp_path)
    assert told.returncode == 2 and re.search("expected a (name|value)", told.stderr)
    assert not list(tmp_path.iterdir())
