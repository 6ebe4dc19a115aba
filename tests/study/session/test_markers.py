"""Markers of a session in the Lab Streaming Layer: a real inlet in another process records them.

LSL looks for streams on this machine only, and among those of one run of the tests.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

import needs
import numpy as np
import pytest
from run.offscreen import PERIOD_NS

from hmdwarp.base import MachineError
from hmdwarp.display.offscreen import AHEAD
from hmdwarp.study.dialogs.dialog_panels import MessagePanel, QuestionPanel
from hmdwarp.study.session.markers import MarkerStream

from .sessions import Person, contents, run, study, whole

CONFIGURATION = f"""
[lab]
SessionID = {uuid.uuid4().hex}
[multicast]
ResolveScope = machine
[ports]
IPv6 = disable
[log]
level = -3
"""
# Says that it is connected, then each marker with its stamp, and its description, until the stream
# says that it has ended.
INLET = """
import json, sys, pylsl
found = pylsl.resolve_byprop("name", sys.argv[1], timeout=600)
inlet = pylsl.StreamInlet(found[0], recover=False)
inlet.open_stream()
description = inlet.info().as_xml()
offset = inlet.time_correction()
print(json.dumps({"xml": description, "type": found[0].type(), "offset_s": offset}), flush=True)
while True:
    (text,), stamp = inlet.pull_sample()
    print(json.dumps({"stamp": stamp, **json.loads(text)}), flush=True)
    if json.loads(text)["event"] == sys.argv[2]:
        break
