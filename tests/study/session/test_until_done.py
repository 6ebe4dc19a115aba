"""Trials that last until the participant is done."""

from __future__ import annotations

import pytest

from hmdwarp.display import Command
from hmdwarp.study.design import Show
from hmdwarp.study.dialogs.dialog_panels import MessagePanel

from .sessions import Person, ScriptedConsole, closing, contents, run, study

LONGEST_S = 0.4


def until_done(folder, more: str = ""):
    """The small study, with trials that people end."""
    path = study(folder, more)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("seconds = 0.1", f'seconds = "until done"\nlongest = {LONGEST_S}'), encoding="utf-8")
    return path


def is_number(panel: object) -> bool:
    return isinstance(panel, MessagePanel) and panel.title.startswith("Trial")


class Decided(Person):
    """Confirms in the black already, which ends nothing, and once during the first pictures."""

    def looks(self, panel):
        new = panel != self._last
        usual = super().looks(panel)
        return (Command("confirm"),) if new and (panel == "" or is_number(panel)) else usual


def test_the_participant_ends_a_trial_and_the_panel_before_it_says_how(monkeypatch, gpu, tmp_path):
    path = until_done(tmp_path)
    console = ScriptedConsole()
    ran = run(monkeypatch, gpu, path, person=Decided(), console=console)
    assert ran.session.status == "complete"
    shown = [showing.actual for showing in contents(path).showings]
    assert [showing["ended_by"] for showing in shown] == ["participant", "participant"]
    assert all(showing["pictures"] > 0 and showing["seconds"] < LONGEST_S / 2 for showing in shown)
    numbers = [panel for panel in ran.display.panels if is_number(panel)]
    assert {panel.hint for panel in numbers} == {"Look around as long as you like. Enter: done"}
    # Over the pictures there is nothing, no clock either.
    assert ran.display.labels.count("") == ran.display.shown == sum(showing["pictures"] for showing in shown)
    seen = [state for state in console.states if state.phase == "showing" and state.seen_s is not None]
    assert seen
    assert all(state.seen_s + state.left_s == pytest.approx(LONGEST_S) for state in seen)


def test_an_unended_trial_lasts_its_longest_time(monkeypatch, gpu, tmp_path):
    path = until_done(tmp_path)
    run(monkeypatch, gpu, path)
    for showing in contents(path).showings:
        assert showing.actual["ended_by"] == "time"
        assert showing.actual["seconds"] == pytest.approx(LONGEST_S, abs=0.03)


def test_a_confirmation_ends_no_trial_with_a_time_of_its_own(monkeypatch, gpu, path):
    run(monkeypatch, gpu, path, person=Decided())
    for showing in contents(path).showings:
        assert showing.actual["ended_by"] == "time"
        assert showing.actual["seconds"] == pytest.approx(0.1, abs=0.03)


def test_the_experimenter_may_end_it_on_request(monkeypatch, gpu, tmp_path):
    path = until_done(tmp_path)
    console = ScriptedConsole(lambda state: [Command("continue")] if state.seen_s else [])
    ran = run(monkeypatch, gpu, path, console=console)
    assert ran.session.status == "complete"
    assert {showing.actual["ended_by"] for showing in contents(path).showings} == {"experimenter"}


def test_a_session_cut_off_in_such_a_trial_resumes_with_it(monkeypatch, gpu, tmp_path):
    path = until_done(tmp_path)
    assert run(monkeypatch, gpu, path, at={6: closing()}).session.status == "interrupted"
    assert run(monkeypatch, gpu, path, person=Decided(), resume=True).session.status == "complete"
    ended = [(showing.key, showing.complete, showing.actual["ended_by"]) for showing in contents(path).showings]
    assert ended == [("trial/1", False, ""), ("trial/1", True, "participant"), ("trial/2", True, "participant")]


class Looker:
    """Ends each trial once its drawn time is over, as simulated participants do."""

    def commands(self, step, shown, elapsed_s):
        is_over = isinstance(step, Show) and step.until_done and elapsed_s >= 0.3
        return (Command("continue"),) if is_over else ()


def test_a_respondents_end_differs_from_a_participants(monkeypatch, gpu, tmp_path):
    path = until_done(tmp_path)
    run(monkeypatch, gpu, path, respondent=Looker())
    assert {showing.actual["ended_by"] for showing in contents(path).showings} == {"simulated"}
