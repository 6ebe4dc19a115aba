"""What may come between the steps.

Pauses, breaks, questions asked again, what is left unanswered, remarks, and the end at any moment.
"""

from __future__ import annotations

import pytest

from hmdwarp.display import Command
from hmdwarp.errors import InputError
from hmdwarp.study.analysis.long_table import from_contents
from hmdwarp.study.design import load_design
from hmdwarp.study.dialogs.dialog_panels import MessagePanel, QuestionPanel
from hmdwarp.study.export.write import export
from hmdwarp.study.store import COMPLETE, DECLINED, STOPPED, UNCONSENTED

from .sessions import Person, ScriptedConsole, contents, press, run, study, whole


def at_phase(phase: str, step: str, *commands: Command):
    """An experimenter who asks for something once, when that step is on."""
    asked = []

    def asks(state):
        if not asked and (state.phase, state.step) == (phase, step):
            asked.append(state)
            return commands
        return ()

    return ScriptedConsole(asks)


def events(path, *kinds: str) -> list[tuple[str, str]]:
    return [(event.kind, event.key) for event in contents(path).events if event.kind in kinds]


def presentations(path, key: str) -> list[tuple[int, bool]]:
    return [(showing.presentation, showing.complete) for showing in contents(path).showings if showing.key == key]


def test_a_trial_that_was_paused_is_shown_again_from_its_start(monkeypatch, gpu, path):
    console = at_phase("showing", "trial 1 of 2", Command("pause"))
    ran = run(monkeypatch, gpu, path, console=console)  # the participant goes on by the menu
    assert ran.session.status == COMPLETE
    assert presentations(path, "trial/1") == [(1, False), (2, True)]
    stored = contents(path)
    (answer,) = [answer for answer in stored.answers if answer.key == "trial/1/grade/grade"]
    assert answer.showing == next(showing.id for showing in stored.showings if showing.complete)
    assert events(path, "pause", "continue") == [("pause", "trial/1"), ("continue", "menu")]
    assert {state.step for state in ran.console.states if state.phase == "paused"} == {
        "trial 1 of 2"
    }  # in the middle of what
    menu = next(panel for panel in ran.display.panels if isinstance(panel, MessagePanel) and panel.title == "Menu")
    assert "have a break" in repr(menu.choices)


def test_the_experimenter_ends_a_pause_too(monkeypatch, gpu, path):
    wishes = {"showing": [Command("pause")], "paused": [Command("continue")]}
    person = Person(lambda panel: () if getattr(panel, "title", "") == "Menu" else None)
    ran = run(monkeypatch, gpu, path, person, ScriptedConsole(lambda state: wishes.pop(state.phase, ())))
    assert ran.session.status == COMPLETE
    by = [(event.kind, event.data["by"]) for event in contents(path).events if event.kind in ("pause", "continue")]
    assert by == [("pause", "experimenter"), ("continue", "experimenter")]


def test_everything_of_the_menu_by_hand(monkeypatch, gpu, path):
    """From a question: a break, the question of before again, then this one left unanswered."""
    wishes = ["break", "again", "skip"]

    def own(panel):
        if isinstance(panel, QuestionPanel) and panel.heading == "trial 2" and wishes:
            return [Command("menu")]
        if isinstance(panel, MessagePanel) and panel.title == "Menu":
            return [press(panel, wishes.pop(0))]
        return None

    ran = run(monkeypatch, gpu, path, Person(own))
    assert ran.error is None
    assert not wishes
    assert [kind for kind, _ in events(path, "pause", "break", "again", "skip", "answer")] == [
        "answer", "pause", "break", "pause", "again", "answer", "pause", "skip", "answer",
    ]  # fmt: skip
    answers = [(answer.key, answer.revision, answer.value) for answer in contents(path).answers]
    assert answers == [
        ("trial/1/grade/grade", 1, 2.0),
        ("trial/1/grade/grade", 2, 2.0),
        ("trial/2/grade/grade", 1, None),
    ]
    assert presentations(path, "trial/2") == [
        (1, True)
    ]  # a question that was interrupted is asked anew, and nothing is shown for it


def test_a_repeated_question_keeps_both_answers(monkeypatch, gpu, path):
    grades = iter("5213")

    def own(panel):
        if isinstance(panel, QuestionPanel) and panel.value is None and not panel.typed:
            return [Command("digit", next(grades)), Command("confirm")]
        return None

    ran = run(monkeypatch, gpu, path, Person(own), at_phase("showing", "trial 2 of 2", Command("again")))
    assert ran.session.status == COMPLETE
    answers = [(answer.key, answer.revision, answer.value) for answer in contents(path).answers]
    assert answers == [
        ("trial/1/grade/grade", 1, 5.0),
        ("trial/1/grade/grade", 2, 2.0),
        ("trial/2/grade/grade", 1, 1.0),
    ]
    showings = {answer.showing for answer in contents(path).answers[:2]}
    assert len(showings) == 1  # both are about the same showing
    assert presentations(path, "trial/2") == [(1, False), (2, True)]
    assert any("answered again" in text for text in ran.console.said)


