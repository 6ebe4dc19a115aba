"""A whole session: when what is shown, what is kept of it, and what of it nobody may see.

Interrupted anywhere, it loses nothing that was confirmed. What happens in it: transcripts/.
"""

from __future__ import annotations

import getpass
import os
import re
import socket

import numpy as np
import pytest
from run.offscreen import PERIOD_NS, RATE_HZ

from hmdwarp.base import InputError, MachineError
from hmdwarp.display import DisplayOptions, OffscreenDisplay
from hmdwarp.poses import load_trace
from hmdwarp.run import Lines
from hmdwarp.study import actual
from hmdwarp.study.actual import FLAGS, NUMBERS, TEXTS
from hmdwarp.study.design import load_design
from hmdwarp.study.session import runner
from hmdwarp.study.session.program import facts_of
from hmdwarp.study.store import COMPLETE, INTERRUPTED, RUNNING, Store

from . import sessions
from .conftest import LEAD_S, hurry
from .sessions import LATENCIES_MS, NAMES, closing, contents, run, study, whole

PERIOD_MS = PERIOD_NS * 1e-6


@pytest.fixture(scope="module")
def one(gpu, tmp_path_factory):
    """A session with everything in it, and what came of it."""
    with pytest.MonkeyPatch.context() as patch:
        hurry(patch)
        path = whole(tmp_path_factory.mktemp("whole"))
        ran = run(patch, gpu, path)
    assert ran.error is None
    return path, ran


def test_every_trial_shows_its_planned_condition(one):
    """A frame is shown at the first refresh at or after its latency. A refresh is shown two periods
    after it is asked for. So a frame's age lies within one period above the larger of the two.
    """
    path, _ = one
    planned = {**dict(zip(NAMES, LATENCIES_MS, strict=True)), "practice": 0.0}
    showings = contents(path).showings
    assert sorted(showing.condition for showing in showings) == sorted([*NAMES, "practice"])
    for showing in showings:
        actual, latency = showing.actual, max(planned[showing.condition], 2 * PERIOD_MS)
        assert {*NUMBERS, *FLAGS, *TEXTS} == set(actual)
        assert latency - 1e-6 <= actual["latency_ms_median"] <= latency + PERIOD_MS + 1e-6
        assert actual["latency_ms_sd"] < 1e-6  # the display's clock is even
        assert actual["seconds"] == pytest.approx(0.1, abs=PERIOD_MS * 1e-3 * 1.01)
        assert actual["rate_hz"] == pytest.approx(RATE_HZ)
        assert actual["missed"] == actual["lost_s"] == actual["tracking_lost_share"] == 0
        assert (actual["source"], actual["scene"], actual["size"]) == ("offscreen", "planes", "48x60")
        assert actual["warp"] == ("rotation" if showing.condition == NAMES[1] else "none")
        assert 0 <= actual["hole_share_mean"] <= 1
        assert actual["angular_speed_deg_s_median"] > 0


def test_trials_carry_when_they_began(one):
    """By the display's clock."""
    path, ran = one
    shown = {showing.key: showing.actual for showing in contents(path).showings}
    pictures = [at_ns for at_ns, is_picture, _ in ran.display.handed if is_picture]
    first = [b for a, b in zip([0, *pictures], pictures, strict=False) if b - a > 1e8]
    onsets = [shown[key]["onset_s"] for key in ("practice", "trial/1", "trial/2")]
    assert np.diff(onsets) == pytest.approx(np.diff(first) * 1e-9, abs=2e-3)
    assert onsets[0] > 0.2  # consent and the black before it


def test_a_pipeline_that_takes_long_to_build_does_not_tell_itself_by_the_wait(monkeypatch, gpu, tmp_path):
    """As long as building takes no longer than LEAD_S, from the panel to the first picture it is
    equally long.
    """

    class Slow(runner.PipelineHost):
        def __init__(self, display, options, scene) -> None:
            super().__init__(display, options, scene)
            if options.warp == "rotation":
                display._at_ns += round(0.6 * LEAD_S * 1e9)

    monkeypatch.setattr(runner, "PipelineHost", Slow)
    handed = run(monkeypatch, gpu, study(tmp_path)).display.handed
    waits = []
    for number in (1, 2):
        title = f"Trial {number} of 2"
        begun = next(k for k, (*_, label) in enumerate(handed) if getattr(label, "title", "") == title)
        first = next(k for k in range(begun, len(handed)) if handed[k][1])
        waits.append((handed[first][0] - handed[begun][0]) * 1e-6)
    assert waits[0] == pytest.approx(waits[1], abs=PERIOD_MS)


