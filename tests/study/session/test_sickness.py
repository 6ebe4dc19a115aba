"""The stop rule: what it says of answers, and what happens to a session that meets it."""

from __future__ import annotations

import attrs
import pytest

from hmdwarp.display import Command
from hmdwarp.study.design import Sickness
from hmdwarp.study.dialogs.dialog_panels import QuestionPanel
from hmdwarp.study.scales import load_scale
from hmdwarp.study.session.runner import counting, why_sick
from hmdwarp.study.store import SICK, Answer

from .sessions import Person, ScriptedConsole, closing, contents, run, whole

FMS = load_scale("fms")
WORSE_BELOW = attrs.evolve(FMS, low_is_good=False)  # the same with 0 as the worst


def answers(*values: float | None) -> list[Answer]:
    return [
        Answer(trial, 1, f"trial/{trial}/fms/fms", 1, "trial", trial, "fms", "fms", value, 1.0, "participant", "")
        for trial, value in enumerate(values, 1)
    ]


@pytest.mark.parametrize(
    ("values", "stop_at", "rise", "is_sick"),
    [
        ((), 15, None, False), ((14,), 15, None, False), ((15,), 15, None, True),
        ((15, 14), 15, None, False),  # one that was corrected at the next question
        ((None,), 15, None, False), ((15, None), 15, None, True),  # "cannot say" decides nothing
        ((20,), None, None, False),
        ((2, 7), None, 5, True), ((2, 6), None, 5, False), ((7, 2), None, 5, False), ((None, 2, 7), None, 5, True),
    ],
)  # fmt: skip
def test_the_rule_ends_a_session(values, stop_at, rise, is_sick):
    assert bool(why_sick(Sickness(FMS, stop_at=stop_at, rise=rise), answers(*values))) is is_sick


def test_answers_after_all_trials_end_nothing():
    rule = Sickness(FMS, stop_at=15)
    afterwards = attrs.evolve(answers(18)[0], key="after/fms/fms", phase="after", trial=0)
    assert not why_sick(rule, [*answers(3), afterwards])
    assert why_sick(rule, [*answers(16), afterwards])


@pytest.mark.parametrize(("values", "is_sick"), [((5,), True), ((6,), False), ((18, 14), True), ((14, 18), False)])
def test_a_scale_that_counts_downwards_is_turned(values, is_sick):
    assert bool(why_sick(Sickness(WORSE_BELOW, stop_at=5, rise=4), answers(*values))) is is_sick


def test_no_rule_and_other_scales_end_nothing():
    assert why_sick(None, answers(20)) == ""
    assert why_sick(Sickness(FMS, stop_at=1), [attrs.evolve(answers(20)[0], scale="grade")]) == ""


def test_the_newest_revision_counts_in_the_place_of_the_first():
    first, second = answers(16, 3)
    corrected = attrs.evolve(first, id=3, revision=2, value=1.0)
    assert list(counting([first, second, corrected]).values()) == [corrected, second]
    assert why_sick(Sickness(FMS, rise=2), [first, second, corrected])
    assert "the session ends at 15" in why_sick(Sickness(FMS, stop_at=15), [first])


def feeling(*values: str, own=lambda panel: None) -> Person:
    """Says so each time the sickness scale comes."""
    coming = iter(values)

    def feels(panel):
        if isinstance(panel, QuestionPanel) and "sick" in panel.text and panel.value is None and not panel.typed:
            return [*(Command("digit", digit) for digit in next(coming, "0")), Command("confirm")]
        return own(panel)

    return Person(feels)


def test_at_the_stop_rule_the_session_ends_kindly_and_says_why(monkeypatch, gpu, tmp_path):
    path = whole(tmp_path)
    ran = run(monkeypatch, gpu, path, feeling("0", "16"))
    assert ran.error is None
    assert ran.session.status == SICK
    assert "16, and the session ends at 15" in ran.session.why
    stored = contents(path)
    assert [showing.key for showing in stored.showings] == ["practice", "trial/1"]
    assert [answer.key for answer in stored.answers][-1] == "after/acr/quality"  # asked all the same
    kinds = [event.kind for event in stored.events]
    assert kinds[-3:] == ["sick", "answer", "end"]
    assert [panel.title for panel in ran.display.panels if hasattr(panel, "title")][-2:] == [
        "We stop here",
        "Thank you",
    ]
    assert any("the stop rule" in text for text in ran.console.said)
    assert ran.said[0].startswith("participant P1, session 1, part main: sick: ")


def test_a_slip_at_the_sickness_scale_can_be_corrected(monkeypatch, gpu, tmp_path):
    path = whole(tmp_path)
    again = [Command("again")]
    console = ScriptedConsole(lambda state: [again.pop()] if again and state.step == "the session ends" else [])
    person = feeling("0", "16", "1", own=lambda panel: () if getattr(panel, "title", "") == "We stop here" else None)
    ran = run(monkeypatch, gpu, path, person, console)
    assert (ran.session.status, ran.session.why) == ("complete", "")
    values = [(answer.revision, answer.value) for answer in contents(path).answers if answer.key == "trial/1/fms/fms"]
    assert values == [(1, 16.0), (2, 1.0)]


def test_a_sick_participant_may_skip_the_last_questions(monkeypatch, gpu, tmp_path):
    path = whole(tmp_path)
    ran = run(monkeypatch, gpu, path,
    feeling("20", own=lambda panel: () if getattr(panel, "title", "") == "We stop here" else None),
              ScriptedConsole(lambda state: [Command("stop")] if state.step == "the session ends" else []))  # fmt: skip
    assert ran.session.status == SICK
    assert [answer.key for answer in contents(path).answers] == ["practice/fms/fms"]


def test_a_program_that_died_at_the_stop_rule_does_not_go_on_with_trials(monkeypatch, gpu, tmp_path):
    def closes(panel):
        if getattr(panel, "title", "") == "We stop here":
            raise closing()

    path = whole(tmp_path)
    assert run(monkeypatch, gpu, path, feeling("0", "16", own=closes)).session.status == "interrupted"
    ran = run(monkeypatch, gpu, path, resume=True)
    assert ran.session.status == SICK
    assert [showing.key for showing in contents(path).showings] == ["practice", "trial/1"]
