"""hmdwarp study export and measure, as they are typed."""

import pytest
from typer.testing import CliRunner

from hmdwarp.cli._app import app
from hmdwarp.errors import InputError

from ..made_up import LATE_OR_WARPED as TEXT


def run(*words):
    done = CliRunner().invoke(app, ["study", *map(str, words)])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


@pytest.fixture
def study(store, tmp_path):
    (tmp_path / "late.toml").write_text(TEXT, encoding="utf-8")
    return (tmp_path / "late.toml", "--store", store.folder)


def test_an_export_is_for_its_owner_alone_and_says_how_texts_are_written(study, tmp_path):
    (tmp_path / "out").mkdir(mode=0o755)
    run("export", *study, "--out", tmp_path / "out")
    modes = {path.stat().st_mode & 0o777 for path in (tmp_path / "out").rglob("*") if path.is_file()}
    folders = {
        path.stat().st_mode & 0o777 for path in (tmp_path / "out", *(tmp_path / "out").rglob("*")) if path.is_dir()
    }
    assert (modes, folders) == ({0o600}, {0o700})
    assert "apostrophe" in (tmp_path / "out" / "README").read_text()


def test_pilots_are_exported_on_request(study, tmp_path):
    assert "1 participant (a pilot, who tried the study out) in 1 session, " in run(
        "export", *study, "--out", tmp_path / "out", "--pilot"
    )
    with pytest.raises(InputError, match="one after the other"):
        run("export", *study, "--out", tmp_path / "both", "--pilot", "--simulated")
    assert run("export", *study, "--out", tmp_path / "quiet", "--quiet", "--no-parquet") == ""
    assert not (tmp_path / "quiet" / "ratings.parquet").exists()


def test_a_folder_without_data_is_reported(study, tmp_path):
    for command in (("export", "--out", tmp_path / "out"), ("measure",)):
        with pytest.raises(InputError, match="there are no data of 'late-or-warped' yet"):
            run(command[0], study[0], "--store", tmp_path / "nothing", *command[1:])
    assert not (tmp_path / "nothing").exists() and not (tmp_path / "out").exists()
