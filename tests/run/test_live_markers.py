"""Markers of a live run, as a recorder in another process receives them."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack

import numpy as np
import pytest
from replays import rows_of

from hmdwarp.display import Closed, Command, Lost, Tick
from hmdwarp.errors import MachineError
from hmdwarp.run import LiveOptions, MarkerStream, live_run

from .lsl import lsl_on_this_machine, receiving, with_lsl  # noqa: F401
from .offscreen import OffscreenDisplay, run_on

ROUNDING_S = 1e-8  # a double of the seconds that a machine is up
HEARD = 3  # pictures before the recorder is there
SETTINGS = {"latency": 30.0, "warp": "forward", "fill": "none", "guard": 1.0, "scene": "planes"}


def options(**more) -> LiveOptions:
    return LiveOptions(
        scene="planes", latency_ms=30.0, warp="forward", fill="none", guard=1.0, predict="none", lsl=True, **more
    )


@with_lsl
@pytest.mark.usefixtures("lsl_on_this_machine")
@pytest.mark.parametrize("late", [False, True], ids=["a recorder that waits", "a recorder that comes later"])
def test_a_recorder_gets_what_happens_at_the_instants_of_the_pictures(late, tmp_path, monkeypatch):
    events = {12: Tick(0, 0, missed=3), 18: Lost("the service died"), 26: Closed("the window was closed")}
    display = OffscreenDisplay(events=events, asked={14: [Command("latency", 40.0)]})
    streams, receivers, make = [], [], live_run.marker_stream

    with ExitStack() as stack:

        def receive() -> None:
            receivers.append(stack.enter_context(receiving("hmdwarp live", "run_end")))
            receivers[0].connected()
            while not streams[0].are_received:
                time.sleep(0.01)

        def making(*args) -> MarkerStream:
            streams.append(make(*args))
            if not late:
                receive()
            return streams[0]

        def after(number: int) -> None:
            if late and number == HEARD:
                receive()

        monkeypatch.setattr(live_run, "marker_stream", making)
        result = run_on(monkeypatch, display, options(out=tmp_path / "out"), after=after)
        markers = receivers[0].markers()
    live, count = result.summary["live"], result.summary["frames"]
    named = [marker["event"] for marker in markers]
    first = "settings" if late else "run_start"
    assert named == [first, "missed", "change", "display_lost", "display_back", "run_end"]
    of = dict(zip(named, markers, strict=True))
    assert of[first].items() >= {**SETTINGS, **({"pictures": HEARD} if late else {})}.items()
    assert of["missed"]["count"] == live["missed"] == 3
    assert (of["change"]["latency"], of["change"]["reason"]) == (40.0, "by hand")
    assert "warp" not in of["change"]
    assert of["display_lost"]["why"] == "the service died"
    assert of["run_end"]["pictures"] == count
    (change,), (lost,) = live["changes"], live["lost"]
    # The display waits for each picture; those before the first frame has arrived show none.
    after_missed = 12 - live["waiting"]
    numbers = [HEARD if late else 0, after_missed, change["frame"] + 1, lost["frame"], lost["frame"] + 1, count - 1]
    shown_ns = np.array([int(row["shown_ns"]) for row in rows_of(tmp_path / "out")[::2]])[numbers]
    stamps = np.array([marker["stamp"] for marker in markers])
    assert stamps - stamps[0] == pytest.approx((shown_ns - shown_ns[0]) * 1e-9, abs=ROUNDING_S)
    assert any("stream 'hmdwarp live'; the clock of this display is simulated" in line for line in display.said)
    assert display.said.count("no program receives the markers: start the recorder") == late


def test_without_pylsl_one_line_says_how_and_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(MachineError, match=r"^this needs pylsl, which is not installed: pip install '\.\[lsl\]'$"):
        run_on(monkeypatch, OffscreenDisplay(), options(out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()
