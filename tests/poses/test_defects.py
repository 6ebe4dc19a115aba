"""The fifteen kinds of defect that occur in real head-motion files.

Each survived or refused, never in silence.
"""

from __future__ import annotations

import gzip
import os

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.errors import InputError, UnknownNameError
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
    assert found(loaded, "midnight").count == 1
    assert np.array_equal(loaded.track.time_ns, TRACK.time_ns // 1_000_000 * 1_000_000)
    assert loaded.time_unit == "hours:minutes:seconds"


def decimal_commas(table):
    return [[f.replace(".", ",") for f in r] for r in table]


def test_4_ticks_that_differ_below_float64_stay_apart(tmp_path):
    base = 638_000_000_000_000_000
    assert float(base) == float(base + 30)
    table = [[str(base + 30 * i), *r[1:]] for i, r in enumerate(TABLE)]
    loaded = load_trace(write(tmp_path / "t.csv", table, "timestamp,x,y,z,qx,qy,qz,qw"))
    assert loaded.format == "ticks"
    assert loaded.track.time_ns.tolist() == [3000 * i for i in range(200)]


@pytest.mark.parametrize("name", ["walk", "look-around"])
def test_5_the_other_order_is_refused_where_the_motion_shows_it(tmp_path, name):
    track = load_trace(name).track
    path = write(tmp_path / "first.txt", rows(track, "wxyz"), header="", separator=" ")
    assert "with w first they do: say --quat-order wxyz" in refusal(path)
    assert same_motion(load_trace(path, TraceOptions(quat_order="wxyz")).track, track)


def test_9_repeated_poses_are_kept_for_replay_and_left_out_of_speeds(tmp_path):
    table = [[r[0], *TABLE[i // 6 * 6][1:]] for i, r in enumerate(TABLE)]
    loaded = load_trace(write(tmp_path / "r.csv", table))
    assert len(loaded.track) == 200
    defect = found(loaded, "repeated-pose")
    assert defect.count == 200 - 34
    assert "83 %" in defect.what
    repeated, clean = analyse(loaded.track), analyse(TRACK)
    assert repeated.repeated_share == pytest.approx(0.83)
    # Steps of 100 ms flatten this motion's speed by a few per cent; differentiating the steps would
    # give a median of 0.
    assert repeated.angular_speed_deg_s[0] == pytest.approx(clean.angular_speed_deg_s[0], rel=0.1)


def scaled(length: float, at: int = 60):
    table = [list(r) for r in TABLE]
    table[at][4:] = [repr(length * float(f)) for f in table[at][4:]]
    return table


def test_12_steps_of_30_us_do_no_harm(tmp_path):
    extra = [repr(float(TABLE[40][0]) + 30e-6), *TABLE[41][1:]]
    loaded = load_trace(write(tmp_path / "s.csv", [*TABLE[:41], extra, *TABLE[41:]]))
    assert "short-step" in kinds(loaded)
    assert max(analyse(loaded.track).angular_speed_deg_s) < 300  # over one such step it would be 60,000


def test_12_gaps_are_reported_and_never_crossed(tmp_path):
    table = [*TABLE[:50], *([repr(float(r[0]) + 2.9), *r[1:]] for r in TABLE[50:])]
    loaded = load_trace(write(tmp_path / "g.csv", table))
    assert "2.917 s" in found(loaded, "gap").what
    assert found(loaded, "gap").line == 52
    middle = loaded.track.at(int(loaded.track.time_ns[49]) + 1_000_000_000)
    assert middle.origin is Origin.HELD
    assert middle.pose.isclose(TRACK.pose(49), atol=1e-15)


def test_13_teleports_are_reported_and_never_crossed(tmp_path):
    table = [*TABLE[:50], *([r[0], repr(float(r[1]) + 8), *r[2:]] for r in TABLE[50:])]
    loaded = load_trace(write(tmp_path / "t.csv", table))
    assert (found(loaded, "jump").count, found(loaded, "jump").line) == (1, 52)
    assert loaded.track.jumps == (49,)
    half = (int(loaded.track.time_ns[49]) + int(loaded.track.time_ns[50])) // 2
    assert loaded.track.at(half).origin is Origin.HELD
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
        (
            [[r[0], r[5]] for r in TABLE],
            "time,yaw",
            {"euler": "YXZ,deg"},
            "takes three angles, called pitch, yaw and roll",
        ),
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
        assert "42 of 200 rows hold no pose" in refusal(path)


def test_15_the_share_that_may_be_lost_is_stated(tmp_path):
    table = [[r[0], *("" for _ in r[1:])] if i % 10 < 3 else r for i, r in enumerate(TABLE)]
    path = write(tmp_path / "n.csv", table)
    assert "--lost-rows 0.3 reads the others" in refusal(path)
    assert len(load_trace(path, TraceOptions(lost_rows=0.3)).track) == round(0.7 * len(TABLE))


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "is empty"), (b" \n\n \n", "is empty"), (b"time,x,y,z,qx,qy,qz,qw\n", "only a header"),
        (b"# nothing\n# here\n", "only comments"), (b"time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", "1 usable row"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "is no text"), (b"\x00" * 1000, "is no text"),
        (b"\x1f\x8b\x08\x00 gzip", "damaged"), (gzip.compress(repr(TABLE).encode())[:400], "damaged"),
        (gzip.compress(b"t,x,y,z,qx,qy,qz,qw\n" + b"1,0,0,0,0,0,0,1\n" * 20_000)[:-9], "damaged"),
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
    write(tmp_path / "inside.csv", TABLE)
    assert "is a directory" in refusal(tmp_path)
    assert "inside.csv" in refusal(tmp_path)
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
        *({"up": up} for up in ("", "w", "x,y", "up", "x,x,y", "0,0,0", "nan,1,0", "1,2", "1,2,3,4", "inf,0,1")),
        *({"scale": scale} for scale in (0.0, float("nan"))),
        *({"rate": rate} for rate in (-1.0, float("inf"))),
        *({"quat_order": "wzyx"}, {"segment": 0}, {"lost_rows": 1.0}),
    ],
)
def test_options_that_cannot_be_are_refused(wrong):
    with pytest.raises(InputError):
        load_trace("walk", TraceOptions(**wrong))