"""
AHEAD_NS = 10**15  # of the display's clock; a double of so many seconds still tells 0.2 us apart
ROUNDING_S = 1e-8  # a double of the seconds that a machine is up: below 2^-53 of a year


@pytest.fixture
def lsl(tmp_path_factory, monkeypatch) -> None:
    """LSL, which reads its configuration once in a process."""
    try:
        import pylsl  # noqa: F401
    except ImportError:
        pytest.skip(needs.missing("pylsl", "pip install '.[lsl]'"))
    except RuntimeError:
        pytest.skip(needs.missing("liblsl", "conda install -c conda-forge liblsl"))
    file = tmp_path_factory.mktemp("lsl") / "lsl.cfg"
    file.write_text(CONFIGURATION, encoding="utf-8")
    monkeypatch.setenv("LSLAPICFG", str(file))


@contextmanager
def receiving(name: str, last: str) -> Iterator[subprocess.Popen[str]]:
    """Start a receiver of a stream by its name and the last event in it."""
    process = subprocess.Popen([sys.executable, "-c", INLET, name, last], stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def connected(receiver: subprocess.Popen[str]) -> dict[str, object]:
    """Wait until the stream is found, and return what it says of itself."""
    return json.loads(receiver.stdout.readline())


def markers_of(receiver: subprocess.Popen[str]) -> list[dict[str, object]]:
    """Wait for the last event, and return all markers."""
    rest = [json.loads(line) for line in receiver.stdout]
    assert receiver.wait() == 0
    return rest


@pytest.mark.usefixtures("lsl")
def test_stamps_are_the_instants_of_the_display_on_lsl_s_clock():
    """On Linux LSL's clock is CLOCK_MONOTONIC, so the stamps are known to the nanosecond. A clock
    of its own, another zero: each stamp is off by no more than the stream says.
    """

    def now_ns() -> int:
        return time.monotonic_ns() + AHEAD_NS

    with receiving("clocks", "end") as receiver:
        stream = MarkerStream("clocks", {"study": "none"}, now_ns)
        told, said = connected(receiver), stream.describe()
        first_error_s = stream.error_s
        instants_ns = [now_ns() + ahead_ns for ahead_ns in (0, 30_000_000, -2_000_000_000)]
        while not stream.are_received:
            time.sleep(0.01)
        for number, at_ns in enumerate(instants_ns):
            stream.send("shown", at_ns, number=number)
        stream.send("end", now_ns())
        stream.close()
        markers = markers_of(receiver)
    found = [(marker["event"], marker.get("number")) for marker in markers]
    assert found == [("shown", 0), ("shown", 1), ("shown", 2), ("end", None)]
    assert told["type"] == "Markers"
    assert "<study>none</study>" in told["xml"] and f"<clock_error_s>{first_error_s:.1e}</clock_error_s>" in told["xml"]
    assert f"within {first_error_s * 1e6:.1f} us" in said
    for marker, at_ns in zip(markers, instants_ns, strict=False):
        assert abs(marker["stamp"] - (at_ns - AHEAD_NS) * 1e-9) <= stream.error_s + ROUNDING_S


def wanted(order: list[str]) -> Iterator[str]:
    """The markers of a session of these conditions, from its first trial on."""
    for trial, condition in enumerate(order, 1):
        about = f"step trial/{trial}, trial {trial}, showing {trial + 1}, presentation 1"
        yield f"event trial_start, {about}, condition {condition}"
        yield f"event trial_end, {about}, complete True"
        for scale in ("grade", "fms"):
            answer = f"step trial/{trial}/{scale}/{scale}, scale {scale}, item {scale}, value 2.0"
            yield f"event answer, {answer}, showing {trial + 1}, revision 1"
    yield "event answer, step after/acr/quality, scale acr, item quality, value 2.0, showing None, revision 1"
    yield "event session_end, status complete"


@pytest.mark.usefixtures("lsl")
def test_a_recorder_gets_trials_answers_and_conditions_at_the_instants_of_the_pictures(tmp_path, gpu, monkeypatch):
    path = whole(tmp_path)
    with receiving("hmdwarp study small", "session_end") as receiver:

        def waits_for_the_recorder(panel):
            if isinstance(panel, MessagePanel) and panel.title == "Ready?":
                connected(receiver)

        ran = run(monkeypatch, gpu, path, Person(own=waits_for_the_recorder), lsl=True)
        assert ran.error is None
        markers = markers_of(receiver)
    # What came before the recorder was connected is lost to it; the practice makes sure of that.
    markers = markers[[marker.get("step") for marker in markers].index("trial/1") :]
    session = ran.session
    assert {(marker["participant"], marker["session"]) for marker in markers} == {(session.sub, session.number)}
    assert session.code not in repr(markers)
    told = []
    for marker in markers:
        kept = [f"{key} {value}" for key, value in marker.items() if key not in ("stamp", "participant", "session")]
        told.append(", ".join(kept))
    order = [showing.condition for showing in contents(path).showings[1:]]
    assert told == [*wanted(order)]

    starts, ends = ([marker for marker in markers if marker["event"] == f"trial_{what}"] for what in ("start", "end"))
    # Beside each other, as this display's clock is simulated: it advances by refreshes.
    pictures = [at_ns + AHEAD * PERIOD_NS for at_ns, is_picture, _ in ran.display.handed if is_picture]
    breaks = np.flatnonzero(np.diff(pictures) > PERIOD_NS) + 1
    instants = np.array([(part[0], part[-1]) for part in np.split(np.array(pictures), breaks)][1:])
    stamps = np.array([[start["stamp"], end["stamp"]] for start, end in zip(starts, ends, strict=True)])
    assert stamps - stamps[0, 0] == pytest.approx((instants - instants[0, 0]) * 1e-9, abs=ROUNDING_S)
    asked = [at_ns for at_ns, _, panel in ran.display.handed if isinstance(panel, QuestionPanel)][1:]  # after practice
    answered = np.array([marker["stamp"] for marker in markers if marker["event"] == "answer"])
    assert answered - stamps[0, 0] == pytest.approx((np.array(asked) - instants[0, 0]) * 1e-9, abs=ROUNDING_S)
    in_order = [marker["stamp"] for marker in markers if marker["event"] != "trial_end"]
    assert in_order == sorted(in_order)
    simulated = "stream 'hmdwarp study small'; the clock of this display is simulated"
    assert any(simulated in line for line in ran.console.said)


@pytest.mark.usefixtures("lsl")
def test_where_nothing_receives_the_markers_the_console_says_so_before_each_trial(tmp_path, gpu, monkeypatch):
    ran = run(monkeypatch, gpu, study(tmp_path), lsl=True)
    assert ran.error is None
    assert ran.console.said.count("no program receives the markers: start the recorder") == 2


def test_without_pylsl_one_line_says_how_and_nothing_is_begun(tmp_path, gpu, monkeypatch):
    monkeypatch.setitem(sys.modules, "pylsl", None)
    ran = run(monkeypatch, gpu, study(tmp_path), lsl=True)
    assert isinstance(ran.error, MachineError)
    assert str(ran.error) == "this needs pylsl, which is not installed: pip install '.[lsl]'"
    assert not (tmp_path / "small-data").exists()
