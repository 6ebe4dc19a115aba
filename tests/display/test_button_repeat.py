"""Buttons and sticks to what they ask for, without any runtime; and the table of controllers.

Every kind can do all there is to do.
"""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.display.openxr.actions import (
    ACTS,
    AIM,
    AXES,
    BUTTONS,
    FIRST_NS,
    LET_GO,
    NEXT_NS,
    PROFILES,
    PUSHED,
    ButtonRepeat,
)
from hmdwarp.study.dialogs.dialog_panels import CONTROLS

PERIOD_NS = 11_111_111  # 90 a second


class Hands:
    """Each call is a refresh later, and at first nothing is pressed."""

    def __init__(self) -> None:
        self.repeat, self._now_ns = ButtonRepeat(), 0
        self.are()

    def are(self, seconds: float = 0.0, **states: float) -> list[str]:
        """So, for one refresh or for some seconds; what was asked for."""
        asked = []
        for _ in range(max(1, round(seconds * 1e9 / PERIOD_NS))):
            self._now_ns += PERIOD_NS
            buttons = {name: bool(state) for name, state in states.items() if name in BUTTONS}
            axes = {name: state for name, state in states.items() if name in AXES}
            asked += self.repeat.step(buttons, axes, self._now_ns)
        return asked


def test_a_button_counts_once_however_long_it_is_held_and_a_direction_goes_on():
    hands, seconds = Hands(), 2.0
    for name in ("confirm", "menu"):
        assert [hands.are(5.0, **{name: 1}), hands.are(), hands.are(**{name: 1})] == [[name], [], [name]]
    expected = 1 + 1 + int((seconds * 1e9 - FIRST_NS) / NEXT_NS)
    asked = hands.are(seconds, right=1)
    # Steps fall on refreshes: each comes up to one late.
    assert set(asked) == {"right"} and 0.85 * expected <= len(asked) <= expected
    assert hands.are(1.0) == []
    assert hands.are(0.3, right=1) == ["right"]  # a short press is one step


def test_after_a_stall_one_step_comes_and_not_many():
    repeat = ButtonRepeat()
    repeat.step({}, {}, 0)
    at_ns = (1, 10_000_000_000, 10_000_000_001)
    assert [repeat.step({"left": True}, {}, now_ns) for now_ns in at_ns] == [["left"], ["left"], []]


@pytest.mark.parametrize(("axis", "least", "most"), [("across", "left", "right"), ("along", "down", "up")])
def test_a_stick_is_pushed_and_let_go(axis, least, most):
    for sign, name in ((-1, least), (1, most)):
        # The fourth pushes a stick that trembled and was never let go.
        pushes = (
            (PUSHED - 0.01, []),
            (PUSHED, [name]),
            (LET_GO + 0.01, []),
            (0.9, []),
            (LET_GO - 0.01, []),
            (0.9, [name]),
        )
        hands = Hands()
        assert [hands.are(**{axis: sign * push}) for push, _ in pushes] == [asked for _, asked in pushes]


def test_a_stick_pushed_askew_means_one_direction_and_a_pad_counts_while_it_is_pressed():
    assert Hands().are(across=0.9, along=0.7) == ["right"]
    assert Hands().are(across=-0.7, along=0.9) == ["up"]
    hands = Hands()
    assert hands.are(1.0, pad_across=-1.0) == []  # a thumb rests on it
    assert hands.are(pad_across=-1.0, pad=1) == ["left"]
    assert hands.are(pad_across=-1.0) == []
    assert hands.are(pad_along=0.8, pad=1) == ["up"]


def test_a_button_down_at_the_start_counts_after_its_release():
    """And one that was down while the runtime's own menu was over it, say."""
    hands = Hands()
    for _ in range(2):
        hands.repeat.forget()
        assert hands.are(2.0, confirm=1, right=1, along=1.0) == []
        assert [hands.are(), hands.are(confirm=1)] == [[], ["confirm"]]


@given(st.lists(st.tuples(st.sampled_from(BUTTONS), st.floats(-1, 1), st.floats(-1, 1)), max_size=60))
def test_never_more_than_was_done(states):
    """A name is asked for at most once a refresh, and nothing but names there are."""
    hands = Hands()
    for button, across, along in states:
        asked = hands.are(across=across, along=along, **{button: 1})
        assert len(set(asked)) == len(asked) and set(asked) <= set(BUTTONS) - {"pad"}


@pytest.mark.parametrize("profile", PROFILES, ids=lambda one: one.rpartition("/")[2])
def test_every_kind_of_controller_can_do_everything(profile):
    assert re.fullmatch(r"/interaction_profiles/\w+/\w+", profile)
    names = {name for name, _ in PROFILES[profile]}
    acts = {AIM, *ACTS} if "/gamepad/" not in PROFILES[profile][0][1] else set()  # it is in no hand that aims
    assert acts <= names <= {*BUTTONS, *AXES, *acts}
    assert {"confirm", "menu"} <= names
    assert {"left", "right"} <= names or "across" in names or {"pad_across", "pad"} <= names
    # What answers questions acts in a scene too, which no question lies over.
    for which in (acts, {*BUTTONS, *AXES}):
        paths = [path for name, path in PROFILES[profile] if name in which]
        assert len(set(paths)) == len(paths), "one path, one thing"
    form = r"/user/(hand/(left|right)|gamepad)/input/\w+/(click|value|force|pose|x|y)"
    assert all(re.fullmatch(form, path) for _, path in PROFILES[profile])


def test_the_controls_of_a_study_are_what_controllers_can_do():
    assert {button for control in CONTROLS for button in control.buttons} == set(BUTTONS) - {"pad"}
