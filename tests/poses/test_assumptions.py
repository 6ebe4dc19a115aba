"""What a trace reader assumed is an entry of the loaded trace, with who says so."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from published_folders import write_colmap
from recorded_folders import taken
from regenerate import assumed_list
from ros_bags import HAS_ROSBAGS, write_ros1

from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.poses.assumptions import By, first_stated
from hmdwarp.poses.formats import formats

from .test_other_files import FILES, GOLDEN, STATED
from .test_trace_command import run
from .traces import WRITERS, head, rows, save, write

TRACK = head(100)


def by(loaded) -> dict[str, By]:
    """Who says each fact."""
    return {assumption.what: assumption.by for assumption in loaded.assumptions}


def test_facts_of_a_plain_header_are_said_by_the_file_or_by_nobody(tmp_path):
    loaded = load_trace(write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw"))
    unsaid = dict.fromkeys(("pose", "length", "axes", "up", "clock"), By.DEFAULT)
    assert by(loaded) == {"columns": By.FILE, "orientation": By.FILE} | unsaid


def test_facts_that_the_user_states_are_the_users(tmp_path):
    path = write(tmp_path / "a.csv", rows(TRACK), "a,b,c,d,e,f,g,h")
    stated = TraceOptions(columns="t=a,p=b+c+d,q=e+f+g+h", axes="openxr", scale=1.0, time_unit="s")
    assert {what for what, who in by(load_trace(path, stated)).items() if who is not By.USER} == {"pose"}


def test_trace_info_prints_nobody_with_the_option(tmp_path):
    path = write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw")
    text = run("info", path)
    assert "default; set with --axes" in text
    data = json.loads(run("info", path, "--json"))
    assert {"what": "clock", "value": "seconds", "by": "default", "option": "--time-unit"} in data["assumptions"]


def test_notes_name_what_nobody_says(tmp_path):
    notes = load_trace(write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw")).notes
    assert any(
        "not stated in the files" in note and "length 1 m per unit (override with --scale)" in note for note in notes
    )
    assert sum(note.count("--axes") for note in notes) == 1
    assert load_trace("walk").notes == []


def test_the_first_that_states_a_fact_is_believed():
    assert first_stated(None, 2.0, 3.0) == (2.0, By.FILE)
    assert first_stated(None, None, None) == (None, By.DEFAULT)


# One file of each format: written here, or the first of `files/` that was read as that.
SAMPLES: dict[str, Callable[[Path], Path]] = {
    "colmap": lambda folder: (write_colmap(folder, taken(3)), folder / "sparse/0/images.txt")[1],
    "rosbag": lambda folder: (write_ros1(folder, taken(3)), folder / "taken.bag")[1],
    **{form.name: partial(save, TRACK, name=form.name) for form in formats if form.writes},
}
for _name, _format in re.findall(r"^# (.+)\nformat: (.+)$", GOLDEN.read_text(encoding="utf-8"), re.M):
    if _name not in STATED:
        SAMPLES.setdefault(_format, lambda _, name=_name: FILES / name)
_MARKS = {param.values[0]: param.marks for param in WRITERS}
_MARKS["rosbag"] = (pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed"),)
_OWN_NAMES = ("colmap", "rosbag")
_OPTIONS = {"colmap": TraceOptions(rate=90.0)}  # of files without a clock


@pytest.mark.parametrize("name", [pytest.param(name, marks=_MARKS.get(name, ())) for name in formats.names()])
def test_whatever_a_reader_assumes_is_an_entry(tmp_path, name):
    assert name in SAMPLES, "a new format needs a sample in files/: see test_other_files.py"
    loaded = load_trace(SAMPLES[name](tmp_path if name in _OWN_NAMES else tmp_path / "a.csv"), _OPTIONS.get(name))
    assert loaded.format == name
    entries = {assumption.what: assumption for assumption in loaded.assumptions}
    known = {"columns", "orientation", "pose", "length", "axes", "up", "clock"}
    if any(defect.kind == "no-position" for defect in loaded.defects):
        known.remove("length")
    assert set(entries) == known
    assert all(assumption.value and assumption.by in By for assumption in loaded.assumptions)
    for stated in formats.get(name).assumes():
        found = entries.get(stated.what)
        if stated.by is By.FORMAT and found is not None:
            assert found.by in (By.FORMAT, By.FILE), f"{found} is stated by the format"
            assert found.by is By.FILE or np.isin(stated.value.split()[0], found.value.split())
        if found is not None and found.by is By.FORMAT:
            assert stated.by in (By.FORMAT, By.FILE), f"{found}, but the format says nothing of it"


def test_the_page_has_what_each_format_assumes():
    """`make docs OPTIONS=trace-formats` writes the table."""
    page = (Path(__file__).parents[2] / "docs" / "traces.md").read_text(encoding="utf-8")
    listed = assumed_list("formats")
    assert "; assumed: " in listed and listed in page, "'make docs OPTIONS=trace-formats' writes it"
