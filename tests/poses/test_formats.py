"""Trace formats.

A contract over all of them, what is written comes back bit for bit, and axes come out as OpenXR's.
"""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp.errors import MachineError, TraceError
from hmdwarp.poses import PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.formats import formats
from hmdwarp.poses.reading.axes import parse_up

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
    assert back.format == name and back.track.origin == ("a test" if name in ("mcap", "native") else "")
    # The clock of a log begins at 0 or later.
    late = max(0, -track.start_ns) if name == "mcap" else 0
    assert np.array_equal(back.track.time_ns + back.track.epoch_ns, track.time_ns + late)
    assert np.array_equal(back.track.position_m, track.position_m)
    assert np.array_equal(back.track.orientation_xyzw, track.orientation_xyzw)


@pytest.mark.parametrize("name", WRITERS)
def test_written_twice_is_the_same_file(tmp_path, name):
    first = save(TRACK, tmp_path / "first", name)
    again = save(load_trace(first).track.evolve(origin="", notes=()), tmp_path / "again", name)
    assert again.read_bytes() == first.read_bytes()


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


def test_stamps_too_large_for_a_file_are_written_from_zero():
    stream = io.StringIO()
    formats.get("euroc").write(TRACK.evolve(epoch_ns=638 * 10**17), stream)
    assert stream.getvalue().splitlines()[2].startswith("0,")


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


@pytest.mark.parametrize(
    ("text", "up"), [("y", 1), ("-y", -1), ("z", 2), ("-z", -2), ("x", 0), ("-y,z,x", 2), ("x,z,y", 2)]
)
def test_the_named_axis_becomes_up(text, up):
    vector = np.zeros(3)
    vector[abs(up)] = -1.0 if text.startswith("-") and "," not in text else 1.0
    assert np.array_equal(parse_up(text).world @ vector, [0, 1, 0])


@pytest.mark.parametrize(
    ("text", "turn", "place", "turned"),
    [
        ("z", (0, 0, 1), (1, 3, -2), (0, 1, 0)),
        # Unity: x right, y up, z forward; a positive turn about y is to the right.
        ("x,y,z", (0, 1, 0), (1, 2, -3), (0, -1, 0)),
    ],
)
def test_a_quarter_turn_and_another_hand_in_numbers(text, turn, place, turned):
    position, sine = np.array([[1.0, 2, 3]]), np.sin(0.2)
    orientation = np.array([[*np.multiply(turn, sine), np.cos(0.2)]])
    parse_up(text).apply(position, orientation)
    assert np.array_equal(position[0], place)
    assert np.array_equal(orientation[0], [*np.multiply(turned, sine), np.cos(0.2)])


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 0.01))
def test_three_numbers_set_that_direction_upright_by_the_smallest_turn(v):
    v = np.array(v) / np.linalg.norm(v)
    axes = parse_up(",".join(map(repr, v.tolist())))
    position, orientation = v[None].copy(), np.array([[0, 0, 0, 1.0]])
    axes.apply(position, orientation)
    # Within 1e-12 of its cosine, sqrt(2e-12) = 1.42e-6 rad, a direction is taken for straight down.
    taken = 1.42e-6 if v[1] <= -1 + 1e-12 else 0.0
    assert np.allclose(position, [[0, 1, 0]], rtol=0, atol=1e-7 + taken)
    turn = Rotation.from_quat(orientation[0]).magnitude()
    assert abs(turn - np.arccos(np.clip(v[1], -1, 1))) < 1e-6 + taken


def test_up_z_changes_nothing_where_the_format_has_z_up(tmp_path):
    table = [[r[0], "0", *r[4:]] for r in rows(upright_zup(), "wxyz")]
    path = write(tmp_path / "m.txt", table, "timestamp viewpoint w x y z", " ")
    plain, told = load_trace(path), load_trace(path, TraceOptions(up="z"))
    assert plain.format == "multiviewpoint"
    assert same_motion(plain.track, told.track, atol=0)
    assert same_motion(plain.track, load_trace(path, TraceOptions(up="-y,z,x")).track, atol=0)
    assert not same_motion(plain.track, load_trace(path, TraceOptions(up="y")).track, atol=0.1)


def test_a_stated_format_is_not_second_guessed(tmp_path):
    path = write(tmp_path / "tum.txt", rows(TRACK), header="", separator=" ")
    assert same_motion(load_trace(path, TraceOptions(format="tum")).track, TRACK)
    with pytest.raises(TraceError, match="no header"):
        load_trace(path, TraceOptions(format="native"))


def test_mcap_without_its_packages_names_the_line_to_type(tmp_path, monkeypatch):
    path = tmp_path / "a.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    monkeypatch.setitem(sys.modules, "mcap.reader", None)
    with pytest.raises(MachineError, match=r"this needs mcap, which is not installed: pip install '\.\[mcap\]'"):
        load_trace(path)
