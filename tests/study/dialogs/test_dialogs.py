"""Dialogs. Nothing by a slip, nothing lost, and every way the hands have leads there.

No answer is chosen beforehand, every one can be in every way, and what is confirmed stays.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.choice_dialogs import (
    AGAIN,
    BREAK,
    CONTINUE,
    STOP,
    BreakDialog,
    ConsentDialog,
    MenuDialog,
    TextDialog,
)
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS
from hmdwarp.study.dialogs.question_dialog import QuestionDialog
from hmdwarp.study.scales import load_scale, number_text

from .made_scales import SHIPPED, any_scale, asked_of, place_of, said

FILE = Path(__file__).with_name("asked.txt")
LONG = "This study asks how good pictures are that come late. " * 40
KEYS = said("left", "right", "up", "down", "confirm", "menu", "erase", ("digit", "3"), "quit")
POINTED = st.tuples(st.sampled_from(["point", "press"]), st.tuples(st.floats(0, 1), st.floats(0, 1)))
commands = st.lists(st.one_of(st.sampled_from(KEYS), POINTED.map(lambda one: said(one)[0])), max_size=30)


@given(commands)
def test_any_input_leaves_the_menu_consistent(sent):
    menu = MenuDialog()
    for command in sent:
        before = menu.chosen
        menu.handle([command])
        assert menu.chosen in ("", CONTINUE, BREAK, AGAIN, STOP) and (not before or menu.chosen == before)
        assert 0 <= menu.panel().marked < len(menu.panel().choices)


def dialog(name: str) -> object:
    made = {
        "menu": MenuDialog,
        "consent": lambda: ConsentDialog("A short text."),
        "long consent": lambda: ConsentDialog(LONG),
    }
    if name == "words":
        scale = load_scale("comments")
        return TextDialog(Ask("after/comments/comments", scale, scale.items[0], "after"))
    return made[name]() if name in made else asked_of(load_scale(name))


def came_of(line: str) -> str:
    """What a dialog is after digits, `=value` of the console, `press:button`, or commands."""
    name, _, words = line.partition(": ")
    asked = dialog(name)
    for word in words.split():
        if word[0] in "0123456789.,":
            asked.handle(said(*(("digit", key) for key in word)))
        elif word[0] == "=":
            asked.handle(said(("answer", None if word == "=none" else float(word[1:]))))
        elif word.startswith("press:"):
            asked.handle(said(("press", place_of(asked.panel(), word[6:]))))
        else:
            asked.handle(said((word, "x") if word == "type" else word))
    states = ("value", "text", "chosen", "agreed", "refused", "confirmed", "skipped", "over", "note")
    of_panel = ("title", "heading", "typed", "skipping", "marked", "lines", "note")
    found = {name: getattr(asked, name, None) for name in states}
    found |= {f"panel.{name}": getattr(asked.panel(), name, None) for name in of_panel}
    told = {key: value for key, value in found.items() if value is not False and value not in (None, "", ())}
    return ", ".join(f"{key} {value!r}" for key, value in told.items()) or "nothing"


def test_what_comes_of_commands_is_what_came():
    """asked.txt; HMDWARP_GOLDEN=write writes it anew: look at the difference."""
    lines = FILE.read_text(encoding="utf-8").splitlines()
    asked = [line.partition(" => ")[0] for line in lines]
    found = [line if line.startswith("#") else f"{line} => {came_of(line)}" for line in asked]
    if os.environ.get("HMDWARP_GOLDEN") == "write":
        FILE.write_text("\n".join(found) + "\n", encoding="utf-8")
        lines = found
    assert found == lines


def is_last(reading: ConsentDialog) -> bool:
    return "agree" in dict(reading.panel().choices)


def test_a_long_text_is_agreed_to_on_its_last_page_alone():
    reading, seen, pages = ConsentDialog(LONG), "", 0
    while not is_last(reading):
        seen += "".join(reading.panel().lines)
        pages += 1
        assert reading.panel().ink().shape == ConsentDialog(LONG).panel().ink().shape  # no page jumps
        reading.handle(said("confirm"))
    seen += "".join(reading.panel().lines)
    assert "".join(seen.split()) == "".join(LONG.split()) and pages >= 3
    assert reading.panel().title == f"Before we begin ({pages + 1} of {pages + 1})"
    reading.handle(said(("press", place_of(reading.panel(), "back")), "confirm"))
    assert not reading.agreed and is_last(reading)  # back, and on again
    reading.handle(said("right", "confirm"))
    assert reading.agreed


@given(commands)
def test_no_input_but_an_agreement_agrees(sent):
    reading = ConsentDialog(LONG)
    for command in sent:
        last_page = is_last(reading) or reading.panel().title == "End without taking part?"
        was = reading.agreed or reading.refused
        reading.handle([command])
        assert not (reading.agreed and reading.refused)
        assert was or last_page or not (reading.agreed or reading.refused)


def test_a_break_lasts_as_long_as_it_is_to():
    now = [100.0]
    resting = BreakDialog(75, lambda: now[0])
    assert "1:15" in resting.panel().lines[0]
    resting.handle(said("confirm", "continue"))
    assert not resting.over
    panels = set()
    for now[0] in np.arange(100.0, 175.0, 0.1):
        panels.add(resting.panel())
        assert resting.left_s > 0
    assert len(panels) == 75  # a new one each second, not each refresh
    now[0] = 175.0
    assert resting.left_s == 0 and "Enter" in resting.panel().lines[0] and not resting.over  # as long as is wanted
    resting.handle(said("left", "menu"))
    assert not resting.over
    resting.handle(said("confirm"))
    assert resting.over
    pause = BreakDialog(0, lambda: 5.0)  # without a time
    assert not pause.over
    pause.handle(said("continue"))
    assert pause.over


GRADE = load_scale("grade")
QUESTION_KEYS = said(
    "left", "right", "up", "down", "erase", "confirm", "skip", "menu", "full_screen", "agree", "no such"
)
places = st.tuples(st.floats(0, 1), st.floats(0, 1))
anything = st.one_of(
    st.sampled_from(QUESTION_KEYS),
    st.sampled_from(list("0123456789.,")).map(lambda key: said(("digit", key))[0]),
    st.tuples(st.sampled_from(["point", "press"]), places).map(lambda one: said(one)[0]),
    st.one_of(st.floats(), st.integers(-200, 200), st.none()).map(lambda number: said(("answer", number))[0]),
)


def asked(*commands, typed: str = "") -> QuestionDialog:
    """A question of grades after these digits and commands."""
    question = asked_of(GRADE)
    question.handle(said(*(("digit", key) for key in typed), *commands))
    return question


@given(any_scale, st.lists(anything, max_size=40))
def test_any_input_gives_an_answer_of_the_scale_or_none(scale, commands):
    one, values = asked_of(scale), set(scale.values())
    for command in commands:
        before = (one.confirmed, one.skipped, one.value)
        one.handle([command])
        assert one.value is None or one.value in values
        assert not before[0] or (one.confirmed, one.skipped, one.value) == before  # confirmed once and for all
        assert one.confirmed or not one.skipped
        assert not one.confirmed or (one.value is None) == one.skipped
        assert one.question().entered == one.value


@together("scale", SHIPPED)
def test_no_answer_is_preselected_and_an_empty_one_is_not_confirmed(scale):
    one = asked_of(scale)
    assert one.value is None and one.panel().value is None
    one.handle(said("confirm"))
    assert not one.confirmed and "Choose an answer first" in one.note
    assert one.panel().note == one.note


@together("number", ["3", True, [3], -math.inf])
def test_an_answer_that_is_none_is_refused(number):
    one = asked(("answer", number))
    assert not one.confirmed and one.value is None and "no answer here" in one.note


@given(any_scale, st.data())
def test_every_value_can_be_stepped_to_typed_and_answered_at_once(scale, data):
    values = scale.values()
    wanted, one = data.draw(st.sampled_from(values)), asked_of(scale)
    one.handle(said("right"))
    assert one.value == values[len(values) // 2]
    one.handle(said(*["left"] * len(values)))
    assert one.value == values[0]  # and no further
    one.handle(said(*["right"] * values.index(wanted), "confirm"))
    answered, typed = asked_of(scale), asked_of(scale)
    answered.handle(said(("answer", wanted)))  # console and respondents
    point = data.draw(st.sampled_from(".,"))
    typed.handle(said(*(("digit", point if key == "." else key) for key in number_text(wanted)), "confirm"))
    for each in (one, answered, typed)[: 3 if wanted >= 0 else 2]:  # digits have no sign
        assert (each.value, each.confirmed, each.skipped) == (wanted, True, False)


def test_a_note_goes_after_a_while():
    now = [0.0]
    one = asked_of(load_scale("acr"), now_s=lambda: now[0])
    one.handle(said("confirm"))
    for now[0], there in ((0.0, True), (4.9, True), (5.1, False)):
        assert bool(one.note) == there


def test_a_mouse_that_is_pushed_does_not_change_what_was_typed_and_a_click_does():
    panel = asked().panel()
    there = next(
        (u / 100, v / 100) for u in range(5, 96, 5) for v in range(5, 96, 5) if panel.value_at(u / 100, v / 100) == 4.0
    )
    one = asked(("point", there), typed="2")
    assert one.value == 2.0
    one.handle(said("erase", ("point", there)))
    assert one.value == 4.0
    one.handle(said(("digit", "2"), ("press", there)))
    assert one.confirmed and one.value == 4.0


def test_the_panel_tells_no_condition_and_which_item_it_is():
    ssq = load_scale("ssq")
    assert asked_of(ssq).panel().heading.endswith("item 1 of 16\nHow much does this affect you right now?")
    assert asked().panel().heading == "trial 1"
    again = QuestionDialog(Ask("trial/1/grade", GRADE, GRADE.items[0], "trial", 1), lambda: 0.0, again=True)
    assert again.panel().heading == "trial 1, once more"
    assert "Enter" not in str(asked_of(ssq, CONTROLLERS).panel().hints)