def test_no_title_panel_or_line_shows_the_condition(one):
    """Neither names nor settings stand in a title, on a panel or on the console."""
    _, ran = one
    titles = set(ran.display.titles)
    assert "hmdwarp - study small - trial 1 of 2" in titles
    seen = [*titles, *map(repr, ran.display.panels), *map(repr, ran.console.states), *ran.console.said, *ran.said]
    latencies = [rf"\b{latency}\b" for latency in LATENCIES_MS]
    told = re.compile("|".join([*NAMES, *latencies, "rotation", "warp", "latency", "planes"]))
    for text in seen:
        assert not told.search(text.replace("hmdwarp", "")), text


def test_every_recording_has_a_pose_for_each_picture_and_begins_with_the_same_motion(one):
    path, _ = one
    tracks = []
    for showing in contents(path).showings:
        file = path.with_name("small-data") / "traces" / showing.trace
        tracks.append(load_trace(str(file)).track)
        assert len(tracks[-1]) == showing.actual["pictures"]
        assert "hmdwarp study" in file.read_text(encoding="utf-8").partition("\n#")[2]
    for other in tracks[1:]:
        assert np.allclose(tracks[0].position_m, other.position_m, atol=1e-9)


def test_facts_of_the_machine_are_kept_without_personal_names(one):
    path, _ = one
    facts = contents(path).sessions[0].facts
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["gpu"]["renderer"]
    assert facts["seed"] == 5
    assert not {socket.gethostname(), getpass.getuser()} & set(re.findall(r"[\w.-]+", repr(facts)))


WRITING = ("begin", "record", "begin_showing", "end_showing", "answer", "end")


class Fault(Exception):
    """Something nobody foresaw."""


def faulty(patch: pytest.MonkeyPatch, at: int | None, after: bool) -> list[str]:
    """Raise at the n-th thing that is written, before or after it; what was written is listed."""
    written: list[str] = []

    def around(name, write):
        def writes(store, *args, **more):
            written.append(name)
            due = len(written) == at
            if due and not after:
                raise Fault
            result = write(store, *args, **more)
            if due:
                raise Fault
            return result

        patch.setattr(Store, name, writes)

    for name in WRITING:
        around(name, getattr(Store, name))
    return written


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
        count = faulty(patch, None, False)
        (tmp_path / "all").mkdir()
        assert run(patch, gpu, whole(tmp_path / "all")).error is None
    assert len(count) == 16
    for at in range(1, len(count) + 1):
        after = at % 2 == 0
        folder = tmp_path / str(at)
        folder.mkdir()
        path = whole(folder)
        with pytest.MonkeyPatch.context() as patch:
            faulty(patch, at, after)
            broken = run(patch, gpu, path)
        assert isinstance(broken.error, Fault), at
        stored = contents(path) if (folder / "small-data").exists() else None
        if stored is None or not stored.sessions:
            assert at == 1
            assert run(monkeypatch, gpu, path).error is None
        elif stored.sessions[0].status == COMPLETE:
            assert (at, after) == (len(count), True)
        else:
            assert stored.sessions[0].status == (RUNNING if at == 1 else INTERRUPTED), at
            assert run(monkeypatch, gpu, path, resume=True).error is None, at
        check_complete(path)


def full(*_):
    raise MachineError("x: cannot write (No space left on device): make room")


def full_recording(lines, data):
    lines.error = MachineError(f"{lines.path}: cannot write (No space left on device): make room")


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


def test_of_a_recorded_head_the_axes_are_kept_and_not_where_it_lies(gpu, tmp_path):
    """Folders are named after people. Axes: which for the world, which for the head, and why."""
    path = tmp_path / "head.csv"
    path.write_text("time,x,y,z,qx,qy,qz,qw\n" + "".join(f"{i / 90},0,{i / 900},0,0,0,0,1\n" for i in range(90)))
    display = OffscreenDisplay(DisplayOptions("rift-dk1", trace=load_trace(path).track, size=(32, 40)), gpu)
    facts = facts_of(display, load_design(str(study(tmp_path))), "/srv/jane/heads/walk.csv")
    assert facts["trace"] == "walk.csv" and "jane" not in repr(facts)
    assert facts["trace_axes"] == facts["display"]["trace_axes"]
    assert facts["trace_axes"].startswith("openxr (world=x,y,-z head=x,y,-z), assumed")
