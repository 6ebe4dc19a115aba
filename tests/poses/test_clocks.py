"""Clocks as other people's software writes them, against the instants that were written."""

from __future__ import annotations

import datetime
import json

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hmdwarp.poses import Origin, TraceOptions, load_trace

from .traces import found, head, kinds, refusal, rows, write

POSE = "x,y,z,qx,qy,qz,qw"
BILLION = 10**9
TRACK = head(360, 90)
TABLE = rows(TRACK)


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
    "date, time": ("date,time", lambda ns, late: [date(ns, "%Y-%m-%d"), date(ns, "%H:%M:%S.%f")], 1, ""),
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
    assert abs(float(told.split("ticks of ")[1].split()[0]) - tick_ns / 1e6) < 0.1 and " degrees" in told
    # A row's step at either end of a tick, over the ticks of the whole, and half a printed ms.
    assert np.abs(loaded.track.time_ns - track.time_ns).max() < BILLION / rate + 0.02 * tick_ns


def test_a_coarse_clock_that_no_even_rows_fit_is_told_with_what_it_costs(tmp_path):
    """A head at 61 degrees a second, half a tick off."""
    turning = TRACK.evolve(orientation_xyzw=[(0, np.sin(i / 180), 0, np.cos(i / 180)) for i in range(360)])
    late = np.cumsum(np.where(np.arange(360) % 90 == 40, 3, 1)) - 1  # a pause of two rows each second
    table = [[f"{k / 90 // 0.02 * 0.02:.2f}", *r[1:]] for k, r in zip(late.tolist(), rows(turning), strict=True)]
    loaded = load_trace(write(tmp_path / "uneven.csv", table, f"time_s,{POSE}"))
    told = found(loaded, "clock-coarse")
    assert "ticks of 20 ms" in told.what and told.done.startswith("kept")
    # 90 rows a second turn by 1/90 each: half a tick is 0.01 s.
    assert float(told.what.split("by ")[1].split()[0]) == pytest.approx(np.degrees(0.01), rel=0.1)


@pytest.mark.parametrize("stated", [{}, {"time_unit": "frames"}])
@pytest.mark.parametrize("name", ["frame", "Frame Number", "frame_id", "seq"])
def test_frame_numbers_are_a_clock(tmp_path, name, stated):
    table = [[str(1200 + i), *r[1:]] for i, r in enumerate(TABLE) if not 100 < i < 160]
    path = write(tmp_path / "frames.csv", table, f"{name},{POSE}")
    assert "--trace-rate" in refusal(path, **stated)
    track = load_trace(path, TraceOptions(rate=90, **stated)).track
    kept = np.r_[:101, 160:360]
    assert np.abs(track.time_ns - TRACK.time_ns[kept]).max() <= 1 and track.at(1_300_000_000).origin is Origin.HELD
    write(path, [[str(10**15 + i), *r[1:]] for i, r in enumerate(TABLE)], f"{name},{POSE}")
    assert "is over 146 years from frame 0" in refusal(path, rate=90, **stated)


@pytest.mark.parametrize("lost", [np.r_[100:145], np.r_[50:53, 200:230], np.r_[330:360]])
@pytest.mark.parametrize("pose", ["0,0,0,0,0,0,1", "0,0,0,0,0,0,-1", "0,0,0,0.5,0.5,0.5,0.5"])
def test_default_poses_in_the_middle_are_a_gap(tmp_path, lost, pose):
    table = [[r[0], *(pose.split(",") if i in lost else r[1:])] for i, r in enumerate(TABLE)]
    loaded = load_trace(write(tmp_path / "lost.csv", table, f"time_s,{POSE}"))
    told, kept = found(loaded, "default-pose"), np.setdiff1d(np.arange(360), lost)
    assert (told.count, told.line) == (len(lost), lost[0] + 2) and "jump" not in kinds(loaded)
    assert np.array_equal(loaded.track.position_m, TRACK.position_m[kept])


@pytest.mark.parametrize(
    ("stamp", "name", "said"),
    [
        (lambda i: str(11_111 * i), "time_s", "9e-05 Hz, which no recording has: --time-unit us makes 90 Hz"),
        (lambda i: str(11 * i), "time_ns", "--time-unit ms makes 90.91 Hz"),
        (lambda i: str(11 * i if i < 90 else 11_111 * i), "time_ms", "changes its unit in line 92"),
    ],
)
def test_an_impossible_clock_is_refused_with_what_helps(tmp_path, stamp, name, said):
    table = [[stamp(i), *r[1:]] for i, r in enumerate(TABLE)]
    assert said in refusal(write(tmp_path / "c.csv", table, f"{name},{POSE}"))


def test_an_object_without_poses_names_its_keys(tmp_path):
    path = tmp_path / "poses.json"
    path.write_text(json.dumps({"camera": {"fx": 1, "fy": 2}, "name": "a"}))
    assert "is JSON without a list or an object of poses: its keys are camera.fx, camera.fy, name" in refusal(path)
