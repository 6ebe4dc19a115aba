"""The menu, a text to agree to, a break: nothing by a slip, nothing lost, and every way the hands have leads there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.study.asking import AGAIN, BREAK, CONTINUE, SKIP, STOP, Menu, Reading, Resting

from .scales import said

LONG = "This study asks how good pictures are that come late. " * 40
commands = st.lists(
    st.one_of(
        st.sampled_from(said("left", "right", "up", "down", "confirm", "menu", "erase", ("digit", "3"), "quit")),
        st.tuples(st.sampled_from(["point", "press"]), st.tuples(st.floats(0, 1), st.floats(0, 1))).map(
            lambda one: said(one)[0]
        ),
    ),
    max_size=30,
)


def pressed(plate, name: str) -> tuple[float, float]:
    """The middle of that button, by trying."""
    found = [(u, v) for u in np.linspace(0, 1, 40) for v in np.linspace(0, 1, 120) if plate.button_at(u, v) == name]
    assert found, name
    return tuple(float(part) for part in np.mean(found, axis=0))


@pytest.mark.parametrize(("steps", "chosen"), [(0, CONTINUE), (1, BREAK), (2, AGAIN), (9, "")])
def test_steps_and_confirm_choose(steps, chosen):
    for forward in ("right", "down"):
        menu = Menu()
        menu.obey(said(*[forward] * steps, "confirm"))
        assert menu.chosen == chosen  # the last is the end, which is asked for twice


def test_the_end_is_asked_for_twice():
    menu = Menu()
    menu.obey(said("left", *["right"] * 3, "confirm"))
    assert menu.chosen == "" and menu.label().title == "Stop now?"
    menu.obey(said("confirm"))
    assert menu.chosen == "" and menu.label().title == "Menu"  # a second slip goes back
    menu.obey(said(*["down"] * 3, "confirm", "right", "confirm"))
    assert menu.chosen == STOP


def test_the_mouse_chooses():
    menu = Menu((CONTINUE, BREAK, SKIP, STOP))
    menu.obey(said(("point", pressed(menu.label(), SKIP))))
    assert menu.label().marked == 2 and menu.chosen == ""
    menu.obey(said(("press", (0.5, 0.999))))
    assert menu.chosen == ""  # beside the buttons
    menu.obey(said(("press", pressed(menu.label(), STOP))))
    menu.obey(said(("press", pressed(menu.label(), "yes"))))
    assert menu.chosen == STOP


@pytest.mark.parametrize("name", [CONTINUE, BREAK, AGAIN, STOP])
def test_the_desk_chooses_at_once_and_escape_goes_on(name):
    menu = Menu()
    menu.obey(said(name))
    assert menu.chosen == name
    menu = Menu()
    menu.obey(said("right", "menu"))
    assert menu.chosen == CONTINUE


def test_what_is_not_offered_is_not_chosen():
    menu = Menu((CONTINUE, STOP))
    menu.obey(said(AGAIN, "right", "right", "left"))
    assert menu.chosen == "" and menu.label().marked == 0


@given(commands)
def test_whatever_comes_the_menu_knows_what_it_is(sent):
    menu = Menu()
    for command in sent:
        before = menu.chosen
        menu.obey([command])
        assert menu.chosen in ("", CONTINUE, BREAK, AGAIN, STOP) and (not before or menu.chosen == before)
        assert 0 <= menu.label().marked < len(menu.label().choices)


def test_agreeing_is_chosen_by_nobody_beforehand():
    reading = Reading("A short text.")
    assert reading.label().marked is None
    reading.obey(said("confirm"))
    assert not reading.agreed and not reading.refused and "Choose one first" in reading.label().note
    reading.obey(said("right", "right", "confirm"))
    assert reading.agreed and not reading.refused


def test_not_agreeing_is_as_easy():
    reading = Reading("A short text.")
    reading.obey(said("right", "confirm"))
    assert reading.refused and not reading.agreed
    reading = Reading("A short text.")
    reading.obey(said(("press", pressed(reading.label(), "refuse"))))
    assert reading.refused


def test_a_long_text_is_agreed_to_on_its_last_page_alone():
    reading, seen, pages = Reading(LONG), "", 0
    while "agree" not in dict(reading.label().choices):
        seen += "".join(reading.label().lines)
        pages += 1
        assert reading.label().ink().shape == Reading(LONG).label().ink().shape  # no page jumps
        reading.obey(said("confirm"))
    seen += "".join(reading.label().lines)
    assert "".join(seen.split()) == "".join(LONG.split()) and pages >= 3
    assert reading.label().title == f"Before we begin ({pages + 1} of {pages + 1})"
    reading.obey(said(("press", pressed(reading.label(), "back")), "confirm"))
    assert not reading.agreed and "agree" in dict(reading.label().choices)  # back, and on again
    reading.obey(said("right", "right", "right", "confirm"))
    assert reading.agreed


def test_the_desk_agrees_for_the_participant():
    reading = Reading(LONG)
    reading.obey(said("agree"))
    assert reading.agreed


@given(commands)
def test_whatever_comes_nobody_agrees_without_a_word(sent):
    reading = Reading(LONG)
    for command in sent:
        last_page = "agree" in dict(reading.label().choices)
        was = reading.agreed or reading.refused
        reading.obey([command])
        assert not (reading.agreed and reading.refused)
        assert was or last_page or not (reading.agreed or reading.refused)


def test_a_break_lasts_as_long_as_it_is_to():
    now = [100.0]
    resting = Resting(75, lambda: now[0])
    assert "1:15" in resting.label().lines[0]
    resting.obey(said("confirm", "continue"))
    assert not resting.over
    plates = set()
    for now[0] in np.arange(100.0, 175.0, 0.1):
        plates.add(resting.label())
        assert resting.left_s > 0
    assert len(plates) == 75  # a new one each second, not each refresh
    now[0] = 175.0
    assert resting.left_s == 0 and "Enter" in resting.label().lines[0] and not resting.over  # as long as is wanted
    resting.obey(said("left", "menu"))
    assert not resting.over
    resting.obey(said("confirm"))
    assert resting.over


def test_a_pause_without_a_time_is_over_when_somebody_says_so():
    resting = Resting(0, lambda: 5.0)
    assert not resting.over
    resting.obey(said("continue"))
    assert resting.over