def test_again_before_anything_was_asked_changes_nothing(monkeypatch, gpu, tmp_path):
    ran = run(monkeypatch, gpu, study(tmp_path), console=at_phase("showing", "trial 1 of 2", Command("again")))
    assert ran.session.status == COMPLETE
    assert "nothing has been answered yet" in ran.console.said


@pytest.mark.parametrize(
    ("phase", "step"),
    [
        ("reading", "consent"),
        ("showing", "practice"),
        ("asking", "practice"),
        ("showing", "trial 2 of 2"),
        ("break", "break"),
    ],
)
def test_stop_at_any_moment(monkeypatch, gpu, tmp_path, phase, step):
    path = whole(tmp_path)

    def waits(panel):
        busy = {"reading": getattr(panel, "title", "") == "Before we begin", "asking": isinstance(panel, QuestionPanel)}
        return () if busy.get(phase) else None

    ran = run(monkeypatch, gpu, path, Person(waits), at_phase(phase, step, Command("stop")))
    assert ran.error is None
    assert (ran.session.status, ran.session.why) == (UNCONSENTED if phase == "reading" else STOPPED, "")
    stored = contents(path)
    assert [event.kind for event in stored.events][-2:] == (["shown", "end"] if phase == "showing" else ["stop", "end"])
    before = {"consent": 0, "practice": 0, "trial 2 of 2": 3, "break": 3}[step]
    assert len(stored.answers) == before
    assert ran.display.panels[-1].title == "Thank you"


@pytest.mark.parametrize(
    ("phase", "commands", "answers"),
    [
        ("asking", [Command("answer", 3.0), Command("stop")], [3.0]),
        ("showing", [Command("pause"), Command("stop")], []),
    ],
)
def test_a_stop_that_comes_with_the_end_of_a_step_is_a_stop(monkeypatch, gpu, path, phase, commands, answers):
    """Both are there at one refresh, as after one that took long.

    The answer is kept, and the end is not passed over.
    """
    idle = Person(lambda panel: () if phase == "asking" and getattr(panel, "heading", "") == "trial 1" else None)
    ran = run(monkeypatch, gpu, path, idle, at_phase(phase, "trial 1 of 2", *commands))
    assert ran.session.status == STOPPED
    assert [answer.value for answer in contents(path).answers] == answers
    assert len(events(path, "stop")) == 1


def test_a_break_and_the_menu_that_come_with_an_answer_are_for_the_next_step(monkeypatch, gpu, path):
    idle = Person(lambda panel: () if getattr(panel, "heading", "") == "trial 1" else None)
    console = at_phase("asking", "trial 1 of 2", Command("answer", 3.0), Command("break"), Command("pause"))
    ran = run(monkeypatch, gpu, path, idle, console)
    assert ran.session.status == COMPLETE
    assert [kind for kind, _ in events(path, "break", "pause", "continue")] == ["break", "pause", "continue"]
    assert "A break" in [getattr(panel, "title", "") for panel in ran.display.panels]


def test_a_participant_stops_by_the_menu_after_one_question(monkeypatch, gpu, path):
    def own(panel):
        if isinstance(panel, QuestionPanel):
            return [Command("menu")]
        if isinstance(panel, MessagePanel) and panel.title == "Menu":
            return [press(panel, "stop")]
        if isinstance(panel, MessagePanel) and panel.title == "End the session now?":
            return [press(panel, "yes")]
        return None

    ran = run(monkeypatch, gpu, path, Person(own))
    assert ran.session.status == STOPPED
    assert "End the session now?" in [getattr(panel, "title", "") for panel in ran.display.panels]
    (stop,) = [event for event in contents(path).events if event.kind == "stop"]
    assert stop.data["by"] == "participant"


def test_without_agreement_nothing_is_shown(monkeypatch, gpu, tmp_path):
    path = whole(tmp_path)
    clicks = {"Before we begin": "refuse", "End without taking part?": "yes"}
    person = Person(
        lambda panel: [press(panel, clicks[panel.title])] if getattr(panel, "title", "") in clicks else None
    )
    ran = run(monkeypatch, gpu, path, person)
    assert ran.session.status == DECLINED
    assert events(path, "refused") == [("refused", "consent")]
    assert ran.display.shown == 0


