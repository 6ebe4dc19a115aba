"""The menu, a text to agree to, a break.

Nothing by a slip, nothing lost, and every way the hands have leads there.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.study.dialogs.choice_dialogs import (
    AGAIN,
    BREAK,
    CONTINUE,
    SKIP,
    STOP,
    BreakDialog,
    ConsentDialog,
    MenuDialog,
)

from .made_scales import place_of, said

LONG = "This study asks how good pictures are that come late. " * 40
KEYS = said("left", "right", "up", "down", "confirm", "menu", "erase", ("digit", "3"), "quit")
POINTED = st.tuples(st.sampled_from(["point", "press"]), st.tuples(st.floats(0, 1), st.floats(0, 1)))
commands = st.lists(st.one_of(st.sampled_from(KEYS), POINTED.map(lambda one: said(one)[0])), max_size=30)

CHOSEN = [  # what is asked for, what is chosen
    ("confirm", CONTINUE),
    ("right confirm", BREAK),
    ("down right confirm", AGAIN),
    ("right right right right right confirm", ""),  # the last is the end, which is asked for twice
    ("down down down confirm right confirm", STOP),
    ("right right right confirm confirm", ""),  # a second slip goes back
    ("right menu", CONTINUE),
    *((name, name) for name in (CONTINUE, BREAK, AGAIN, STOP)),  # of the experimenter
    (SKIP, ""),  # is not offered
]


@together("asked, chosen", CHOSEN)
def test_the_menu_chooses(asked, chosen):
    menu = MenuDialog()
    menu.handle(said(*asked.split()))
    assert menu.chosen == chosen


def test_the_mouse_chooses():
    menu = MenuDialog((CONTINUE, BREAK, SKIP, STOP))
    menu.handle(said(("point", place_of(menu.panel(), SKIP))))
    assert menu.panel().marked == 2 and menu.chosen == ""
    menu.handle(said(("press", (0.5, 0.999))))
    assert menu.chosen == ""  # beside the buttons
    menu.handle(said(("press", place_of(menu.panel(), STOP))))
    menu.handle(said(("press", place_of(menu.panel(), "yes"))))
    assert menu.chosen == STOP


@given(commands)
def test_any_input_leaves_the_menu_consistent(sent):
    menu = MenuDialog()
    for command in sent:
        before = menu.chosen
        menu.handle([command])
        assert menu.chosen in ("", CONTINUE, BREAK, AGAIN, STOP) and (not before or menu.chosen == before)
        assert 0 <= menu.panel().marked < len(menu.panel().choices)


def is_last(reading: ConsentDialog) -> bool:
    return "agree" in dict(reading.panel().choices)


def test_agreement_is_not_preselected_and_the_arrows_choose_the_button_on_their_side():
    for text in ("A short text.", LONG):
        for key, place in (("left", 0), ("right", -1)):
            reading = ConsentDialog(text)
            while not is_last(reading):
                reading.handle(said("confirm"))
            assert reading.panel().marked is None
            reading.handle(said("confirm"))
            assert not reading.agreed and not reading.refused and "Choose one first" in reading.panel().note
            reading.handle(said(key))
            panel = reading.panel()
            assert panel.choices[panel.marked] == panel.choices[place]
            assert panel.choices[-1][0] == "agree"
            reading.handle(said("confirm"))
            assert reading.agreed == (key == "right") and not reading.refused


def test_not_agreeing_is_as_easy_and_confirmed_once():
    """What ends the session may have been a slip."""
    reading = ConsentDialog("A short text.")
    reading.handle(said("left", "confirm"))
    assert not reading.over and reading.panel().title == "End without taking part?"
    reading.handle(said("confirm"))  # a second slip goes back to the text
    assert not reading.over and reading.panel().marked is None and is_last(reading)
    reading.handle(said("left", "confirm", "right", "confirm"))
    assert reading.refused and not reading.agreed
    reading = ConsentDialog("A short text.")
    reading.handle(said(("press", place_of(reading.panel(), "refuse"))))
    reading.handle(said(("press", place_of(reading.panel(), "yes"))))
    assert reading.refused


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


@together("command, agrees", [("agree", True), ("decline", False)])
def test_the_experimenter_agrees_or_declines_for_the_participant(command, agrees):
    reading = ConsentDialog(LONG)
    reading.handle(said(command))
    assert (reading.agreed, reading.refused) == (agrees, not agrees)


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
