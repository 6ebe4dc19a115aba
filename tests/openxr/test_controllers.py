"""Controllers of a real runtime: what is pressed becomes commands, once; after a reconnection too."""

from __future__ import annotations

import pytest

from hmdwarp.display import Command, DisplayOptions, Lost
from hmdwarp.display.controls import CONTROLS
from hmdwarp.display.openxr import OpenXrDisplay
from hmdwarp.display.openxr.session import State
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs import CONTROLLERS, MessagePanel, QuestionDialog
from hmdwarp.study.dialogs import CONTROLS as STUDY_CONTROLS
from hmdwarp.study.scales import load_scale

from .live_runs import SMALL
from .remote_head import RemoteHead

pytestmark = pytest.mark.usefixtures("no_screen")


class Hands:
    """The display and both controllers, which are there from now on."""

    def __init__(self, display: OpenXrDisplay, remote: RemoteHead) -> None:
        self.display, self._remote = display, remote
        for hand in ("left", "right"):
            remote.hold(hand)
        self.frames(3)

    def hold(self, hand: str, frames: int = 8, **states: float) -> list[str]:
        """So for some frames, at 20 a second; the names of what was asked for."""
        self._remote.hold(hand, **states)
        return [command.control for command in self.frames(frames)]

    def press(self, hand: str, **states: float) -> list[str]:
        """For some frames, and let go again."""
        pressed = self.hold(hand, **states)
        return pressed + self.hold(hand, **dict.fromkeys(states, 0))

    def frames(self, count: int, label: MessagePanel | str = "") -> list[Command]:
        asked: list[Command] = []
        while count:
            if self.display.wait() is not None:
                self.display.show(None, label)
                count -= 1
            asked += self.display.commands()
        return asked


@pytest.fixture
def display(monado):
    made = OpenXrDisplay(DisplayOptions(size=SMALL, controls=STUDY_CONTROLS))
    yield made
    made.close()


@pytest.fixture
def hands(display, remote_head):
    return Hands(display, remote_head)


def test_every_kind_of_controller_is_known_by_these_names(display):
    """A single wrong path in the table would have the whole kind refused."""
    assert display._connection.actions.refused == []


def test_each_button_is_one_command(hands):
    assert hands.press("right", trigger_click=1, trigger_value=1) == ["confirm"]
    assert hands.press("left", trigger_click=1, trigger_value=1) == ["confirm"]
    assert hands.press("right", a_click=1) == ["confirm"]
    assert hands.press("left", b_click=1) == ["menu"]
    assert hands.press("right", b_click=1) == ["menu"]
    assert hands.press("left", system_click=1) == []  # the runtime's


def test_the_stick_steps_and_goes_on(hands):
    assert hands.press("left", thumbstick_x=0.3) == []
    assert hands.hold("left", frames=4, thumbstick_x=-1) == ["left"]
    on = hands.hold("left", frames=24)  # over a second more: a step each eighth of a second or so after the first half
    assert set(on) == {"left"} and 3 <= len(on) <= 10
    assert hands.hold("left", thumbstick_x=0) == []
    assert hands.hold("right", frames=4, thumbstick_y=1) == ["up"]
    assert hands.hold("right", frames=4, thumbstick_x=0.9, thumbstick_y=0) == ["right"]


def test_a_question_is_answered_by_hand(hands):
    scale = load_scale("acr")
    asked = QuestionDialog(Ask("trial/1/acr/quality", scale, scale.items[0], "trial", 1), lambda: 0.0, CONTROLLERS)

    def seen(name: str, **states: float) -> None:
        hands._remote.hold("right", **states)
        asked.handle(hands.frames(4, asked.panel()))
        hands._remote.hold("right", **dict.fromkeys(states, 0))
        asked.handle(hands.frames(4, asked.panel()))

    seen("confirm", trigger_click=1)
    assert not asked.confirmed
    seen("right", thumbstick_x=1)
    seen("right", thumbstick_x=1)
    assert (asked.value, asked.confirmed) == (4, False)
    seen("confirm", trigger_click=1)
    assert (asked.value, asked.confirmed) == (4, True)


def test_after_a_reconnection_they_are_heard_again(display, monado):
    with RemoteHead() as remote:
        hands = Hands(display, remote)
        assert hands.press("right", a_click=1) == ["confirm"]
    monado.kill()
    with pytest.raises(Lost):
        hands.frames(50)
    assert display.commands() == []
    monado.start()
    assert display.reopen()
    with RemoteHead() as remote:
        hands = Hands(display, remote)
        assert hands.press("right", a_click=1) == ["confirm"]


def test_without_anybodys_attention_nothing_is_asked_for(display, remote_head, monado):
    hands = Hands(display, remote_head)
    assert display._connection.session.state == State.FOCUSED
    _focus_is_elsewhere(display)
    assert hands.hold("right", a_click=1) == []
    display._connection.actions._calls = display._calls
    assert hands.hold("right", frames=4) == []  # held since then, for somebody else
    assert hands.hold("right", frames=4, a_click=0) == []
    assert hands.hold("right", frames=4, a_click=1) == ["confirm"]


def _focus_is_elsewhere(display: OpenXrDisplay) -> None:
    """Monado takes the focus away from nobody who is alone; what it answers then is
    XR_SESSION_NOT_FOCUSED (8).
    """

    def calls(name: str, *arguments: object) -> int:
        return 8 if name == "xrSyncActions" else display._calls(name, *arguments)

    display._connection.actions._calls = calls


def test_where_no_control_has_a_button_nothing_is_asked(monado):
    assert not any(one.buttons for one in CONTROLS)
    made = OpenXrDisplay(DisplayOptions(size=SMALL))
    try:
        assert made._connection.actions is None
    finally:
        made.close()


def test_a_runtime_that_knows_no_such_controllers_is_no_trouble(monado, monkeypatch):
    """It refuses their names; the display goes on without them."""
    monkeypatch.setattr(
        "hmdwarp.display.openxr.actions.PROFILES",
        {"/interaction_profiles/nobody/nothing": (("confirm", "/user/hand/left/input/x/click"),)},
    )
    made = OpenXrDisplay(DisplayOptions(size=SMALL, controls=STUDY_CONTROLS))
    try:
        for _ in range(3):
            if made.wait() is not None:
                made.show(None)
        assert made.commands() == []
        assert made._connection.actions.refused == ["/interaction_profiles/nobody/nothing"]
    finally:
        made.close()
