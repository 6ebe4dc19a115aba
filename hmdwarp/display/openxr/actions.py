"""Controllers through OpenXR actions: one action set, suggested for every kind of controller.

It is read once a refresh.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import xr

from ...errors import MachineError
from .. import Command
from ..controls import Control
from .controllers import AXES, BUTTONS, HANDS, PROFILES, ButtonRepeat
from .runtime import Calls, Instance

if TYPE_CHECKING:

    class _State(ctypes.Structure):
        """XrActionStateBoolean or XrActionStateFloat."""

        current_state: float
        is_active: bool


# Any other result means that the session lacks the focus (XR_SESSION_NOT_FOCUSED), and buttons are
# ignored.
_SYNCED = xr.Result.SUCCESS.value
_WORDS = {
    "across": "stick, across",
    "along": "stick, along",
    "pad": "pad pressed",
    "pad_across": "pad, across",
    "pad_along": "pad, along",
}


class Actions:
    """Actions of one session, created before it begins; they are destroyed with the instance.

    controls: of several with the same button, the first one is requested.
    """

    def __init__(self, calls: Calls, instance: Instance, session: xr.Session, controls: Sequence[Control]) -> None:
        self._calls, self._session = calls, session
        self._controls = {button: control for control in reversed(controls) for button in control.buttons}
        self._repeat, self._commands = ButtonRepeat(), list[Command]()
        handle = calls.call_once(
            xr.create_action_set, instance.handle, xr.ActionSetCreateInfo("answers", "Answers to questions", 0)
        )
        hands = [self._path(instance, path) for path in HANDS]
        actions = {name: self._create(handle, name, xr.ActionType.BOOLEAN_INPUT, []) for name in BUTTONS}
        actions |= {name: self._create(handle, name, xr.ActionType.FLOAT_INPUT, hands) for name in AXES}
        self._suggest(instance, actions)
        calls.call_once(xr.attach_session_action_sets, session, xr.SessionActionSetsAttachInfo(action_sets=[handle]))
        # Kept referenced: the next line only points to it.
        self._active = (xr.ActiveActionSet * 1)(xr.ActiveActionSet(handle, xr.NULL_PATH))
        self._sync = xr.ActionsSyncInfo(count_active_action_sets=1, active_action_sets=self._active)
        self._buttons = {name: _Query(actions[name], xr.ActionStateBoolean()) for name in BUTTONS}
        # Each hand separately: with both in one query, Monado 25 reports 0 where one stick is at -1
        # and the other at 0.
        self._axes = {name: [_Query(actions[name], xr.ActionStateFloat(), hand) for hand in hands] for name in AXES}

    def _create(self, handle: xr.ActionSet, name: str, kind: xr.ActionType, hands: list[int]) -> xr.Action:
        info = xr.ActionCreateInfo(name, kind, len(hands), hands or None, _WORDS.get(name, name))
        return self._calls.call_once(xr.create_action, handle, info)

    def _suggest(self, instance: Instance, actions: dict[str, xr.Action]) -> None:
        self.refused: list[str] = []  # controller profiles that the runtime does not know
        for profile, pairs in PROFILES.items():
            paths = [(actions[name], self._path(instance, path)) for name, path in pairs]
            suggested = [xr.ActionSuggestedBinding(action, path) for action, path in paths]
            info = xr.InteractionProfileSuggestedBinding(self._path(instance, profile), len(suggested), suggested)
            try:
                self._calls.call_once(xr.suggest_interaction_profile_bindings, instance.handle, info)
            except MachineError:  # the controller has no such input
                self.refused.append(profile)

    def _path(self, instance: Instance, text: str) -> Any:
        """Return an XrPath, a ctypes integer that has no conversion of its own."""
        return self._calls.call_once(xr.string_to_path, instance.handle, text)

    def sync(self, now_ns: int) -> None:
        """Read the buttons, once a refresh. now_ns: on any running clock. Errors: Lost."""
        if self._calls("xrSyncActions", self._session, ctypes.byref(self._sync)) != _SYNCED:
            self._repeat.forget()
            return
        buttons = {name: self._state("xrGetActionStateBoolean", one) != 0 for name, one in self._buttons.items()}
        axes = {
            name: max((self._state("xrGetActionStateFloat", action) for action in ones), key=abs)
            for name, ones in self._axes.items()
        }
        for button in self._repeat.step(buttons, axes, now_ns):
            control = self._controls.get(button)
            if control is not None:
                self._commands.append(Command(control.name, control.value))

    def _state(self, call: str, one: _Query) -> float:
        self._calls(call, self._session, one.info_pointer, one.state_pointer)
        return one.state.current_state if one.state.is_active else 0

    def commands(self) -> list[Command]:
        """Return the commands since the last call."""
        commands, self._commands = self._commands, []
        return commands


class _Query:
    """One action's state, and the pointers to read it.

    hand: its path; all of them by default.
    """

    def __init__(self, action: xr.Action, state: _State, hand: int = xr.NULL_PATH) -> None:
        self._info, self.state = xr.ActionStateGetInfo(action=action, subaction_path=hand), state
        self.info_pointer, self.state_pointer = ctypes.byref(self._info), ctypes.byref(state)


def open_actions(calls: Calls, instance: Instance, session: xr.Session, controls: Sequence[Control]) -> Actions | None:
    """Open the actions, or return None if no control has a button.

    Errors: MachineError.
    """
    return Actions(calls, instance, session, controls) if any(control.buttons for control in controls) else None
