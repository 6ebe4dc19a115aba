"""Markers of a session in the Lab Streaming Layer: a real inlet in another process records one."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from run.offscreen import PERIOD_NS

from hmdwarp.display.offscreen import AHEAD
from hmdwarp.errors import MachineError
from hmdwarp.study.dialogs.dialog_panels import MessagePanel

from .lsl import lsl_on_this_machine, receiving, with_lsl  # noqa: F401
from .sessions import Person, contents, run, study, whole

ROUNDING_S = 1e-8  # a double of the seconds that a machine is up


@with_lsl
@pytest.mark.usefixtures("lsl_on_this_machine")
def test_a_recorder_gets_trials_answers_and_conditions_at_the_instants_of_the_pictures(tmp_path, gpu, monkeypatch):
    path = whole(tmp_path)
    with receiving("hmdwarp study small", "session_end") as receiver:

        def waits_for_the_recorder(panel):
            if isinstance(panel, MessagePanel) and panel.title == "Ready?":
                receiver.connected()

        ran = run(monkeypatch, gpu, path, Person(own=waits_for_the_recorder), lsl=True)
        assert ran.error is None
        markers = receiver.markers()
    stored = contents(path)
    # What came before the recorder was connected is lost to it; the practice makes sure of that.
    markers = markers[[marker.get("step") for marker in markers].index("trial/1") :]
    wanted = []
    for showing in stored.showings[1:]:
        asked = [("answer", answer.key) for answer in stored.answers if answer.showing == showing.id]
        wanted += [("trial_start", showing.key), ("trial_end", showing.key), *asked]
    after = [("answer", answer.key) for answer in stored.answers if answer.phase == "after"]
    assert [(marker["event"], marker.get("step")) for marker in markers] == [*wanted, *after, ("session_end", None)]

    shown = {showing.id: showing for showing in stored.showings}
    starts, ends = ([marker for marker in markers if marker["event"] == f"trial_{what}"] for what in ("start", "end"))
    for start, end in zip(starts, ends, strict=True):
        assert start["condition"] == shown[start["showing"]].condition
        assert (start["trial"], end["showing"], end["complete"]) == (
            shown[end["showing"]].trial,
            start["showing"],
            True,
        )
    values = {(answer.key, answer.value, answer.showing) for answer in stored.answers}
    answers = [marker for marker in markers if marker["event"] == "answer"]
    assert answers and all((answer["step"], answer["value"], answer["showing"]) in values for answer in answers)
    session = ran.session
    assert {(marker["participant"], marker["session"]) for marker in markers} == {(session.sub, session.number)}
    assert session.code not in repr(markers)
    assert markers[-1]["status"] == "complete"

    # Beside each other, as this display's clock is simulated: it advances by refreshes.
    pictures = [at_ns + AHEAD * PERIOD_NS for at_ns, is_picture, _ in ran.display.handed if is_picture]
    breaks = np.flatnonzero(np.diff(pictures) > PERIOD_NS) + 1
    instants = np.array([(part[0], part[-1]) for part in np.split(np.array(pictures), breaks)][1:])
    stamps = np.array([[start["stamp"], end["stamp"]] for start, end in zip(starts, ends, strict=True)])
    assert stamps - stamps[0, 0] == pytest.approx((instants - instants[0, 0]) * 1e-9, abs=ROUNDING_S)
    in_order = [marker["stamp"] for marker in markers if marker["event"] != "trial_end"]
    assert in_order == sorted(in_order)
    assert any(
        "stream 'hmdwarp study small'; the clock of this display is simulated" in line for line in ran.console.said
    )


@with_lsl
@pytest.mark.usefixtures("lsl_on_this_machine")
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
