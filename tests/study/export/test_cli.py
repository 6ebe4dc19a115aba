"""hmdwarp study export and measure, as they are typed."""

import pytest
from commands import hmdwarp

from ..made_up import LATE_OR_WARPED as TEXT


@pytest.fixture
def study(store, tmp_path):
    (tmp_path / "late.toml").write_text(TEXT, encoding="utf-8")
    return (tmp_path / "late.toml", "--store", store.folder)


def test_an_export_is_for_its_owner_alone_and_says_how_texts_are_written(study, tmp_path):
    (tmp_path / "out").mkdir(mode=0o755)
    assert hmdwarp("study", "export", *study, "--out", tmp_path / "out").returncode == 0
    modes = {path.stat().st_mode & 0o777 for path in (tmp_path / "out").rglob("*") if path.is_file()}
    folders = {
        path.stat().st_mode & 0o777 for path in (tmp_path / "out", *(tmp_path / "out").rglob("*")) if path.is_dir()
    }
    assert (modes, folders) == ({0o600}, {0o700})
    assert "apostrophe" in (tmp_path / "out" / "README").read_text()


def test_pilots_are_exported_on_request(study, tmp_path):
    export = "study", "export", *study, "--out"
    done = hmdwarp(*export, tmp_path / "out", "--pilot")
    assert "1 participant (a pilot, who tried the study out) in 1 session, " in done.stdout + done.stderr
    assert "one after the other" in hmdwarp(*export, tmp_path / "both", "--pilot", "--simulated").stderr
    quiet = hmdwarp(*export, tmp_path / "quiet", "--quiet", "--no-parquet")
    assert (quiet.returncode, quiet.stdout, quiet.stderr) == (0, "", "")
    assert not (tmp_path / "quiet" / "ratings.parquet").exists()


def test_a_folder_without_data_is_reported(study, tmp_path):
    for command in (("export", "--out", tmp_path / "out"), ("measure",)):
        done = hmdwarp("study", command[0], study[0], "--store", tmp_path / "nothing", *command[1:])
        assert done.returncode == 2 and "there are no data of 'late-or-warped' yet" in done.stderr
    assert not (tmp_path / "nothing").exists() and not (tmp_path / "out").exists()
