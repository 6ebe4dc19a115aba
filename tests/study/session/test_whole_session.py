"""A whole session: what is shown, asked and stored, in order, and what of it nobody may see."""

from __future__ import annotations

import re

import numpy as np
import pytest
from run.offscreen import PERIOD_NS, RATE_HZ

from hmdwarp.poses import load_trace
from hmdwarp.study.actual import FLAGS, NUMBERS, TEXTS
from hmdwarp.study.dialogs.dialog_panels import MessagePanel, QuestionPanel
from hmdwarp.study.session import runner

from .conftest import LEAD_S, hurry
from .sessions import LATENCIES_MS, NAMES, ScriptedConsole, contents, run, study, whole

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


def test_everything_happens_in_the_order_of_the_plan_and_is_stored_at_once(one):
    path, ran = one
    kinds = [f"{event.kind} {event.key}".strip() for event in contents(path).events]
    trial_1, trial_2 = (
        [f"showing trial/{n}", f"shown trial/{n}", f"answer trial/{n}/grade/grade", f"answer trial/{n}/fms/fms"]
        for n in (1, 2)
    )
    practice = ["showing practice", "shown practice", "answer practice/fms/fms"]
    after = ["answer after/acr/quality", "end"]
    assert kinds == ["begin", "finished consent", *practice, *trial_1, "finished break/1", *trial_2, *after]
    assert ran.session.status == "complete"


def test_answers_are_those_that_were_given_about_what_was_shown(one):
    path, _ = one
    stored = contents(path)
    assert {(answer.value, answer.by, answer.revision) for answer in stored.answers} == {(2.0, "participant", 1)}
    shown = {showing.id: showing for showing in stored.showings}
    for answer in stored.answers:
        if answer.phase in ("trial", "practice"):
            assert answer.key.startswith(shown[answer.showing].key)
        else:
            assert answer.showing is None
    assert sorted(showing.condition for showing in stored.showings) == sorted([*NAMES, "practice"])
    assert all(showing.complete and showing.presentation == 1 for showing in stored.showings)


def test_every_trial_shows_its_planned_condition(one):
    """A frame is shown at the first refresh at or after its latency. A refresh is shown two periods
    after it is asked for. So a frame's age lies within one period above the larger of the two.
    """
    path, _ = one
    planned = {**dict(zip(NAMES, LATENCIES_MS, strict=True)), "practice": 0.0}
    for showing in contents(path).showings:
        actual, latency = showing.actual, max(planned[showing.condition], 2 * PERIOD_MS)
        assert {*NUMBERS, *FLAGS, *TEXTS} == set(actual)
        assert latency - 1e-6 <= actual["latency_ms_median"] <= latency + PERIOD_MS + 1e-6
        assert actual["latency_ms_sd"] < 1e-6  # the display's clock is even
        assert actual["seconds"] == pytest.approx(0.1, abs=PERIOD_MS * 1e-3 * 1.01)
        assert actual["rate_hz"] == pytest.approx(RATE_HZ)
        assert actual["missed"] == actual["lost_s"] == actual["tracking_lost_share"] == 0
        assert (actual["source"], actual["scene"], actual["size"]) == ("offscreen", "planes", "96x120")
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


def test_the_participant_learns_how_to_look_before_the_first_trial(one):
    _, ran = one
    titles = [getattr(panel, "title", "") for panel in ran.display.panels]
    assert titles[:3] == ["Before we begin", "Ready?", "Practice: look around, it is not rated"]
    assert titles.count("Ready?") == 1
    ready = next(panel for panel in ran.display.panels if getattr(panel, "title", "") == "Ready?")
    assert "Move the mouse to look around" in " ".join(ready.lines)


def test_trials_with_a_still_head_are_reported(one):
    """A tenth of a second of a walk is next to nothing."""
    path, ran = one
    assert all(showing.actual["head_still"] for showing in contents(path).showings)
    assert sum("the head hardly moved (" in line for line in ran.console.said) == 3
    assert "the head hardly moved in 2 of 2 trials" in " ".join(ran.said)


