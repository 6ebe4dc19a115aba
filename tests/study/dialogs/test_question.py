"""A question. Nothing is chosen beforehand, every value can be chosen in every way, nothing else
can, and what is confirmed stays.
"""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS
from hmdwarp.study.dialogs.question_dialog import QuestionDialog
from hmdwarp.study.scales import load_scale, number_text

from .made_scales import SHIPPED, any_scale, asked_of, said

places = st.tuples(st.floats(0, 1), st.floats(0, 1))
anything = st.one_of(
    st.sampled_from(
        said("left", "right", "up", "down", "erase", "confirm", "skip", "menu", "full_screen", "agree", "no such")
    ),
    st.sampled_from(list("0123456789.,")).map(lambda key: said(("digit", key))[0]),
    st.tuples(st.sampled_from(["point", "press"]), places).map(lambda one: said(one)[0]),
    st.one_of(st.floats(), st.integers(-200, 200), st.none()).map(lambda number: said(("answer", number))[0]),
)


@given(any_scale, st.lists(anything, max_size=40))
def test_any_input_gives_an_answer_of_the_scale_or_none(scale, commands):
    asked, values = asked_of(scale), set(scale.values())
    for command in commands:
        before = (asked.confirmed, asked.skipped, asked.value)
        asked.handle([command])
        assert asked.value is None or asked.value in values
        assert not before[0] or (asked.confirmed, asked.skipped, asked.value) == before  # confirmed once and for all
        assert asked.confirmed or not asked.skipped
        assert not asked.confirmed or (asked.value is None) == asked.skipped
        assert asked.question().entered == asked.value


@pytest.mark.parametrize("scale", SHIPPED, ids=lambda one: one.name)
def test_no_answer_is_preselected_and_an_empty_one_is_not_confirmed(scale):
    asked = asked_of(scale)
    assert asked.value is None and asked.panel().value is None
    asked.handle(said("confirm"))
    assert not asked.confirmed and "Choose an answer first" in asked.note
    assert asked.panel().note == asked.note


