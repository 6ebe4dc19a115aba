"""Trace formats: a contract over all; what a reader assumes is told; no layout is read wrong."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded_folders import taken, write_colmap
from regenerate import assumed_list
from ros_bags import HAS_ROSBAGS, write_ros1
from scipy.spatial.transform import Rotation

from hmdwarp.base import MachineError, TraceError
from hmdwarp.poses import PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.assumptions import By
from hmdwarp.poses.formats import formats
from hmdwarp.poses.reading.axes import Axes, parse_up

from . import layouts
from .test_other_files import FILES, GOLDEN, STATED
from .traces import WRITERS, head, kinds, rows, same_motion, save, unit_quaternions, write

TRACK = head(100)


@pytest.mark.parametrize("name", formats.names())
def test_every_format_says_what_it_is(name):
    entry = formats.get(name)
    assert entry.name == name
    assert 20 < len(entry.summary) < 100
    if not entry.writes:
        with pytest.raises(TraceError, match="read, not written"):
            entry.write(TRACK, io.StringIO())


@pytest.mark.parametrize("name", WRITERS)
@given(
    first=st.integers(-(2**60), 2**60),
    # A clock of under 0.01 Hz or over 1 MHz is refused.
    steps=st.lists(st.integers(1001, 99 * 10**9), min_size=1, max_size=5),
    quaternions=st.lists(unit_quaternions, min_size=6, max_size=6),
    places=st.lists(st.floats(-1e6, 1e6), min_size=18, max_size=18),
)
def test_written_traces_read_back_bit_for_bit(tmp_path_factory, name, first, steps, quaternions, places):
    times, n = first + np.cumsum([0, *steps]), len(steps) + 1
    # Not at the origin, and turned: default poses between jumps would be dropped, rightly.
    place = np.array([one or 3.5 for one in places]).reshape(6, 3)[:n]
    q = np.array(quaternions)[:n]
    q[abs(q[:, 3]) > 1 - 1e-6] = [0.5, 0.5, 0.5, 0.5]
    track = PoseTrack(times, place, q, origin="a test")
    back = load_trace(save(track, tmp_path_factory.mktemp("w") / "out.txt", name))
    assert back.format == name and back.track.origin == ("a test" if name == "native" else "")
    assert np.array_equal(back.track.time_ns + back.track.epoch_ns, track.time_ns)
    assert np.array_equal(back.track.position_m, track.position_m)
    assert np.array_equal(back.track.orientation_xyzw, track.orientation_xyzw)


def test_native_tells_origin_rate_and_what_was_done(tmp_path):
    stream = io.StringIO()
    formats.get("native").write(
        TRACK.evolve(origin="a test\nwith a line break", notes=("something was mended",)), stream
    )
    text = stream.getvalue()
    assert text.startswith("# hmdwarp head trace\n# origin: a test with a line break\n# rate: 60 Hz\n")
    assert "# something was mended\n" in text
    path = tmp_path / "n.csv"
    path.write_text(text)
    assert load_trace(path).track.origin == "a test with a line break"
    formats.get("native").write(head(70_000), stream)  # more than are written at a time
    assert len(re.findall(r"^\d", stream.getvalue(), re.M)) == 70_100


def test_frame_wxyz_is_found_by_its_shape_and_refused_where_the_motion_shows_w_last(tmp_path):
    angles = np.stack([np.linspace(0, 6, 100), np.full(100, 0.1), np.full(100, 0.05)], axis=1)
    about = TRACK.evolve(orientation_xyzw=Rotation.from_euler("YXZ", angles).as_quat())
    table = [[r[0], str(i // 2), *r[4:]] for i, r in enumerate(rows(upright_zup(about), "xyzw"))]
    path = write(tmp_path / "f.txt", table, header="", separator=" ")
    with pytest.raises(TraceError, match="--quat-order"):
        load_trace(path)
    loaded = load_trace(path, TraceOptions(quat_order="xyzw"))
    assert np.allclose(loaded.track.orientation_xyzw, about.orientation_xyzw, rtol=0, atol=1e-15)
    first = write(
        tmp_path / "w.txt", [[r[0], "0", *r[4:]] for r in rows(upright_zup(about), "wxyz")], header="", separator=" "
    )
    found = load_trace(first)
    assert (found.format, found.time_unit) == ("frame_wxyz", "seconds") and kinds(found) == {"no-position"}
    assert np.allclose(found.track.orientation_xyzw, about.orientation_xyzw, rtol=0, atol=1e-15)


def upright_zup(track: PoseTrack = TRACK) -> PoseTrack:
    """The track in axes with x forward, y left, z up, by rotation matrices (the reader goes by
    quaternion parts).
    """
    file_from_openxr = np.array([[0, 0, -1.0], [-1, 0, 0], [0, 1, 0]])
    matrices = file_from_openxr @ Rotation.from_quat(track.orientation_xyzw).as_matrix() @ file_from_openxr.T
    return track.evolve(orientation_xyzw=Rotation.from_matrix(matrices).as_quat())


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.01))
def test_three_numbers_set_that_direction_upright_by_the_smallest_turn(v):
    v = np.array(v) / np.linalg.norm(v)
    axes = Axes(np.eye(3), np.eye(3), tilt=parse_up(",".join(map(repr, v.tolist()))))
    position, orientation = v[None].copy(), np.array([[0, 0, 0, 1.0]])
    axes.apply(position, orientation)
    # Within 1e-12 of its cosine, sqrt(2e-12) = 1.42e-6 rad, a direction is taken for straight down.
    taken = 1.42e-6 if v[1] <= -1 + 1e-12 else 0.0
    assert np.allclose(position, [[0, 1, 0]], rtol=0, atol=1e-7 + taken)
    turn = Rotation.from_quat(orientation[0]).magnitude()
    assert abs(turn - np.arccos(np.clip(v[1], -1, 1))) < 1e-6 + taken


def test_a_stated_format_is_not_second_guessed(tmp_path):
    path = write(tmp_path / "tum.txt", rows(TRACK), header="", separator=" ")
    assert same_motion(load_trace(path, TraceOptions(format="tum")).track, TRACK)
    with pytest.raises(TraceError, match="no header"):
        load_trace(path, TraceOptions(format="native"))


def test_a_bag_without_its_package_names_the_line_to_type(tmp_path, monkeypatch):
    path = tmp_path / "a.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(MachineError, match=r"this needs rosbags, which is not installed: pip install '\.\[bags\]'"):
        load_trace(path)


def by(loaded) -> dict[str, By]:
    """Who says each fact."""
    return {assumption.what: assumption.by for assumption in loaded.assumptions}


def test_facts_that_the_user_states_are_the_users(tmp_path):
    path = write(tmp_path / "a.csv", rows(TRACK), "a,b,c,d,e,f,g,h")
    stated = TraceOptions(columns="t=a,p=b+c+d,q=e+f+g+h", axes="openxr", scale=1.0, time_unit="s")
    assert {what for what, who in by(load_trace(path, stated)).items() if who is not By.USER} == {"pose"}


def test_notes_name_what_nobody_says(tmp_path):
    notes = load_trace(write(tmp_path / "a.csv", rows(TRACK), "time,x,y,z,qx,qy,qz,qw")).notes
    assert any(
        "not stated in the files" in note and "length 1 m per unit (override with --scale)" in note for note in notes
    )
    assert sum(note.count("--axes") for note in notes) == 1
    assert load_trace("walk").notes == []


# One file of each format: written here, or the first of `files/` that was read as that.
SAMPLES: dict[str, Callable[[Path], Path]] = {
    "colmap": lambda folder: (write_colmap(folder, taken(3)), folder / "sparse/0/images.txt")[1],
    "rosbag": lambda folder: (write_ros1(folder, taken(3)), folder / "taken.bag")[1],
    **{form.name: partial(save, TRACK, name=form.name) for form in formats if form.writes},
}


for _name, _format in re.findall(r"^# (.+)\nformat: (.+)$", GOLDEN.read_text(encoding="utf-8"), re.M):
    if not STATED.get(_name, {}).keys() - {"count", "late_ns", "lost"}:
        SAMPLES.setdefault(_format, lambda _, name=_name: FILES / name)


_MARKS = {"rosbag": pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed")}
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


ROOT = Path(__file__).parents[2]


def test_no_layout_is_read_wrong_and_the_table_says_how_each_is_read(tmp_path):
    """`make docs OPTIONS=trace-layouts` writes the table."""
    assert len({layout.name for layout in layouts.LAYOUTS}) == len(layouts.LAYOUTS)
    truth = load_trace("walk").track
    outcomes = {layout.name: layouts.verdict(layout, truth, tmp_path) for layout in layouts.LAYOUTS}
    assert [name for name, (outcome, _) in outcomes.items() if outcome == layouts.WRONG] == []
    page = (ROOT / "docs" / "traces.md").read_text(encoding="utf-8")
    assert layouts.contradicted_text() in page
    for layout in layouts.LAYOUTS:
        assert layouts.line(layout, *outcomes[layout.name]) in page
