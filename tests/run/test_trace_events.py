"""Trace events of a run: a well-formed file whose times are those of the summary."""

from __future__ import annotations

import json
import statistics
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from replays import run

from hmdwarp.errors import InputError
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.poses import synthesise
from hmdwarp.poses.formats.native import write_native
from hmdwarp.run import LiveOptions, live

from .offscreen import OffscreenDisplay, closed_at, run_on

# ts and dur are microseconds with three decimals, sums of them floats: below a nanosecond.
SAME_US = 5e-4
ROWS = {"frames": 1, "server": 2, "client": 3, "display": 4}


@pytest.mark.parametrize("name", ["record", "trace_events"])
def test_the_recording_that_is_read_is_not_written_over(name, tmp_path):
    """Forced or not: it was emptied before it was read."""
    trace = tmp_path / "mine.csv"
    with trace.open("w") as stream:
        write_native(synthesise("look-around", seconds=0.5), stream)
    before = trace.read_bytes()
    with pytest.raises(InputError, match="is the input itself"):
        live(LiveOptions(source="offscreen", trace=str(trace), force=True, pictures=1, **{name: trace}))
    if name == "trace_events":
        with pytest.raises(InputError, match="is the input itself"):
            run(tmp_path / "out", trace=str(trace), trace_events=trace, force=True, seconds=0.1)
    assert trace.read_bytes() == before


def events_of(path: Path) -> list[dict[str, Any]]:
    """Read the file, and check what the format asks of it: names, nesting, ends of flows."""
    events = json.loads(path.read_text())
    lanes = defaultdict(list)
    for event in events:
        assert event["ph"] in "XstfMi"
        if event["ph"] != "M":
            assert {"name", "ts", "pid", "tid"} <= event.keys()
        if event["ph"] == "X":
            assert event["dur"] >= 0
            lanes[event["pid"], event["tid"]].append(event)
    for slices in lanes.values():
        _check_nesting(slices)
    names = {(event["pid"], event["tid"]) for event in events if event["name"] == "thread_name"}
    assert names == set(lanes)
    flows = defaultdict(list)
    for event in events:
        if event["ph"] in "stf":
            flows[event["id"]].append(event)
            slices = lanes[event["pid"], event["tid"]]  # an arrow hangs on the slice around it
            assert any(piece["ts"] - SAME_US <= event["ts"] <= piece["ts"] + piece["dur"] + SAME_US for piece in slices)
    for flow in flows.values():
        assert [event["ph"] for event in flow] == ["s", "t", "f"]
        assert len({(event["cat"], event["name"]) for event in flow}) == 1
    return events


def _check_nesting(slices: list[dict[str, Any]]) -> None:
    """Each slice of a lane begins no earlier than the one before, and is inside it or after it."""
    around: list[float] = []
    last = -1e18
    for piece in slices:
        start, end = piece["ts"], piece["ts"] + piece["dur"]
        assert start >= last
        last = start
        while around and around[-1] <= start + SAME_US:
            around.pop()
        assert not around or end <= around[-1] + SAME_US, piece
        around.append(end)


def slices(events: list[dict[str, Any]], row: str, name: str = "") -> list[dict[str, Any]]:
    found = [event for event in events if event["ph"] == "X" and event["pid"] == ROWS[row]]
    return [event for event in found if event["name"].startswith(name)]


CASES = {
    "latency alone": {},
    "sum of its parts": {
        "network": LinkOptions.of(
            {"response": "sum:render=8,encode=5,decode=4", "bandwidth": "50", "jitter": "uniform:20"}
        ),
        "scanout_ms": 5.0,
    },
    "measured codec": {"network": LinkOptions.of({"server_rate": 25.0}), "coding": Coding("h264")},
}


@pytest.mark.parametrize("case", CASES)
def test_a_replay_s_events_agree_with_its_summary(tmp_path, case):
    path = tmp_path / "events.json"
    result = run(tmp_path / "out", fill="interpolate", trace_events=path, **CASES[case])
    events, summary = events_of(path), result.summary
    shown = slices(events, "display", "refresh")
    assert len(shown) == summary["frames"]
    way = slices(events, "frames", "frame")
    assert len(way) == len({row["drawn_ns"] for row in result.rows})
    # The way of the last frames, as the report draws it.
    for one, drawn in zip(summary["link"]["timeline"], way[-12:], strict=True):
        assert drawn["args"]["frame"] == one["frame"]
        parts = {name: ms for name, ms in one["parts"].items() if ms}
        inside = [part for part in slices(events, "frames") if part["args"]["frame"] == one["frame"]][1:]
        assert {part["name"]: part["dur"] for part in inside} == pytest.approx(
            {name: ms * 1000 for name, ms in parts.items()}, abs=SAME_US
        )
        assert drawn["dur"] == pytest.approx(sum(parts.values()) * 1000, abs=SAME_US)
    # Each refresh shows a frame that is ready, as old as frames.csv says.
    ready = {piece["args"]["frame"]: piece["ts"] + piece["dur"] for piece in way}
    begun = {piece["args"]["frame"]: piece["ts"] for piece in way}
    ages = [row["age_ms"] for row in result.rows if row["eye"] == 0]
    for one, age_ms in zip(shown, ages, strict=True):
        frame = one["args"]["frame"]
        assert ready[frame] <= one["ts"] + SAME_US
        assert one["ts"] - begun[frame] == pytest.approx(age_ms * 1000, abs=SAME_US)
    # The passes, as measured: an eye's median is the summary's.
    eyes = [piece["dur"] for piece in slices(events, "client") if piece["name"].endswith("eye")]
    assert len(eyes) == 2 * len(shown)
    assert statistics.median(eyes) == pytest.approx(summary["time_ms"]["total"]["median"] * 1000, abs=1)
    assert bool(slices(events, "display", "scan-out")) == ("scanout_ms" in CASES[case])
    assert bool(slices(events, "client", "decode")) == ("coding" in CASES[case])


def test_a_file_in_the_way_and_a_run_that_fails_leave_what_was_there(tmp_path):
    path = tmp_path / "events.json"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        run(tmp_path / "out", trace_events=path)
    assert path.read_text() == "mine"


def test_a_live_run_s_events_hold_its_refreshes(monkeypatch, tmp_path):
    path, out = tmp_path / "events.json", tmp_path / "out"
    options = LiveOptions(scene="planes", latency_ms=30, out=out, trace_events=path)
    run_on(monkeypatch, OffscreenDisplay(events=closed_at(12)), options)
    summary = json.loads((out / "summary.json").read_text())
    events = events_of(path)
    assert len(slices(events, "display", "refresh")) == summary["frames"]
    submitted = [event for event in events if event["ph"] == "i"]
    assert len(submitted) == summary["frames"]
    assert slices(events, "server", "render")
