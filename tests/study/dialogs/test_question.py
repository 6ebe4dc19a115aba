"""A question. Nothing is chosen beforehand, every value can be chosen in every way, nothing else
can, and what is confirmed stays.
"""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS
from hmdwarp.study.dialogs.question_dialog import QuestionDialog
from hmdwarp.study.scales import load_scale, number_text

from .made_scales import SHIPPED, any_scale, asked_of, said

GRADE = load_scale("grade")
KEYS = said("left", "right", "up", "down", "erase", "confirm", "skip", "menu", "full_screen", "agree", "no such")
places = st.tuples(st.floats(0, 1), st.floats(0, 1))
anything = st.one_of(
    st.sampled_from(KEYS),
    st.sampled_from(list("0123456789.,")).map(lambda key: said(("digit", key))[0]),
    st.tuples(st.sampled_from(["point", "press"]), places).map(lambda one: said(one)[0]),
    st.one_of(st.floats(), st.integers(-200, 200), st.none()).map(lambda number: said(("answer", number))[0]),
)


def asked(*commands, name: str = "grade", typed: str = "") -> QuestionDialog:
    """A question after these digits and commands."""
    question = asked_of(load_scale(name))
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


TYPED = [
    ("3", 3, "3"), ("3.", 3, "3."), ("3,2", None, "3.2"), ("3.25", 3.25, "3.25"), ("3.50", 3.5, "3.50"),
    ("15", 5, "5"), ("9", None, ""), ("39", 3, "3"), ("3.3", 3, "3."), ("..", None, ""), ("6.25", 6, "6."),
    ("0", None, ""), ("12.5", 2.5, "2.5"),
]  # fmt: skip


@together("typed, value, shown", TYPED)
def test_typing_on_a_scale_of_grades(typed, value, shown):
    """A digit that leads nowhere begins anew before the point, if it can; else it is not there."""
    one = asked(typed=typed)
    assert (one.value, one.panel().typed) == (value, shown)


def test_a_number_half_typed_is_no_answer_and_says_so():
    one = asked("confirm", typed="3.2")
    assert not one.confirmed
    assert one.note == "3.2 is no answer here: expected 1 to 6 in steps of 0.25"
    one.handle(said("erase", "erase"))
    assert (one.value, one.note) == (3, "")
    one.handle(said("erase"))
    assert one.value is None
    one.handle(said("right", "erase"))
    assert one.value is None  # what was not typed goes as a whole


@together("number", [0.75, 6.25, 3.1, math.nan, math.inf, -math.inf, "3", True, [3]])
def test_an_answer_that_is_none_is_refused_in_words(number):
    one = asked(("answer", number))
    assert not one.confirmed and one.value is None
    assert one.note.endswith("is no answer here: expected 1 to 6 in steps of 0.25")


def test_a_note_goes_after_a_while():
    now = [0.0]
    one = asked_of(load_scale("acr"), now_s=lambda: now[0])
    one.handle(said("confirm"))
    for now[0], there in ((0.0, True), (4.9, True), (5.1, False)):
        assert bool(one.note) == there


@together("last", [["confirm"], ["skip"], ["menu", "confirm"], [("answer", None)]])
def test_cannot_say_wants_a_second_word(last):
    one = asked("right", "skip")
    assert not one.confirmed and one.panel().skipping
    one.handle(said(*last))
    assert one.confirmed and one.skipped and one.value is None


STEPPED = [  # what is asked of which scale, and the value
    ("ssq", ("left",), 1),  # of 0, 1, 2, 3: the first step favours no side
    ("ssq", ("right",), 2),
    ("grade", ("right", "up"), 3.75),  # up is more on a line, and further up in a list
    ("misc", ("right", "up"), 4),
    *(("grade", ("right", "skip", back), 3.5) for back in ("left", "right", "erase")),  # "cannot say" is taken back
]


@together("name, commands, value", STEPPED)
def test_steps_lead_where_they_should(name, commands, value):
    one = asked(*commands, name=name)
    assert one.value == value and not one.panel().skipping


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
