"""Defects, columns, devices, angles and clocks of real files: read or refused, never in silence."""

from __future__ import annotations

import datetime
import os

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError, UnknownNameError
from hmdwarp.poses import Origin, TraceOptions, analyse, load_trace, predict

from .traces import found, head, kinds, refusal, rows, same_motion, write

TRACK = head(200)
TABLE = rows(TRACK)


@pytest.mark.parametrize(("segment", "taken"), [(None, 2), (1, 1), (2, 2), (3, 3)])
def test_1_several_recordings_are_split_where_time_falls(tmp_path, segment, taken):
    table = TABLE[:50] + TABLE[:120] + TABLE[10:40]
    loaded = load_trace(write(tmp_path / "three.csv", table), TraceOptions(segment=segment))
    wanted = {1: (0, 50), 2: (0, 120), 3: (10, 40)}[taken]
    part = slice(*wanted)
    assert np.array_equal(loaded.track.time_ns, TRACK.time_ns[part] - TRACK.time_ns[part][0])
    assert np.array_equal(loaded.track.position_m, TRACK.position_m[part])
    assert [s.taken for s in loaded.segments] == [i == taken for i in (1, 2, 3)]
    assert [(s.first_line, s.last_line) for s in loaded.segments] == [(2, 51), (52, 171), (172, 201)]
    defect = found(loaded, "clock-restart")
    assert (defect.count, defect.line) == (2, 52)
    assert "3 recordings" in defect.what
    assert f"segment {taken} taken" in defect.done


