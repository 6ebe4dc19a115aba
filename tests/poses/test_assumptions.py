"""What a trace reader assumed is an entry of the loaded trace, with who says so."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from recorded_folders import taken, write_colmap
from regenerate import assumed_list
from ros_bags import HAS_ROSBAGS, write_ros1

from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.poses.assumptions import Assumption, By, assumption_rows, first_stated
from hmdwarp.poses.formats import formats

from . import test_other_files as files
from .test_trace_command import run
from .traces import WRITERS, head, matrices, rows, save, write

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


@pytest.mark.parametrize(
    ("who", "said"),
    [(By.DEFAULT, "default; set with --scale"), (By.FILE, "by the file"), (By.USER, "by the user")],
)
def test_an_assumption_says_who_says_it(who, said):
    one = Assumption("length", "1 m per unit", who, "--scale")
    assert str(one) == f"length: 1 m per unit ({said})"
    assert assumption_rows([one]) == [{"what": "length", "value": "1 m per unit", "by": who.value, "option": "--scale"}]


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


def _bids(folder: Path) -> Path:
    channels = [(f"q{part}", f"quat_{part}", "ORNT", "head", "n/a", "n/a") for part in "xyzw"]
    return files.bids(folder, channels, TRACK.orientation_xyzw)


def _table(header: str, order: str = "xyzw", *before: str) -> Callable[[Path], Path]:
    return lambda folder: write(folder / "a.csv", [[*before, *row] for row in rows(TRACK, order)], header)


def _text(text: str) -> Callable[[Path], Path]:
    def written(folder: Path) -> Path:
        path = folder / "a.txt"
        path.write_text(text)
        return path

    return written


_TIMED = "x,y,z,qx,qy,qz,qw"
_HEAD = ",".join([*(f"HeadPos{a}" for a in "XYZ"), *(f"HeadOrientation{a}" for a in "WXYZ")])
_ROS = ",".join([*(f"pose.position.{a}" for a in "xyz"), *(f"pose.orientation.{a}" for a in "xyzw")])
_EYES = "Position{0},Position{1},Position{2},Quaternion{0},Quaternion{1},Quaternion{2},QuaternionW".format(*"XYZ")
TURNED = [[row[0], "0", *row[4:]] for row in rows(TRACK, "wxyz")]
_HEADS = [frame[:8] for frame in files.iwer_frames(TRACK)]
SAMPLES: dict[str, Callable[[Path], Path]] = {
    "bids": _bids,
    "colmap": lambda folder: (write_colmap(folder, taken(3)), folder / "sparse/0/images.txt")[1],
    "euroc": lambda folder: save(TRACK, folder / "a.csv", "euroc"),
    "eyenavgs": _table(f"ViewIndex,FOV1,GazePosX,Timestamp,{_EYES}", "xyzw", "0", "1", "0"),
    "frame_wxyz": lambda folder: write(folder / "a.txt", TURNED, "", " "),
    "browser": _text(json.dumps({"session": "a", "delays_ms": [100], "heads": _HEADS})),
    "iwer": _text(json.dumps({"schema": [], "frames": files.iwer_frames(TRACK)})),
    "json": _text("\n".join(json.dumps(dict(zip(files.NAMES, map(float, r), strict=True))) for r in rows(TRACK))),
    "matrices": lambda folder: write(
        folder / "a.txt", files.fields(files.SECONDS[:100], matrices(TRACK).reshape(-1, 16)), ""
    ),
    "mcap": lambda folder: save(TRACK, folder / "a.mcap", "mcap"),
    "motive": lambda folder: files.lined(folder / "a.csv", files.motive()),
    "multiviewpoint": lambda folder: write(folder / "a.txt", TURNED, "timestamp viewpoint w x y z", " "),
    "named": _table(f"time,{_TIMED}"),
    "native": lambda folder: save(TRACK, folder / "a.csv", "native"),
    "qualisys": lambda folder: files.lined(folder / "a.tsv", files.qualisys()),
    "questset": _table(f"LeftTouchPosX,time,{_HEAD}", "wxyz", "0"),
    "rosbag": lambda folder: (write_ros1(folder, taken(3)), folder / "taken.bag")[1],
    "ros2_csv": lambda folder: write(
        folder / "a.csv",
        [["1", str(i * 10**7), *row[1:]] for i, row in enumerate(rows(TRACK))],
        f"header.stamp.sec,header.stamp.nanosec,{_ROS}",
    ),
    "ticks": lambda folder: write(
        folder / "a.csv", rows(TRACK, stamp=lambda ns: str(638 * 10**15 + ns // 100)), f"timestamp,{_TIMED}"
    ),
    "tum": lambda folder: save(TRACK, folder / "a.tum", "tum"),
    "unreal": lambda folder: files.lined(folder / "a.csv", files.unreal()),
    "vectors": _text(files.VECTORS["NumPy"]),
}
_MARKS = {param.values[0]: param.marks for param in WRITERS}
_MARKS["rosbag"] = (pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed"),)
_OPTIONS = {"colmap": TraceOptions(rate=90.0)}  # of files without a clock


@pytest.mark.parametrize("name", [pytest.param(name, marks=_MARKS.get(name, ())) for name in formats.names()])
def test_whatever_a_reader_assumes_is_an_entry(tmp_path, name):
    assert name in SAMPLES, f"a new format needs a sample file: add '{name}' to SAMPLES"
    loaded = load_trace(SAMPLES[name](tmp_path), _OPTIONS.get(name))
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
