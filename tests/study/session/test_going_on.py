"""Interrupted anywhere, a session loses nothing that was confirmed, and goes on where it was."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hmdwarp.display import DisplayOptions, OffscreenDisplay
from hmdwarp.errors import InputError, MachineError
from hmdwarp.poses import load_trace
from hmdwarp.study import actual, scales
from hmdwarp.study.design import load_design
from hmdwarp.study.session.program import facts_of
from hmdwarp.study.store import COMPLETE, INTERRUPTED, RUNNING, Store

from . import sessions
from .sessions import Person, closing, contents, losing, run, study, whole

WRITING = ("begin", "record", "begin_showing", "end_showing", "answer", "end")


class Fault(Exception):
    """Something nobody foresaw."""


class Faults:
    """Counts what is written, and raises at the n-th: before it is written, or after."""

    def __init__(self, monkeypatch, at: int | None, after: bool) -> None:
        self.count, self._at, self._after = 0, at, after
        for name in WRITING:
            monkeypatch.setattr(Store, name, self._around(getattr(Store, name)))

    def _around(self, write):
        def writes(store, *args, **more):
            self.count += 1
            due = self.count == self._at
            if due and not self._after:
                raise Fault
            result = write(store, *args, **more)
            if due:
                raise Fault
            return result

        return writes


def check_complete(path) -> None:
    """One answer that counts for each question, none of them doubled, each about a trial that was
    seen just before by the same program.
    """
    stored = contents(path)
    assert [session.status for session in stored.sessions] == [COMPLETE]
    keys = [answer.key for answer in stored.answers]
    assert sorted(keys) == sorted({*keys})
    assert len(keys) == 6
    assert all(answer.value == 2 for answer in stored.answers)
    seen: dict[str, bool] = {}
    for event in stored.events:
        if event.kind in ("begin", "resume"):
            seen.clear()
        elif event.kind == "shown":
            seen[event.key] = event.data["complete"]
        elif event.kind == "answer" and not event.key.startswith("after"):
            about = event.key.rsplit("/", 2)[0]
            assert seen.get(about), f"{event.key} was asked about what this sitting had not seen"


@pytest.mark.slow(20)
def test_a_fault_at_every_single_thing_that_is_written(monkeypatch, gpu, tmp_path):
    """A fault of ours at each of them: before it is written, or after, in turn.

    What was answered before stays, and the session is gone on with to its end.
    """
    monkeypatch.setattr(
        sessions, "TEXT", sessions.TEXT.replace("= 130", "= 30").replace("= 170", "= 40").replace("0.1", "0.05")
    )
    with pytest.MonkeyPatch.context() as patch:
        faults = Faults(patch, None, False)
        (tmp_path / "all").mkdir()
        assert run(patch, gpu, whole(tmp_path / "all")).error is None
    assert faults.count == 16
    for at in range(1, faults.count + 1):
        after = at % 2 == 0
        folder = tmp_path / str(at)
        folder.mkdir()
        path = whole(folder)
        with pytest.MonkeyPatch.context() as patch:
            Faults(patch, at, after)
            broken = run(patch, gpu, path)
        assert isinstance(broken.error, Fault), at
        stored = contents(path) if (folder / "small-data").exists() else None
        if stored is None or not stored.sessions:
            assert at == 1
            assert run(monkeypatch, gpu, path).error is None
        elif stored.sessions[0].status == COMPLETE:
            assert (at, after) == (faults.count, True)
        else:
            assert stored.sessions[0].status == (RUNNING if at == 1 else INTERRUPTED), at
            assert run(monkeypatch, gpu, path, resume=True).error is None, at
        check_complete(path)


def test_a_window_closed_in_mid_trial(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, at={5: closing()})
    assert ran.error is None
    assert (ran.session.status, ran.session.why) == (INTERRUPTED, "the window was closed")
    assert ran.said[0] == "participant P1, session 1, part main: interrupted: the window was closed"
    assert ran.said[-1] == f"resume with: hmdwarp study run {path} --participant P1 --resume --source desktop"
    (cut,) = contents(path).showings
    assert not cut.complete
    assert cut.actual["pictures"] == 5
    again = run(monkeypatch, gpu, path, resume=True)
    assert again.session.status == COMPLETE
    assert [(showing.key, showing.presentation, showing.complete) for showing in contents(path).showings] == [
        ("trial/1", 1, False), ("trial/1", 2, True), ("trial/2", 1, True),
    ]  # fmt: skip
    assert len({showing.trace for showing in contents(path).showings}) == 3
    assert "We go on with trial 1 of 2" in " ".join(again.display.panels[0].lines)


def test_a_trial_seen_in_an_earlier_run_is_shown_again_before_its_rating(monkeypatch, gpu, path):
    person = Person(lambda panel: () if getattr(panel, "heading", "") == "trial 1" else None)
    count = 0

    def until_asked(panel):
        nonlocal count
        count += 1
        if count > 5:
            raise closing()

    person.looks, usual = (
        lambda panel: until_asked(panel) or () if getattr(panel, "heading", "") else usual(panel),
        person.looks,
    )
    assert run(monkeypatch, gpu, path, person).session.status == INTERRUPTED
    assert [(showing.key, showing.complete) for showing in contents(path).showings] == [("trial/1", True)]
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE
    first, second = [showing for showing in contents(path).showings if showing.key == "trial/1"]
    assert (first.presentation, second.presentation) == (1, 2)
    answer = next(answer for answer in contents(path).answers if answer.key == "trial/1/grade/grade")
    assert answer.showing == second.id


def test_a_display_that_comes_back_shows_the_trial_again(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, at={5: losing()})
    assert ran.session.status == COMPLETE
    shown = [(showing.key, showing.presentation, showing.complete) for showing in contents(path).showings]
    assert shown == [("trial/1", 1, False), ("trial/1", 2, True), ("trial/2", 1, True)]
    kinds = [event.kind for event in contents(path).events]
    assert kinds.index("lost") < kinds.index("shown")
    assert any("waiting up to" in text for text in ran.console.said)
    assert "it is back" in ran.console.said


def test_a_display_that_stays_away_ends_it_with_words_and_nothing_lost(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, at={15: losing()}, back_after=1000)
    assert isinstance(ran.error, MachineError)
    assert "has not come back within" in str(ran.error)
    assert "--participant P1 --resume" in str(ran.error)
    assert ran.said == []  # the error says it all
    stored = contents(path)
    assert stored.sessions[0].status == INTERRUPTED
    assert len(stored.answers) == 1
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE


def test_an_unwritable_interruption_says_how_to_resume(monkeypatch, gpu, path):
    def full(*_):
        raise MachineError("no room is left on the disk")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Store, "end", full)
        ran = run(patch, gpu, path, at={5: closing()})
    assert isinstance(ran.error, MachineError)
    assert "what was answered before is stored, resume with:" in str(ran.error)
    assert ran.said == []  # the error says it all
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE


def test_a_disk_that_is_full_in_mid_session(monkeypatch, gpu, tmp_path):
    """The recording meets it first; the same words, whatever does."""
    from hmdwarp.run import Lines

    path, put = study(tmp_path), Lines._put

    def full(lines, data):
        lines._error = MachineError(f"{lines.path}: cannot write (No space left on device): make room")

    def fills() -> None:
        monkeypatch.setattr(Lines, "_put", full)

    ran = run(monkeypatch, gpu, path, at={15: fills})
    monkeypatch.setattr(Lines, "_put", put)
    assert isinstance(ran.error, MachineError)
    assert "No space left on device" in str(ran.error)
    assert "what was answered before is stored, resume with:" in str(ran.error)
    assert [answer.key for answer in contents(path).answers] == ["trial/1/grade/grade"]
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE


def test_a_fault_in_the_log_s_figures_keeps_what_was_shown(monkeypatch, gpu, path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hmdwarp.study.session.runner.actual_of", lambda *_: 1 / 0)
        ran = run(patch, gpu, path)
    assert isinstance(ran.error, ZeroDivisionError)
    assert ran.said[-1].startswith("resume with: ")
    assert contents(path).sessions[0].status == INTERRUPTED
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE
    assert actual.actual_of({}, lambda name: 1 / 0) == actual.NOTHING


def test_an_interrupted_session_resumes_with_its_first_plan(monkeypatch, gpu, path):
    run(monkeypatch, gpu, path, at={5: closing()})
    path.write_text(path.read_text(encoding="utf-8").replace("seconds = 0.1", "seconds = 0.3"), encoding="utf-8")
    ran = run(monkeypatch, gpu, path, resume=True)
    assert ran.session.status == COMPLETE
    assert all(showing.actual["seconds"] < 0.15 for showing in contents(path).showings if showing.complete)


def test_a_session_is_not_resumed_with_a_changed_custom_scale(monkeypatch, gpu, tmp_path):
    """The plan's text is kept, not the file that it names.

    Half in quarter steps and half in whole ones would be no session.
    """
    path, own = study(tmp_path), tmp_path / "own.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"grade"', '"own.toml"'), encoding="utf-8")
    was = (Path(scales.__file__).parent / "grade.toml").read_text(encoding="utf-8")
    own.write_text(was, encoding="utf-8")
    assert run(monkeypatch, gpu, path, at={15: closing()}).session.status == INTERRUPTED
    own.write_text(was.replace("step = 0.25", "step = 1"), encoding="utf-8")
    ran = run(monkeypatch, gpu, path, resume=True)
    assert isinstance(ran.error, InputError)
    assert "(scales): undo that" in str(ran.error)
    own.write_text(was, encoding="utf-8")
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE


def test_refusals_come_before_the_display_opens(monkeypatch, gpu, path):
    assert run(monkeypatch, gpu, path).session.status == COMPLETE
    for options, told in [
        ({}, "--new-session begins another"),
        ({"resume": True}, "no interrupted session to resume"),
        ({"participant": "nobody", "resume": True}, "not known"),
        ({"participant": "Anna Meier"}, "must not be a name"),
        ({"part": "two"}, "--part two is not in"),
        ({"simulate": "perfect", "store": path.with_name("small-data")}, "person participants"),
        ({"participant": "P2", "simulate": "no-such", "pilot": True}, "no-such"),
    ]:
        with pytest.MonkeyPatch.context() as patch:
            ran = run(patch, gpu, path, **options)
        assert isinstance(ran.error, InputError), options
        assert told in str(ran.error), ran.error
        assert ran.display.labels == []
    assert len(contents(path).sessions) == 1


def test_a_session_beside_another_is_refused_before_the_display_opens(monkeypatch, gpu, path):
    with Store(path.with_name("small-data"), create=True) as other:
        other.begin(load_design(str(path)), None, "P0", "person")
        ran = run(monkeypatch, gpu, path)
    assert isinstance(ran.error, MachineError) and f", process {os.getpid()} on " in str(ran.error)
    assert ran.display.labels == []


def test_a_further_session_and_a_pilot_are_sessions_of_their_own(monkeypatch, gpu, path):
    run(monkeypatch, gpu, path)
    assert run(monkeypatch, gpu, path, new_session=True).session.number == 2
    rehearsal = run(monkeypatch, gpu, path, participant="R1", pilot=True)
    assert rehearsal.session.origin == "pilot"
    assert rehearsal.said[0].startswith("participant R1 (pilot)")
    assert "PILOT" in rehearsal.console.states[0].heading
    assert len(contents(path).sessions) == 2
    assert [session.code for session in contents(path, pilot=True).sessions] == ["R1"]


@pytest.mark.parametrize(
    ("was", "now", "told"),
    [
        (
            {},
            {"simulate": "quick"},
            "participant P1 is a person here, not a simulated: leave --pilot and --simulate away",
        ),
        ({}, {"pilot": True}, "participant P1 is a person here, not a pilot"),
        ({"pilot": True}, {}, "give --pilot to resume"),
    ],
)
def test_a_session_is_resumed_by_its_own_origin_alone(monkeypatch, gpu, tmp_path, was, now, told, path):
    """Else made-up answers would get into somebody's session."""
    one = {"store": tmp_path / "one"}
    assert run(monkeypatch, gpu, path, at={5: closing()}, **was, **one).session.status == INTERRUPTED
    with pytest.MonkeyPatch.context() as patch:
        ran = run(patch, gpu, path, resume=True, **now, **one)
    assert isinstance(ran.error, InputError)
    assert told in str(ran.error)
    with Store(tmp_path / "one") as store:
        assert store.contents(pilot=bool(was)).sessions[0].status == INTERRUPTED