@pytest.mark.parametrize(("command", "status"), [("decline", DECLINED), ("stop", UNCONSENTED)])
def test_without_the_consent_a_session_that_the_experimenter_ends_counts_nowhere(
    monkeypatch, gpu, tmp_path, command, status
):
    path = whole(tmp_path)
    console = at_phase("reading", "consent", Command(command))
    ran = run(monkeypatch, gpu, path, Person(lambda panel: ()), console)
    assert (ran.session.status, ran.display.shown) == (status, 0)
    assert " ".join(ran.display.panels[-1].lines) == "You are not taking part. Nothing was asked or shown."
    assert ran.said[0].endswith(f": {status}") and ran.said[1].endswith("small-data: no answers")
    with pytest.raises(InputError, match="1 session ended without the consent"):
        export(contents(path), load_design(str(path)), tmp_path / "out")
    run(monkeypatch, gpu, path, participant="P2")
    ratings = from_contents(contents(path), load_design(str(path)))
    assert ratings.sessions["status"].tolist() == [COMPLETE] and ratings.rows["participant"].nunique() == 1
    assert (ratings.rows["place"] > 0).all()  # what was asked before the trials is of no condition
    assert any("counted nowhere else: 1." in note for note in ratings.notes)


def test_the_experimenter_types_or_skips_spoken_words(monkeypatch, gpu, path):
    given = iter([Command("answer", 3.25), Command("skip")])
    console = ScriptedConsole(
        lambda state: [command] if state.phase == "asking" and (command := next(given, None)) else ()
    )
    ran = run(monkeypatch, gpu, path, Person(lambda panel: () if isinstance(panel, QuestionPanel) else None), console)
    assert ran.session.status == COMPLETE
    assert [(answer.value, answer.by) for answer in contents(path).answers] == [
        (3.25, "experimenter"),
        (None, "experimenter"),
    ]


def test_a_remark_is_kept_word_for_word_and_disturbs_nothing(monkeypatch, gpu, path):
    text = "the strap slipped; \N{SNOWMAN} 'quoted'"
    run(monkeypatch, gpu, path, console=at_phase("showing", "trial 2 of 2", Command("remark", text)))
    (remark,) = [event for event in contents(path).events if event.kind == "remark"]
    assert (remark.key, remark.data["text"], remark.data["by"]) == ("trial/2", text, "experimenter")
    assert presentations(path, "trial/2") == [(1, True)]


def test_a_requested_break_waits_until_the_trial_is_over(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, console=at_phase("showing", "trial 1 of 2", Command("break")))
    assert ran.session.status == COMPLETE
    assert presentations(path, "trial/1") == [(1, True)]
    titles = [getattr(panel, "title", None) or getattr(panel, "heading", "") for panel in ran.display.panels]
    assert titles.index("trial 1") < titles.index("A break") < titles.index("Trial 2 of 2")


def test_a_planned_break_lasts_as_long_as_it_should_and_then_as_long_as_is_wanted(monkeypatch, gpu, tmp_path):
    path = study(tmp_path, "[breaks]\nevery = 1\nseconds = 0.5")
    ran = run(monkeypatch, gpu, path)
    rest = [label for label in ran.display.labels if getattr(label, "title", "") == "A break"]
    assert 50 <= len(rest) <= 53  # at 100 Hz; then it is confirmed at once
    assert ("finished", "break/1") in events(path, "finished")


def test_the_menu_in_a_break_does_not_make_it_longer(monkeypatch, gpu, tmp_path):
    opened = []

    def own(panel):
        if getattr(panel, "title", "") == "A break" and not opened:
            opened.append(panel)
            return [Command("menu")]
        return None

    path = study(tmp_path, "[breaks]\nevery = 1\nseconds = 0.5")
    ran = run(monkeypatch, gpu, path, Person(own))
    assert ran.session.status == COMPLETE
    shown = [getattr(label, "title", "") for label in ran.display.labels]
    assert shown.count("A break") + shown.count("Menu") <= 55
    menu = next(panel for panel in ran.display.panels if getattr(panel, "title", "") == "Menu")
    assert "break" not in dict(menu.choices)


def test_a_late_command_does_not_answer_the_next_question(monkeypatch, gpu, path):
    given = iter([[Command("answer", 3.0), Command("answer", 4.0), Command("remark", "twice")]])
    console = ScriptedConsole(lambda state: next(given, ()) if state.phase == "asking" else ())
    ran = run(
        monkeypatch, gpu, path, Person(lambda panel: () if getattr(panel, "heading", "") == "trial 1" else None),
        console,
    )  # fmt: skip
    assert ran.session.status == COMPLETE
    assert [answer.value for answer in contents(path).answers] == [3.0, 2.0]
    assert ("remark", "trial/1/grade/grade") in events(path, "remark")