def test_the_first_picture_is_there_at_once_whatever_the_latency(one):
    """A black wait as long as the latency would tell it.

    The lead is equally long for all, and frames are under way at its end.
    """
    _, ran = one
    labels = ran.display.labels
    leads = [
        number
        for number, label in enumerate(labels)
        if isinstance(label, MessagePanel) and re.match("Trial|Practice", label.title)
    ]
    runs = np.split(np.array(leads), np.flatnonzero(np.diff(leads) > 1) + 1)
    assert len(runs) == 3
    assert len({len(run) for run in runs}) == 1
    assert not any(isinstance(label, str) and label for label in labels)  # no "waiting for the first frame"


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
        begun = next(
            k for k, (_, _, label) in enumerate(handed) if getattr(label, "title", "") == f"Trial {number} of 2"
        )
        first = next(k for k in range(begun, len(handed)) if handed[k][1])
        waits.append((handed[first][0] - handed[begun][0]) * 1e-6)
    assert waits[0] == pytest.approx(waits[1], abs=PERIOD_MS)


def test_no_title_or_panel_shows_the_condition(one):
    """Neither names nor settings stand in a title, on a panel or on the console."""
    _, ran = one
    titles = set(ran.display.titles)
    assert "hmdwarp - study small - trial 1 of 2" in titles
    seen = [*titles, *map(repr, ran.display.panels), *map(repr, ran.console.states), *ran.console.said, *ran.said]
    assert all(isinstance(panel, str | MessagePanel | QuestionPanel) for panel in ran.display.panels)
    told = re.compile(
        "|".join([*NAMES, *(rf"\b{latency}\b" for latency in LATENCIES_MS), "rotation", "warp", "latency", "planes"])
    )
    for text in seen:
        assert not told.search(text.replace("hmdwarp", "")), text


def test_over_the_pictures_there_is_nothing(one):
    _, ran = one
    stored = sum(showing.actual["pictures"] for showing in contents(one[0]).showings)
    assert ran.display.labels.count("") == stored == ran.display.shown


@pytest.mark.parametrize(("blind", "is_told"), [("both", False), ("participant", True), ("nobody", True)])
def test_the_console_knows_the_condition_unless_the_plan_hides_it(monkeypatch, gpu, tmp_path, blind, is_told):
    console = ScriptedConsole()
    ran = run(monkeypatch, gpu, study(tmp_path, f'blind = "{blind}"'), console=console)
    told = {state.condition for state in console.states} - {""}
    assert told == (set(NAMES) if is_told else set())
    assert not any(
        name in repr(panel) + title for name in NAMES for panel in ran.display.panels for title in ran.display.titles
    )


def test_the_console_gets_everything_it_shows(one):
    _, ran = one
    states = ran.console.states
    assert {state.phase for state in states} == {"reading", "waiting", "showing", "asking", "break", "over"}
    assert states[0].heading == "study small, participant P1, session 1"
    assert {"consent", "practice", "trial 1 of 2", "break", "trial 2 of 2"} <= {state.step for state in states}
    asked = [state.question for state in states if state.question is not None]
    assert asked
    assert {state.participant for state in states} == {"P1"}
    elapsed = [state.elapsed_s for state in states]
    assert elapsed == sorted(elapsed)


def test_a_recording_has_a_pose_for_each_picture(one):
    path, _ = one
    showing = next(showing for showing in contents(path).showings if showing.condition == NAMES[1])
    file = path.with_name("small-data") / "traces" / showing.trace
    trace = load_trace(str(file))
    assert len(trace.track) == showing.actual["pictures"]
    assert "hmdwarp study" in file.read_text(encoding="utf-8").partition("\n#")[2]


def test_each_trial_begins_with_the_recording_s_beginning(one):
    """On a display that follows a recorded head, every condition is seen with the same motion."""
    path, _ = one
    traces = [
        load_trace(str(path.with_name("small-data") / "traces" / showing.trace)).track
        for showing in contents(path).showings
    ]
    for other in traces[1:]:
        assert np.allclose(traces[0].position_m, other.position_m, atol=1e-9)


def test_facts_of_the_machine_are_kept_without_personal_names(one):
    import getpass
    import socket

    path, _ = one
    facts = contents(path).sessions[0].facts
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["gpu"]["renderer"]
    assert facts["seed"] == 5
    assert not {socket.gethostname(), getpass.getuser()} & set(re.findall(r"[\w.-]+", repr(facts)))


def test_the_end_says_what_is_stored_where_and_what_comes_next(one):
    path, ran = one
    assert ran.said == [
        "participant P1, session 1, part main: complete",
        f"stored in {path.with_name('small-data')}: 6 answers, 4 of them about trials",
        "the head hardly moved in 2 of 2 trials: almost a still picture was rated (head_still)",
        f"next: another participant, or hmdwarp study export {path} --out DIR",
    ]
    assert ran.display.panels[-1].title == "Thank you"
