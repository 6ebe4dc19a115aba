"""Every control has its key, no key does two things, and moves are no controls."""

from __future__ import annotations

import pytest

glfw = pytest.importorskip("glfw", exc_type=ImportError)

from hmdwarp.display import CONTROLS, MOVING, Command, Status, control  # noqa: E402
from hmdwarp.display.desktop import window_input  # noqa: E402
from hmdwarp.display.desktop.window_input import BUTTONS, FASTER, MOVES, Keys, direction, token  # noqa: E402
from hmdwarp.study.dialogs.dialog_panels import CONTROLS as OF_STUDY  # noqa: E402

KEYS = Keys(CONTROLS)


def pressed(key: int, mods: int = 0, action: int = glfw.PRESS) -> Command | None:
    return KEYS.command_of(key, action, mods)


def test_no_key_does_two_things():
    tokens = [token(key) for control in CONTROLS for key in (control.key, control.back) if key]
    assert len(set(tokens) | set(MOVES) | set(FASTER)) == len(tokens) + len(MOVES) + len(FASTER)


@pytest.mark.parametrize("one", CONTROLS, ids=lambda one: one.name)
def test_a_press_is_a_step_on_and_choices_and_numbers_have_a_way_back(one):
    key = token(one.key)
    assert pressed(key) == Command(one.name)
    assert pressed(key, action=glfw.RELEASE) is None
    assert (pressed(key, action=glfw.REPEAT) is not None) == (one.kind == "number")
    if one.kind in ("choice", "number"):
        back = pressed(token(one.back)) if one.back else pressed(key, glfw.MOD_SHIFT)
        assert back == Command(one.name, back=True)


def test_shift_turns_no_switch_around_and_no_key_that_has_its_own_way_back():
    assert not pressed(token("]"), glfw.MOD_SHIFT).back
    assert not pressed(token(control("lens").key), glfw.MOD_SHIFT).back


def test_keys_of_the_desktop_and_of_moves_do_nothing_else():
    for mods in (glfw.MOD_CONTROL, glfw.MOD_ALT, glfw.MOD_SUPER, glfw.MOD_ALT | glfw.MOD_SHIFT):
        assert pressed(glfw.KEY_T, mods) is None
    assert {pressed(key) for key in (glfw.KEY_F5, glfw.KEY_UNKNOWN, *MOVES)} == {None}
    assert direction(set()) == (0, 0, 0)
    assert direction({glfw.KEY_W, glfw.KEY_D, glfw.KEY_E}) == (1, 1, 1)
    assert direction({glfw.KEY_W, glfw.KEY_S, glfw.KEY_LEFT_SHIFT, glfw.KEY_A}) == (-1, 0, 0)


def test_a_button_of_the_mouse_does_what_its_key_does_and_a_hold_ends_with_it():
    buttons = {control.mouse: control for control in CONTROLS if control.mouse}
    assert buttons.keys() == BUTTONS.keys()
    for name, one in buttons.items():
        down, up = (KEYS.command_of_button(BUTTONS[name], action) for action in (glfw.PRESS, glfw.RELEASE))
        assert down.control == one.name and down.value is (True if one.kind == "hold" else None)
        assert up == (Command(one.name, False) if one.kind == "hold" else None)
    assert KEYS.command_of_button(glfw.MOUSE_BUTTON_5, glfw.PRESS) is None


def test_the_help_names_everything_and_the_first_picture_how_to_look(monkeypatch):
    monkeypatch.setattr(window_input, "label", str.upper)
    lines = KEYS.help_text().splitlines()
    assert len(lines) == len(CONTROLS) + len(MOVING)
    for listed in CONTROLS:
        assert any(listed.what in line and listed.key.upper() in line.upper() for line in lines), listed
    assert [line.partition("\t")[0] for line in lines[: len(MOVING)]] == ["mouse", "W A S D", "Q E", "shift"]  # first


def test_only_what_the_run_has_is_offered(monkeypatch):
    monkeypatch.setattr(window_input, "label", str.upper)
    keys = Keys(CONTROLS)
    keys.status = Status(has=frozenset({"push"}))
    needing = {one.name for one in CONTROLS if one.needs}
    assert needing == {"scene", "lens", "push", "switch", "grab"}
    pressed = {one.name for one in CONTROLS if keys.command_of(token(one.key), glfw.PRESS, 0) is not None}
    assert pressed == {one.name for one in CONTROLS} - (needing - {"push"})
    assert keys.command_of_button(BUTTONS["left"], glfw.PRESS) == Command("push")
    assert keys.command_of_button(BUTTONS["right"], glfw.PRESS) is None
    assert len(keys.help_text().splitlines()) == len(CONTROLS) + len(MOVING) - 4


def test_the_first_picture_says_how_to_look_and_a_study_s_says_nothing(monkeypatch):
    monkeypatch.setattr(window_input, "label", str.upper)
    assert Keys(CONTROLS).first_words(looks=True) == ["click to look, H for help"]
    assert Keys(CONTROLS).first_words(looks=False) == ["H for help"]
    assert Keys(OF_STUDY).first_words(looks=True) == []