def test_a_drawn_code_is_printed(monkeypatch, gpu, tmp_path):
    ran = run(monkeypatch, gpu, study(tmp_path), participant="new")
    assert ran.said[0].startswith(f"participant {ran.session.code}, ")
    assert len(ran.session.code) == 5


def test_where_a_recorded_head_lies_is_not_kept(gpu, tmp_path):
    """Folders are named after people."""
    facts = facts_of(
        sessions.SeatedDisplay(gpu, Person()), load_design(str(study(tmp_path))), "/srv/jane/heads/walk.csv"
    )
    assert facts["trace"] == "walk.csv"
    assert "jane" not in repr(facts)


def test_the_axes_that_a_recorded_head_was_read_in_are_kept(gpu, tmp_path):
    """Which for the world, which for the head, and why: here nobody says so."""
    path = tmp_path / "head.csv"
    path.write_text("time,x,y,z,qx,qy,qz,qw\n" + "".join(f"{i / 90},0,{i / 900},0,0,0,0,1\n" for i in range(90)))
    display = OffscreenDisplay(DisplayOptions("rift-dk1", trace=load_trace(path).track, size=(32, 40)), gpu)
    facts = facts_of(display, load_design(str(study(tmp_path))), str(path))
    assert facts["trace_axes"] == facts["display"]["trace_axes"]
    assert facts["trace_axes"].startswith("openxr (world=x,y,-z head=x,y,-z), assumed")
