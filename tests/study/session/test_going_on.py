"""Interrupted anywhere, a session loses nothing that was confirmed, and goes on where it was."""

from __future__ import annotations

import os

import pytest

from hmdwarp.display import DisplayOptions, OffscreenDisplay
from hmdwarp.errors import InputError, MachineError
from hmdwarp.poses import load_trace
from hmdwarp.run import Lines
from hmdwarp.study import actual
from hmdwarp.study.design import load_design
from hmdwarp.study.session import runner
from hmdwarp.study.session.program import facts_of
from hmdwarp.study.store import COMPLETE, INTERRUPTED, RUNNING, Store

from . import sessions
from .sessions import closing, contents, run, study, whole

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
    """A fault of ours at each of them: before it is written, or after, in turn. What was answered
    before stays, and the session is gone on with to its end.
    """
    short = sessions.TEXT.replace("= 130", "= 30").replace("= 170", "= 40").replace("0.1", "0.05")
    monkeypatch.setattr(sessions, "TEXT", short)
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


def full(*_):
    raise MachineError("x: cannot write (No space left on device): make room")


def full_recording(lines, data):
    lines._error = MachineError(f"{lines.path}: cannot write (No space left on device): make room")


def no_figures(*_):
    raise ZeroDivisionError


FAULTS = [  # what is replaced by what, from which picture on; the error, what it says, how many answers there are
    ((Store, "end", full), {5: closing()}, MachineError, "stored, resume with: ", 0),
    ((Lines, "_put", full_recording), {}, MachineError, "No space left on device): make room; what was answered", 1),
    ((runner, "actual_of", no_figures), {}, ZeroDivisionError, "", 0),
]


@pytest.mark.parametrize(("fault", "at", "kind", "says", "answers"), FAULTS, ids=["end", "recording", "figures"])
def test_whatever_fails_what_was_answered_is_stored_and_the_session_resumes(
    monkeypatch, gpu, path, fault, at, kind, says, answers
):
    """The error says how to go on, or else the last line does."""
    with pytest.MonkeyPatch.context() as patch:
        if answers:
            at = {15: lambda: patch.setattr(*fault)}
        else:
            patch.setattr(*fault)
        ran = run(patch, gpu, path, at=at)
    assert isinstance(ran.error, kind) and says in str(ran.error)
    told = ran.said[-1] if ran.said else str(ran.error)
    assert f"resume with: hmdwarp study run {path} --participant P1 --resume" in told
    assert len(contents(path).answers) == answers
    assert run(monkeypatch, gpu, path, resume=True).session.status == COMPLETE
    assert actual.actual_of({}, lambda name: 1 / 0) == actual.NOTHING


def test_a_link_that_delivers_no_frame_is_an_error(monkeypatch, gpu, path):
    monkeypatch.setattr(runner, "PATIENCE_S", 0.1)
    text = path.read_text(encoding="utf-8").replace('scene = "planes"', 'scene = "planes"\nbandwidth = 0.001')
    path.write_text(text, encoding="utf-8")
    ran = run(monkeypatch, gpu, path)
    assert isinstance(ran.error, InputError)
    assert "trial/1: no frame came within 0.1 s: see what loss and bandwidth let through" in str(ran.error)


def test_a_session_beside_another_is_refused_before_the_display_opens(monkeypatch, gpu, path):
    with Store(path.with_name("small-data"), create=True) as other:
        other.begin(load_design(str(path)), None, "P0", "person")
        ran = run(monkeypatch, gpu, path)
    assert isinstance(ran.error, MachineError) and f", process {os.getpid()} on " in str(ran.error)
    assert ran.display.labels == []


def test_a_drawn_code_is_printed(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, participant="new")
    assert ran.said[0].startswith(f"participant {ran.session.code}, ")
    assert len(ran.session.code) == 5


def test_of_a_recorded_head_the_axes_are_kept_and_not_where_it_lies(gpu, tmp_path):
    """Folders are named after people. Axes: which for the world, which for the head, and why."""
    path = tmp_path / "head.csv"
    path.write_text("time,x,y,z,qx,qy,qz,qw\n" + "".join(f"{i / 90},0,{i / 900},0,0,0,0,1\n" for i in range(90)))
    display = OffscreenDisplay(DisplayOptions("rift-dk1", trace=load_trace(path).track, size=(32, 40)), gpu)
    facts = facts_of(display, load_design(str(study(tmp_path))), "/srv/jane/heads/walk.csv")
    assert facts["trace"] == "walk.csv" and "jane" not in repr(facts)
    assert facts["trace_axes"] == facts["display"]["trace_axes"]
    assert facts["trace_axes"].startswith("openxr (world=x,y,-z head=x,y,-z), assumed")
