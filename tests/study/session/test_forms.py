"""Questions with answers of their own: a choice, a number, words."""

from __future__ import annotations

import pytest
from together import together

from hmdwarp.display import Command
from hmdwarp.study.design import Ask, load_design
from hmdwarp.study.dialogs.choice_dialogs import TextDialog
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS, MessagePanel, QuestionPanel
from hmdwarp.study.export.export_rows import answer_rows
from hmdwarp.study.line_console import ConsoleState, checked_answer, parse_line
from hmdwarp.study.scales import load_scale
from hmdwarp.study.store import SIMULATED, Store, store_folder

from ..refusals import check_refused, table
from .sessions import Person, ScriptedConsole, contents, press, run, study

FORM = """
title = "About you"
kind = "questionnaire"
source = "made up"
[[item]]
key = "age"
text = "How old are you?"
answer = "number"
least = 18
most = 99
[[item]]
key = "hand"
text = "Which hand do you write with?"
answer = "choice"
choices = ["left", "right", "both"]
[[item]]
key = "notes"
text = "Anything else?"
answer = "text"
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "form.toml").write_text(FORM, encoding="utf-8")
    return study(tmp_path, '[questionnaires]\nbefore = ["form.toml"]\n')


def letters(text: str) -> list[Command]:
    return [Command("type", letter) for letter in text]


class Typist(Person):
    """Answers the form with 34, the second choice and some words."""

    def _usual(self, panel):
        if isinstance(panel, QuestionPanel) and panel.value is None and not panel.typed:
            if panel.text == "How old are you?":
                return [Command("digit", "3"), Command("digit", "4"), Command("confirm")]
            if "hand" in panel.text:
                return [Command("down"), Command("down"), Command("confirm")]
        if isinstance(panel, MessagePanel) and panel.takes_text and panel.lines == ("_",):
            return [*letters("x The picturre"), *[Command("erase")] * 2, *letters("e swims."), Command("confirm")]
        return super()._usual(panel)


def rows(path):
    return {row["item"]: row for row in answer_rows(contents(path), load_design(str(path))) if row["phase"] == "before"}


def test_people_answer_at_the_window(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, Typist())
    assert ran.error is None and ran.session.status == "complete"
    answers = {answer.item: answer for answer in contents(path).answers if answer.phase == "before"}
    assert (answers["age"].value, answers["hand"].value, answers["notes"].value) == (34, 2, None)
    assert (answers["age"].text, answers["notes"].text) == ("", "x The picture swims.")
    told = rows(path)
    assert [(told[key]["value"], told[key]["text"]) for key in ("age", "hand", "notes")] == [
        (34, None), (2, "right"), (None, "x The picture swims."),
    ]  # fmt: skip
    assert {row["why_missing"] for row in told.values()} == {None}
    assert any("x The picture swims." in line for line in ran.console.said)


def test_the_experimenter_types_spoken_words(monkeypatch, gpu, path):
    def asks(state):
        if state.question is None:
            return ()
        return [Command("answer", "too dark" if state.question.in_words else 20 if "old" in state.question.text else 1)]

    ran = run(monkeypatch, gpu, path, Person(lambda panel: () if isinstance(panel, QuestionPanel) else None),
              ScriptedConsole(asks))  # fmt: skip
    assert ran.error is None
    told = {answer.item: answer for answer in contents(path).answers}
    assert (told["notes"].text, told["notes"].by, told["hand"].value) == ("too dark", "experimenter", 1)


MODEL = """schema = 1
title = "people"
[rating.grade]
[rating.grade.means]
plainly-late = 4
spun-about = 3
"""


def test_simulated_participants_answer_too(monkeypatch, gpu, path, tmp_path):
    (tmp_path / "people.toml").write_text(MODEL, encoding="utf-8")
    ran = run(monkeypatch, gpu, path, Person(lambda panel: ()), simulate=str(tmp_path / "people.toml"), trace="walk")
    assert ran.error is None and ran.session.status == "complete"
    with Store(store_folder(load_design(str(path)), None, SIMULATED)) as store:
        told = {answer.item: answer for answer in store.contents().answers if answer.phase == "before"}
    assert 18 <= told["age"].value <= 99 and told["hand"].value in (1, 2, 3) and told["notes"].text


def dialog(hints=None):
    scale = load_scale("comments")
    ask = Ask("after/comments/comments", scale, scale.items[0], "after")
    return TextDialog(ask) if hints is None else TextDialog(ask, hints)


def test_an_empty_answer_is_not_confirmed_and_no_answer_is_a_choice():
    asked = dialog()
    asked.handle([Command("confirm"), *letters("  "), Command("confirm")])
    assert not asked.over and "no answer" in asked.panel().note
    asked.handle([press(asked.panel(), "none")])
    assert asked.over and asked.text == ""


def test_in_a_headset_the_words_are_said():
    asked = dialog(CONTROLLERS)
    assert not asked.panel().takes_text and "Say it aloud" in " ".join(asked.panel().lines)
    question = asked.question()
    assert question.in_words and checked_answer(" too dark ", question) == "too dark"
    state = ConsoleState(phase="asking", question=question)
    assert parse_line("answer 7 of them", state) == ("answer", "7 of them")
    with pytest.raises(ValueError, match="in words"):
        parse_line("answer", state)


WRONG = r"""
choices = ["left", "right", "both"] -> choices = ["left"] => 2 to 12 different texts
choices = ["left", "right", "both"] -> choices = ["left", "left"] => 2 to 12 different texts
answer = "text" -> answer = "words" => answer
most = 99 -> most = 3 => expected more than
answer = "text" ->  => answer @ ⏎title
kind = "questionnaire" -> kind = "rating" => is for kind questionnaire @ answer
answer = "text" -> answer = "text"⏎»choices = ["a", "b"] => choices
"""


@together("entry", table(WRONG))
def test_an_impossible_question_is_refused_with_its_line(tmp_path, entry):
    file = tmp_path / "form.toml"
    check_refused(entry, FORM, lambda wrong: file.write_text(wrong, encoding="utf-8") and load_scale(str(file)), file)