def test_1_midnight_is_no_new_recording(tmp_path):
    def clock(ns):
        ms = (ns // 1_000_000 + 86_399_000) % 86_400_000
        return f"{ms // 3_600_000:02d}:{ms // 60_000 % 60:02d}:{ms // 1000 % 60:02d}.{ms % 1000:03d}"

    loaded = load_trace(write(tmp_path / "night.csv", rows(TRACK, stamp=clock)))
    assert len(loaded.segments) == 1
    assert found(loaded, "clock-changes").count == 1
    assert np.array_equal(loaded.track.time_ns, TRACK.time_ns // 1_000_000 * 1_000_000)
    assert loaded.time_unit == "hours:minutes:seconds"


@pytest.mark.parametrize(("half", "hours"), [("AM", 0), ("PM", 12)])
def test_twelve_is_midnight_or_noon(tmp_path, half, hours):
    table = [[f"12:{i // 60:02d}:{i % 60:02d} {half}", *r[1:]] for i, r in enumerate(TABLE)]
    assert load_trace(write(tmp_path / "h.csv", table)).track.epoch_ns == hours * 3600 * 10**9


def decimal_commas(table):
    return [[f.replace(".", ",") for f in r] for r in table]


def test_4_ticks_that_differ_below_float64_stay_apart(tmp_path):
    base = 638_000_000_000_000_000
    assert float(base) == float(base + 30)
    table = [[str(base + 30 * i), *r[1:]] for i, r in enumerate(TABLE)]
    loaded = load_trace(write(tmp_path / "t.csv", table, "timestamp,x,y,z,qx,qy,qz,qw"))
    assert "ticks of 100 ns" in found(loaded, "unit-guessed").done
    assert loaded.track.time_ns.tolist() == [3000 * i for i in range(200)]


def test_9_repeated_poses_are_kept_for_replay_and_left_out_of_speeds(tmp_path):
    table = [[r[0], *TABLE[i // 6 * 6][1:]] for i, r in enumerate(TABLE)]
    loaded = load_trace(write(tmp_path / "r.csv", table))
    assert len(loaded.track) == 200
    defect = found(loaded, "repeated-pose")
    assert defect.count == 200 - 34
    assert "83 %" in defect.what
    repeated, clean = analyse(loaded.track), analyse(TRACK)
    assert repeated["repeated_share"] == pytest.approx(0.83)
    # Steps of 100 ms flatten this motion's speed by a few per cent; differentiating the steps would
    # give a median of 0.
    assert repeated["angular_speed_deg_s"]["p50"] == pytest.approx(clean["angular_speed_deg_s"]["p50"], rel=0.1)


def scaled(length: float, at: int = 60):
    table = [list(r) for r in TABLE]
    table[at][4:] = [repr(length * float(f)) for f in table[at][4:]]
    return table


def test_12_steps_of_30_us_do_no_harm(tmp_path):
    extra = [repr(float(TABLE[40][0]) + 30e-6), *TABLE[41][1:]]
    loaded = load_trace(write(tmp_path / "s.csv", [*TABLE[:41], extra, *TABLE[41:]]))
    assert "short-step" in kinds(loaded)
    assert max(analyse(loaded.track)["angular_speed_deg_s"].values()) < 300  # over one such step it would be 60,000


@pytest.mark.parametrize(("kind", "shift"), [("gap", (2.9, 0)), ("jump", (0, 8))])
def test_13_gaps_and_teleports_are_reported_and_never_crossed(tmp_path, kind, shift):
    later = [[repr(float(r[0]) + shift[0]), repr(float(r[1]) + shift[1]), *r[2:]] for r in TABLE[50:]]
    loaded = load_trace(write(tmp_path / "t.csv", [*TABLE[:50], *later]))
    assert (found(loaded, kind).count, found(loaded, kind).line) == (1, 52)
    assert loaded.track.jumps == ((49,) if kind == "jump" else ())
    between = loaded.track.at(sum(loaded.track.time_ns[49:51].tolist()) // 2)
    assert between.origin is Origin.HELD and between.pose.isclose(TRACK.pose(49), atol=1e-15)
    now = int(loaded.track.time_ns[51])
    assert abs(predict(loaded.track, now, now + 100_000_000).pose.position_m[0] - loaded.track.position_m[51, 0]) < 0.1


def test_13_tilted_gravity_is_reported_and_set_upright_on_request(tmp_path):
    track = head(2000)
    tilt = Rotation.from_euler("X", 17, degrees=True)
    turned = track.evolve(
        position_m=tilt.apply(track.position_m.copy()),
        orientation_xyzw=(tilt * Rotation.from_quat(track.orientation_xyzw)).as_quat(),
    )
    path = write(tmp_path / "g.csv", rows(turned))
    loaded = load_trace(path)
    defect = found(loaded, "tilt")
    assert "assumed; up is tilted by 1" in loaded.axes  # what keeps no defects has it too
    # The head rolls by up to 6 degrees, which an average over a few turns leaves a third of.
    assert abs(float(defect.what.split(" degrees")[0].split()[-1]) - 17) <= 2
    up = defect.done.split("--up=")[1].split(" ")[0]
    assert "tilt" not in kinds(load_trace(path, TraceOptions(up=up)))
    exact = ",".join(map(repr, tilt.apply([0, 1, 0]).tolist()))
    assert same_motion(load_trace(path, TraceOptions(up=exact)).track, track, atol=1e-14)


HEADER = "time,x,y,z,qx,qy,qz,qw"
WXYZ = rows(TRACK, "wxyz")
SEVEN = [r[:7] for r in TABLE]
UNTIMED, STOPPED = [r[1:] for r in TABLE], [["7", *r[1:]] for r in TABLE]
EULER = ("yaw,pitch,roll", "RotationX,RotationY,RotationZ", "EulerX,EulerY,EulerZ")
NO_ANGLES = "ZXY", "ZZY,deg", "xyz,turns", "", "xy,deg"
NO_COLUMNS = "t=1,p=2+3+4", "q=5+6+7", "u=1,q=5+6+7+8", ""
ORDER = np.random.default_rng(1).permutation(len(TABLE))


@pytest.mark.parametrize(
    ("table", "header", "option", "stated"),
    [
        (TABLE, "", "--quat-order", {"quat_order": "xyzw"}),
        (WXYZ, "", "--quat-order", {"quat_order": "wxyz"}),
        (WXYZ, "time,x,y,z,q0,q1,q2,q3", "--quat-order", {"quat_order": "wxyz"}),
        (UNTIMED, HEADER.removeprefix("time,"), "--trace-rate", {"rate": 60}),
        (STOPPED, HEADER, "--trace-rate", {"rate": 60}),
    ],
)
def test_14_what_a_file_leaves_open_is_refused_until_it_is_stated(tmp_path, table, header, option, stated):
    path = write(tmp_path / "open.csv", table, header)
    assert option in refusal(path)
    loaded = load_trace(path, TraceOptions(**stated))
    assert same_motion(loaded.track, TRACK) and ("clock-by-rate" in kinds(loaded)) == ("rate" in stated)


@pytest.mark.parametrize(
    ("table", "header", "stated", "said"),
    [
        (TABLE[:50] + TABLE[:120], HEADER, {"segment": 3}, "holds 2 recordings: there is no segment 3"),
        (decimal_commas(TABLE[1:]), HEADER, {}, "line 2: 16 fields where the header names 8"),
        (decimal_commas(TABLE[1:]), HEADER, {}, "decimal commas inside a comma-separated file"),
        ([[*r[:4], "0", "0", "0", "0"] for r in TABLE], HEADER, {}, "every quaternion is zero"),
        *((scaled(length), HEADER, {}, "line 62: a quaternion of length") for length in (0.49, 0.001, 3.0, 1e6)),
        *((SEVEN, f"time,x,y,z,{names}", {}, "Euler angles only") for names in EULER),
        ([[r[0], r[5]] for r in TABLE], "time,yaw", {"euler": "YXZ,deg"}, "has no head orientation"),
        ([[*r[:4], "1", *r[1:4]] for r in TABLE], "time,x,y,z,angle,axis_x,axis_y,axis_z", {}, "no head orientation"),
        (SEVEN, "", {}, "say --columns t=1,p=2+3+4,e=5+6+7 with their numbers (e: angles, with --euler)"),
        ([r[:6] for r in TABLE], "", {}, "--columns t=1"),
        ([TABLE[i] for i in ORDER], HEADER, {}, "they are shuffled"),
        ([[r[0], *"123456789123"] for r in TABLE], "", {"format": "matrices"}, "no rotations"),
        ([[*r[:4], *(repr(1.4 * float(f)) for f in r[4:])] for r in TABLE], HEADER, {}, "longer than 1.4, expected 1"),
        *((SEVEN, "time,x,y,z,yaw,pitch,roll", {"euler": text}, "such as ZXY,deg") for text in NO_ANGLES),
        *((TABLE, HEADER, {"columns": text}, "expected t=TIME") for text in NO_COLUMNS),
        *((TABLE, HEADER, {"columns": f"t={t},q=5+6+7+8"}, f"no column '{t}'") for t in ("0", "9", "when")),
    ],
)
def test_14_what_is_never_guessed_is_refused(tmp_path, table, header, stated, said):
    assert said in refusal(write(tmp_path / "refused.csv", table, header), **stated)


@pytest.mark.parametrize(("unit", "scale"), [("(cm)", 100), ("[mm]", 1000)])
def test_14_units_in_brackets_belong_to_a_header_and_scale_what_they_name(tmp_path, unit, scale):
    header = "Time (s)," + ",".join(f"HeadPos{a} {unit}" for a in "XYZ")
    rows = [[r[0], *(repr(scale * float(x)) for x in r[1:4]), *r[4:]] for r in TABLE]
    path = write(tmp_path / "u.csv", rows, header + ",qx (),qy (),qz (),qw ()")
    assert same_motion(load_trace(path).track, TRACK, atol=1e-12)
    angles = write(tmp_path / "e.csv", [r[:7] for r in rows], header + ",Pitch (deg),Yaw (deg),Roll (deg)")
    assert "Euler angles only (Pitch (deg)," in refusal(angles)


def test_14_a_rate_overrides_a_clock_and_says_so(tmp_path):
    loaded = load_trace(write(tmp_path / "n.csv", TABLE), TraceOptions(rate=30))
    assert loaded.track.rate_hz == pytest.approx(30)
    assert "put aside" in found(loaded, "clock-by-rate").what


def replaced(at: dict[int, list[str]]) -> list[list[str]]:
    return [at.get(i, row) for i, row in enumerate(TABLE)]


def test_what_may_be_a_default_pose_or_a_second_device_is_not_dropped(tmp_path):
    rests = load_trace(write(tmp_path / "r.csv", replaced({i: [TABLE[i][0], *TABLE[7][1:]] for i in range(7)})))
    assert len(rests.track) == 200 and "default-pose" not in kinds(rests)
    odd = [[str(i % 2), *TABLE[i // 2]] for i in range(199)]
    assert len(load_trace(write(tmp_path / "odd.csv", odd, f"ViewIndex,{HEADER}")).track) == 100
    named = load_trace(write(tmp_path / "n.csv", TABLE), TraceOptions(quat_order="wxyz"))
    assert same_motion(named.track, TRACK) and "quat-order-named" in kinds(named)


@pytest.mark.parametrize("value", ["nan", "NaN", "inf", "-inf", "", "x", "1e400", "1_0", "0x10"])
@pytest.mark.parametrize("column", [1, 5])
@pytest.mark.parametrize("row", [0, 60, 199])
def test_15_a_value_that_is_no_number_is_named_with_its_line(tmp_path, value, column, row):
    table = [list(r) for r in TABLE]
    table[row][column] = value
    path = write(tmp_path / "nan.csv", table)
    if row == 199 and "n" not in value.lower():
        assert "last-row-cut" in kinds(load_trace(path))
        return
    loaded = load_trace(path)
    assert len(loaded.track) == len(TRACK) - 1
    defect = found(loaded, "row-without-pose")
    assert (defect.count, defect.line) == (1, row + 2)
    assert ("x" if column == 1 else "qy") in defect.what


@pytest.mark.parametrize(("share", "reads"), [(0.19, True), (0.21, False)])
def test_15_rows_without_a_pose_are_dropped_up_to_a_fifth(tmp_path, share, reads):
    table = [[r[0], *("nan" for _ in r[1:])] if i < share * len(TABLE) else r for i, r in enumerate(TABLE)]
    path = write(tmp_path / "lost.csv", table)
    if reads:
        assert found(load_trace(path), "row-without-pose").count == round(share * len(TABLE))
    else:
        assert "42 of 200 rows hold no pose; --lost-rows 0.21 reads the others" in refusal(path)
        assert len(load_trace(path, TraceOptions(lost_rows=0.21)).track) == len(TABLE) - 42


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "is empty"), (b" \n\n \n", "is empty"), (b"time,x,y,z,qx,qy,qz,qw\n", "only a header"),
        (b"# nothing\n# here\n", "only comments"), (b"time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", "1 usable row"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "is no text"), (b"\x00" * 1000, "is no text"),
        (b"\x1f\x8b\x08\x00 gzip", "unpack it first, as gunzip does"),
        (b"PK\x03\x04 zip", "ZIP archive"), ("time,x\n".encode("utf-16"), "UTF-16"), (b"a" * 600_000, "longer than"),
        (b"hello world\n", "only a header"), (b"time,temperature\n1,20\n2,21\n", "no head orientation"),
        (b"1,2,3\n4,5,6\n", "no known trace format"),
    ],
)  # fmt: skip
def test_15_what_is_no_trace_is_refused_in_one_line(tmp_path, content, word):
    path = tmp_path / "what.csv"
    path.write_bytes(content)
    assert word in refusal(path)


def test_15_a_directory_a_missing_file_and_a_device(tmp_path):
    assert "is a directory" in refusal(tmp_path)
    assert "no such file" in refusal(tmp_path / "missing.csv")
    assert "recording is called 'walk'" in refusal(tmp_path / "walk.csv")
    os.mkfifo(tmp_path / "pipe.csv")
    assert "is a pipe" in refusal(tmp_path / "pipe.csv")


def test_15_an_unknown_recording_is_offered_the_nearest():
    assert "did you mean 'look-around'" in refusal("look-arround")
    with pytest.raises(UnknownNameError, match="trace format"):
        load_trace("walk", TraceOptions(format="tumm"))


@pytest.mark.parametrize(
    "wrong",
    [
        *({"up": up} for up in ("", "z", "x,y", "up", "x,x,y", "0,0,0", "nan,1,0", "1,2", "1,2,3,4", "inf,0,1")),
        *({"scale": scale} for scale in (0.0, float("nan"))),
        *({"rate": rate} for rate in (-1.0, float("inf"))),
        *({"quat_order": "wzyx"}, {"segment": 0}, {"lost_rows": 1.0}),
    ],
)
def test_options_that_cannot_be_are_refused(wrong):
    with pytest.raises(InputError):
        load_trace("walk", TraceOptions(**wrong))


@pytest.mark.parametrize("text", ["t=1,p=2+3+4,q=5+6+7+8", "q=a4+a5+a6+a7,t=a0,p=a1+a2+a3", "p=2+a2+4,q=5+6+7+8,t=1"])
def test_stated_columns_are_read_by_name_or_number(tmp_path, text):
    path = write(tmp_path / "c.csv", TABLE, ",".join(f"a{i}" for i in range(8)))
    loaded = load_trace(path, TraceOptions(columns=text))
    assert same_motion(loaded.track, TRACK) and loaded.format == "columns"


def of_devices(*names: str, zero: str = "") -> list[list[str]]:
    """Rows of several devices, the last of which holds the track; `zero` never tracked."""
    poses = {name: ["5", "5", "5", "1", "0", "0", "0"] for name in names} | {zero: ["0"] * 7}
    return [[name, r[0], *(r[1:] if name == names[-1] else poses[name])] for r in TABLE for name in names]


def test_a_device_name_of_any_length_is_one_of_its_own(tmp_path):
    long = "a tracker whose name is longer than most"
    table = [[f"{long} {i}", *r[:1], str(i), *r[2:]] for r in TABLE for i in (1, 2)]
    path = write(tmp_path / "d.csv", table, "device," + HEADER)
    for i in (1, 2):
        track = load_trace(path, TraceOptions(device=f"{long} {i}")).track
        assert len(track) == len(TABLE) and (track.position_m[:, 0] == i).all()


def test_the_stated_device_is_read(tmp_path):
    path = write(tmp_path / "d.csv", of_devices("head", "glasses"), "device," + HEADER)
    assert same_motion(load_trace(path, TraceOptions(device="glasses")).track, TRACK)
    assert "there are those of glasses, head" in refusal(path, device="hat")
    assert "leave --device out" in refusal(write(tmp_path / "n.csv", TABLE), device="head")


# angles and matrices


def test_rows_without_a_turn_among_matrices_are_dropped(tmp_path):
    turns = Rotation.from_quat(TRACK.orientation_xyzw).as_matrix()
    turns[20:23], turns[40] = 0.0, np.diag([1.0, 1.0, -1.0])
    rows_of = np.concatenate([turns, TRACK.position_m[:, :, None]], axis=2).reshape(-1, 12)
    table = [[r[0], *map(repr, numbers)] for r, numbers in zip(TABLE, rows_of.tolist(), strict=True)]
    loaded = load_trace(write(tmp_path / "m.txt", table, header="", separator=" "))
    defect = found(loaded, "zero-quaternion")
    assert defect.count == 4 and "matrix that is no rotation" in defect.what
    assert len(loaded.track) == len(TRACK) - 4


@pytest.mark.parametrize(("unit", "right"), [("deg", "rad"), ("rad", "deg")])
def test_angles_in_another_unit_are_reported(tmp_path, unit, right):
    turns = Rotation.from_quat(TRACK.orientation_xyzw).as_euler("zxy", degrees=right == "deg")
    table = [[*r[:4], *map(repr, (x, y, z))] for r, (z, x, y) in zip(TABLE, turns.tolist(), strict=True)]
    path = write(tmp_path / "e.csv", table, "time,x,y,z,rot_x,rot_y,rot_z")
    loaded = load_trace(path, TraceOptions(euler=f"ZXY,{unit}"))
    assert any(f"--euler ZXY,{right}" in d.done for d in loaded.defects if d.kind == "angles-implausible")
    assert "angles-implausible" not in kinds(load_trace(path, TraceOptions(euler=f"ZXY,{right}")))


POSE = "x,y,z,qx,qy,qz,qw"
BILLION = 10**9
TRACK_CLOCKS = head(360, 90)
TABLE_CLOCKS = rows(TRACK_CLOCKS)


def date(ns: int, form: str, hours: int = 0) -> str:
    """An instant by the standard library, on a clock so many hours east; %f has its nanoseconds."""
    zone = datetime.timezone(datetime.timedelta(hours=hours))
    text = datetime.datetime.fromtimestamp(ns // BILLION, zone).strftime(form.replace("%f", "@"))
    return text.replace("@", f"{ns % BILLION:09d}")


def unpadded(ns: int) -> str:
    at = datetime.datetime.fromtimestamp(ns // BILLION, datetime.UTC)
    return f"{at.hour}:{at.minute}:{at.second}.{ns % BILLION // 10**6}"


def back(ns: int, is_winter: bool) -> str:
    return date(ns, f"%Y-%m-%d %H:%M:%S.%f+0{2 - is_winter}00", 2 - is_winter)


# What each writes of an instant (ns since 1970), and whether it is late in the file; under which
# names, how exactly, and what is said of it.
COUNTS, CHANGES = "fraction-unpadded", "clock-changes"
WRITERS = {
    "offset": ("time", lambda ns, late: [date(ns, "%Y-%m-%dT%H:%M:%S.%f+02:00", 2)], 1, ""),
    "summer's end": ("time", lambda ns, late: [back(ns, late)], 1, ""),
    "AM and PM": ("time", lambda ns, late: [date(ns, "%d.%m.%Y %I:%M:%S.%f %p -05:00", -5)], 1, ""),
    **{
        form: ("time", lambda ns, late, form=form: [date(ns, form)], 1, "")
        for form in ("%d.%m.%Y %H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p", "%Y/%m/%d %H:%M:%S.%f", "%H:%M:%S:%f")
    },
    "ROS 2": ("header.stamp.sec,header.stamp.nanosec", lambda ns, late: [str(ns // BILLION), str(ns % BILLION)], 1, ""),
    "Z": ("time", lambda ns, late: [date(ns, "%Y-%m-%dT%H:%M:%S.%f")[:-6] + "Z"], 10**6, ""),
    "s.ns": ("time", lambda ns, late: [f"{ns // BILLION}.{ns % BILLION}"], 1, COUNTS),
    "s.us": ("t_s", lambda ns, late: [f"{ns // BILLION}.{ns % BILLION // 1000}"], 1000, COUNTS),
    "h:m:s.ms": ("clock", lambda ns, late: [unpadded(ns)], 10**6, COUNTS),
    "s, ns": ("sec,nsec", lambda ns, late: [str(ns // BILLION), str(ns % BILLION)], 1, ""),
    "s, us": ("tv_sec,tv_usec", lambda ns, late: [str(ns // BILLION), str(ns % BILLION // 1000)], 1000, ""),
    "s, ms": ("time_s,time_ms", lambda ns, late: [str(ns // BILLION), str(ns % BILLION // 10**6)], 10**6, ""),
    "whole clocks": ("time_s,time_us", lambda ns, late: [str(ns // BILLION), str(ns // 1000)], 1000, ""),
    "to Unix": ("t_ms", lambda ns, late: [f"{(ns if late else ns % 10**14) / 1e6:.6f}"], 300_000, CHANGES),
    "since boot": ("time_ns", lambda ns, late: [str(ns % 10**14 if late else ns)], 1, CHANGES),
}


@pytest.mark.parametrize("writer", WRITERS)
@settings(max_examples=12)
@given(st.data())
def test_a_clock_is_read_as_its_writer_meant(tmp_path_factory, writer, data):
    """Rows that were lost stay lost; where the clock changes, its step is the usual one."""
    names, fields, exact_ns, said = WRITERS[writer]
    rate = data.draw(st.sampled_from([36, 60, 72, 90, 120]), "rate")
    begins_ns = data.draw(st.integers(10**4, 2 * 10**4), "begins") * 10**14 + data.draw(st.integers(0, 9 * 10**13))
    if writer.startswith("%m"):  # up to the 12th such a date may as well begin with its day
        assume(datetime.datetime.fromtimestamp(begins_ns // BILLION, datetime.UTC).day > 12)
    assume(begins_ns % (86_400 * BILLION) < 86_390 * BILLION)  # midnight is a change of some clocks
    track, count = head(4 * rate, rate), 4 * rate
    lost = set() if said == CHANGES else data.draw(st.sets(st.integers(2, count - 3), max_size=5), "lost")
    kept, table = [i for i in range(count) if i not in lost], rows(track)
    lines = [[*fields(begins_ns + int(track.time_ns[i]), 2 * i > count), *table[i][1:]] for i in kept]
    loaded = load_trace(write(tmp_path_factory.mktemp("clock") / "c.csv", lines, f"{names},{POSE}"))
    assert len(loaded.segments) == 1 and len(loaded.track) == len(kept)
    assert np.abs(loaded.track.time_ns - track.time_ns[kept]).max() <= exact_ns + (said == CHANGES)
    assert kinds(loaded) & {COUNTS, CHANGES, "clock-coarse", "clock-restart"} == {said} - {""}
    if writer not in ("%H:%M:%S:%f", "h:m:s.ms", "to Unix"):
        assert abs(loaded.track.epoch_ns - begins_ns) <= exact_ns


@pytest.mark.parametrize("tick_ns", [10_000_000, 15_625_000, 1_000_000_000])
@pytest.mark.parametrize("rate", [72, 90, 250])
@pytest.mark.parametrize("up_ns", [0, 0.5])
def test_a_coarse_clock_is_told_and_evened_out(tmp_path, tick_ns, rate, up_ns):
    """Stamps at the last or the nearest tick, printed in whole ms: the head moves as it did."""
    track = head(5 * rate, rate)
    ticks = (track.time_ns + int(up_ns * tick_ns)) // tick_ns
    table = [[f"{int(k) * tick_ns // 10**6 / 1000:.3f}", *r[1:]] for k, r in zip(ticks, rows(track), strict=True)]
    loaded = load_trace(write(tmp_path / "coarse.csv", table, f"time_s,{POSE}"))
    told = found(loaded, "clock-coarse").what
    assert abs(float(told.split("ticks of ")[1].split()[0]) - tick_ns / 1e6) < 0.1
    # A row's step at either end of a tick, over the ticks of the whole, and half a printed ms.
    near_ns = BILLION / rate + 0.02 * tick_ns
    assert np.abs(loaded.track.time_ns - track.time_ns).max() < near_ns
    assert abs(loaded.track.epoch_ns - int(up_ns * tick_ns)) < near_ns  # a tick is taken for its beginning


@pytest.mark.parametrize("stated", [{}, {"time_column": "1"}, {"time_unit": "frames"}])
@pytest.mark.parametrize("name", ["frame", "Frame Number", "frame_id", "seq"])
def test_frame_numbers_are_a_clock(tmp_path, name, stated):
    table = [[str(1200 + i), *r[1:]] for i, r in enumerate(TABLE_CLOCKS) if not 100 < i < 160]
    path = write(tmp_path / "frames.csv", table, f"{name},{POSE}")
    assert "--trace-rate" in refusal(path) and "numbers no frames" in refusal(path, time_column="x", rate=90)
    track = load_trace(path, TraceOptions(rate=90, **stated)).track
    kept = np.r_[:101, 160:360]
    assert (
        np.abs(track.time_ns - TRACK_CLOCKS.time_ns[kept]).max() <= 1 and track.at(1_300_000_000).origin is Origin.HELD
    )
    write(path, [[str(10**15 + i), *r[1:]] for i, r in enumerate(TABLE_CLOCKS)], f"{name},{POSE}")
    assert "is over 146 years from frame 0" in refusal(path, rate=90, **stated)


@pytest.mark.parametrize("lost", [np.r_[100:145], np.r_[50:53, 200:230], np.r_[330:360]])
@pytest.mark.parametrize("pose", ["0,0,0,0,0,0,1", "0,0,0,0,0,0,-1", "0,0,0,0.5,0.5,0.5,0.5"])
def test_default_poses_in_the_middle_are_a_gap(tmp_path, lost, pose):
    table = [[r[0], *(pose.split(",") if i in lost else r[1:])] for i, r in enumerate(TABLE_CLOCKS)]
    loaded = load_trace(write(tmp_path / "lost.csv", table, f"time_s,{POSE}"))
    told, kept = found(loaded, "default-pose"), np.setdiff1d(np.arange(360), lost)
    assert (told.count, told.line) == (len(lost), lost[0] + 2) and "jump" not in kinds(loaded)
    assert np.array_equal(loaded.track.position_m, TRACK_CLOCKS.position_m[kept])


@pytest.mark.parametrize(
    ("stamp", "name", "said"),
    [
        (lambda i: str(11_111 * i), "time_s", "9e-05 Hz, which no recording has: --time-unit us makes 90 Hz"),
        (lambda i: str(11 * i), "time_ns", "--time-unit ms makes 90.91 Hz"),
        (lambda i: str(11 * i if i < 90 else 11_111 * i), "time_ms", "changes its unit in line 92"),
    ],
)
def test_an_impossible_clock_is_refused_with_what_helps(tmp_path, stamp, name, said):
    table = [[stamp(i), *r[1:]] for i, r in enumerate(TABLE_CLOCKS)]
    assert said in refusal(write(tmp_path / "c.csv", table, f"{name},{POSE}"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"camera": {"fx": 1, "fy": 2}, "name": "a"}', "object of poses: its keys are camera.fx, camera.fy, name"),
        *((text, "") for text in ("[1, 2, 3]", "{}", '{"poses": []}', "[{")),
    ],
)
def test_json_without_poses_is_refused(tmp_path, text, said):
    path = tmp_path / "poses.json"
    path.write_text(text)
    assert said in refusal(path)
