"""hmdwarp study init: a plan to begin with."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from hmdwarp.cli.study import app
from hmdwarp.errors import InputError
from hmdwarp.study.design import load_design, notes


def init(*arguments: str) -> str:
    result = CliRunner().invoke(app, ["init", *arguments])
    if result.exception is not None:
        raise result.exception
    return result.stdout


def test_the_plan_is_accepted_as_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "hmdwarp study plan mine.toml" in init("mine")
    design = load_design("mine.toml")
    assert design.name == "mine"
    assert [condition.name for condition in design.parts[0].conditions] == [
        "latency200-none", "latency200-forward", "latency400-none", "latency400-forward", "reference",
    ]  # fmt: skip
    assert {condition.settings["view"] for condition in design.parts[0].conditions} == {"flat"}
    assert all("odd number" in note for note in notes(design)), notes(design)


def test_files_are_overwritten_only_by_force(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="mine.toml exists already: .*--force"):
        init("mine")
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == "mine"
    init("mine", "--force")
    assert load_design("mine.toml").name == "mine"


@pytest.mark.parametrize("name", ["", "a/b", "..", "mine.toml", "a b"])
def test_a_name_that_no_study_has_is_refused(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="expected a (name|value)"):
        init(name)
    assert not list(tmp_path.iterdir())