@given(any_scale, st.data())
def test_every_value_can_be_stepped_to(scale, data):
    values = scale.values()
    wanted, asked = data.draw(st.sampled_from(values)), asked_of(scale)
    asked.handle(said("right"))
    assert asked.value == values[len(values) // 2]
    asked.handle(said(*["left"] * len(values)))
    assert asked.value == values[0]  # and no further
    asked.handle(said(*["right"] * values.index(wanted), "confirm"))
    assert (asked.value, asked.confirmed) == (wanted, True)


def test_the_first_step_favours_no_side():
    for first, wanted in (("left", 1), ("right", 2)):  # of 0, 1, 2, 3
        asked = asked_of(load_scale("ssq"))
        asked.handle(said(first))
        assert asked.value == wanted


@given(any_scale, st.data())
def test_every_value_can_be_typed(scale, data):
    wanted = data.draw(st.sampled_from([value for value in scale.values() if value >= 0] or [None]))
    if wanted is None:
        return  # digits have no sign; such values are stepped to, or pointed at
    asked = asked_of(scale)
    comma = data.draw(st.booleans())
    asked.handle(said(*(("digit", "," if comma and key == "." else key) for key in number_text(wanted)), "confirm"))
    assert (asked.value, asked.confirmed) == (wanted, True)


@pytest.mark.parametrize(
    ("typed", "value", "shown"),
    [("3", 3, "3"), ("3.", 3, "3."), ("3,2", None, "3.2"), ("3.25", 3.25, "3.25"), ("3.50", 3.5, "3.50"),
     ("15", 5, "5"), ("9", None, ""),
     ("39", 3, "3"), ("3.3", 3, "3."), ("..", None, ""), ("6.25", 6, "6."), ("0", None, ""), ("12.5", 2.5, "2.5")],
)  # fmt: skip
def test_typing_on_a_scale_of_grades(typed, value, shown):
    """A digit that leads nowhere begins anew before the point, if it can; else it is not there."""
    asked = asked_of(load_scale("grade"))
    asked.handle(said(*(("digit", key) for key in typed)))
    assert (asked.value, asked.panel().typed) == (value, shown)


def test_a_number_half_typed_is_no_answer_and_says_so():
    asked = asked_of(load_scale("grade"))
    asked.handle(said(("digit", "3"), ("digit", "."), ("digit", "2"), "confirm"))
    assert not asked.confirmed
    assert asked.note == "3.2 is no answer here: expected 1 to 6 in steps of 0.25"
    asked.handle(said("erase", "erase"))
    assert (asked.value, asked.note) == (3, "")
    asked.handle(said("erase"))
    assert asked.value is None
    asked.handle(said("right", "erase"))
    assert asked.value is None  # what was not typed goes as a whole


@pytest.mark.parametrize("number", [0.75, 6.25, 3.1, math.nan, math.inf, -math.inf, "3", True, [3]])
def test_an_answer_that_is_none_is_refused_in_words(number):
    asked = asked_of(load_scale("grade"))
    asked.handle(said(("answer", number)))
    assert not asked.confirmed and asked.value is None
    assert asked.note.endswith("is no answer here: expected 1 to 6 in steps of 0.25")


@given(any_scale, st.data())
def test_console_and_respondents_answer_at_once(scale, data):
    wanted, asked = data.draw(st.sampled_from(scale.values())), asked_of(scale)
    asked.handle(said(("answer", wanted)))
    assert (asked.value, asked.confirmed, asked.skipped) == (wanted, True, False)


def test_a_note_goes_after_a_while():
    now = [0.0]
    asked = asked_of(load_scale("acr"), now_s=lambda: now[0])
    asked.handle(said("confirm"))
    assert asked.note
    now[0] = 4.9
    assert asked.note
    now[0] = 5.1
    assert not asked.note


@pytest.mark.parametrize("last", [["confirm"], ["skip"], ["menu", "confirm"]])
def test_cannot_say_wants_a_second_word(last):
    asked = asked_of(load_scale("grade"))
    asked.handle(said("right", "skip"))
    assert not asked.confirmed and asked.panel().skipping
    asked.handle(said(*last))
    assert asked.confirmed and asked.skipped and asked.value is None


def test_cannot_say_can_be_taken_back_and_loses_nothing():
    for back in ("left", "right", "erase"):
        asked = asked_of(load_scale("grade"))
        asked.handle(said("right", "skip", back))
        assert not asked.panel().skipping and asked.value == 3.5
    asked = asked_of(load_scale("grade"))
    asked.handle(said("skip", ("answer", None)))
    assert asked.skipped


def test_up_is_more_on_a_line_and_further_up_in_a_list():
    for name, wanted in (("grade", 3.75), ("misc", 4)):
        asked = asked_of(load_scale(name))
        asked.handle(said("right", "up"))
        assert asked.value == wanted


def test_a_mouse_that_is_pushed_does_not_change_what_was_typed_and_a_click_does():
    asked = asked_of(load_scale("grade"))
    panel = asked.panel()
    places = [(u / 100, v / 100) for u in range(5, 96, 5) for v in range(5, 96, 5)]
    there = next(place for place in places if panel.value_at(*place) == 4.0)
    asked.handle(said(("digit", "2"), ("point", there)))
    assert asked.value == 2.0
    asked.handle(said("erase", ("point", there)))
    assert asked.value == 4.0
    asked.handle(said(("digit", "2"), ("press", there)))
    assert asked.confirmed and asked.value == 4.0


def test_the_panel_tells_no_condition_and_which_item_it_is():
    ssq = load_scale("ssq")
    assert asked_of(ssq).panel().heading.endswith("item 1 of 16\nHow much does this affect you right now?")
    assert asked_of(load_scale("grade")).panel().heading == "trial 1"
    grade = load_scale("grade")
    again = QuestionDialog(Ask("trial/1/grade", grade, grade.items[0], "trial", 1), lambda: 0.0, again=True)
    assert again.panel().heading == "trial 1, once more"
    assert "Enter" not in str(asked_of(ssq, CONTROLLERS).panel().hints)
