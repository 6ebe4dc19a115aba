"""Controllers through OpenXR actions: one action set, suggested for every kind of controller.

It is read once a refresh. Buttons of either hand answer questions; those of ACTS act in the scene,
from where the controller is along where it aims.
"""

from __future__ import annotations

import ctypes
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import xr

from ...base import InputError, MachineError
from ...geometry import Pose
from .. import Command
from ..controls import MOVED, Control
from .runtime import Calls, Instance
from .tracking import Spaces, pose_of

# Any other result means that the session lacks the focus (XR_SESSION_NOT_FOCUSED), and buttons are
# ignored.
_SYNCED = xr.Result.SUCCESS.value
_VALID = xr.SpaceLocationFlags.ORIENTATION_VALID_BIT.value | xr.SpaceLocationFlags.POSITION_VALID_BIT.value


class Actions:
    """Actions of one session. controls: of several with the same button, the first is requested."""

    def __init__(
        self, calls: Calls, instance: Instance, session: xr.Session, controls: Sequence[Control], spaces: Spaces
    ) -> None:
        self._calls, self._session, self._world, self._location = calls, session, spaces.world, xr.SpaceLocation()
        self._controls = {button: control for control in reversed(controls) for button in control.buttons}
        self._repeat, self._commands = ButtonRepeat(), list[Command]()
        handle = calls.call_once(
            xr.create_action_set,
            instance.handle,
            xr.ActionSetCreateInfo("answers", "Answers to questions, acts in the scene", 0),
        )
        hands = [self._path(instance, path) for path in HANDS]
        actions = {name: self._create(handle, name, xr.ActionType.BOOLEAN_INPUT, []) for name in BUTTONS}
        actions |= {name: self._create(handle, name, xr.ActionType.FLOAT_INPUT, hands) for name in AXES}
        actions |= {name: self._create(handle, name, xr.ActionType.BOOLEAN_INPUT, hands[:2]) for name in ACTS}
        actions[AIM] = self._create(handle, AIM, xr.ActionType.POSE_INPUT, hands[:2])
        self._suggest(instance, actions)
        calls.call_once(xr.attach_session_action_sets, session, xr.SessionActionSetsAttachInfo(action_sets=[handle]))
        # Kept referenced: the next line only points to it.
        self._active = (xr.ActiveActionSet * 1)(xr.ActiveActionSet(handle, xr.NULL_PATH))
        self._sync = xr.ActionsSyncInfo(count_active_action_sets=1, active_action_sets=self._active)
        is_on = partial(self._reader, "xrGetActionStateBoolean", xr.ActionStateBoolean)
        number = partial(self._reader, "xrGetActionStateFloat", xr.ActionStateFloat)
        self._buttons = {name: is_on(actions[name]) for name in BUTTONS}
        # Each hand separately: with both in one query, Monado 25 reports 0 where one stick is at -1
        # and the other at 0.
        self._axes = {name: [number(actions[name], hand) for hand in hands] for name in AXES}
        # Of the hands that aim, by (button, number of the hand) and by that number.
        self._acts = {(name, hand): is_on(actions[name], hands[hand]) for name in ACTS for hand in range(2)}
        here = xr.Posef(xr.Quaternionf(0, 0, 0, 1), xr.Vector3f(0, 0, 0))
        aims = (xr.ActionSpaceCreateInfo(actions[AIM], hand, here) for hand in hands[:2])
        self._spaces = [calls.call_once(xr.create_action_space, session, info) for info in aims]
        self._held: dict[tuple[str, int], bool] = {}  # of each button that acts; none after a pause
        self._holds: tuple[str, int] | None = None  # the button by which something is held

    def _reader(self, call: str, kind: Any, action: xr.Action, hand: int = xr.NULL_PATH) -> Callable[[], float]:
        """Return what reads an action, 0 while it is inactive. hand: its path; by default all."""
        info, state = xr.ActionStateGetInfo(action=action, subaction_path=hand), kind()
        pointers = ctypes.byref(info), ctypes.byref(state)

        def read() -> float:
            self._calls(call, self._session, *pointers)
            return float(state.current_state) if state.is_active else 0.0

        return read

    def _create(self, handle: xr.ActionSet, name: str, kind: xr.ActionType, hands: list[int]) -> xr.Action:
        info = xr.ActionCreateInfo(name, kind, len(hands), hands or None, name.replace("_", " "))
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

    def sync(self, now_ns: int, shown: int = 0) -> None:
        """Read the buttons, once a refresh.

        now_ns: on any running clock. shown: the instant of the picture, on the runtime's clock.
        Errors: Lost.
        """
        if self._calls("xrSyncActions", self._session, ctypes.byref(self._sync)) != _SYNCED:
            self._repeat.forget()
            if self._holds is not None:
                self._commands.append(Command(self._controls[self._holds[0]].name, False))
            self._held, self._holds = {}, None
            return
        buttons = {name: read() != 0 for name, read in self._buttons.items()}
        axes = {name: max((read() for read in reads), key=abs) for name, reads in self._axes.items()}
        for button in self._repeat.step(buttons, axes, now_ns):
            control = self._controls.get(button)
            if control is not None:
                self._commands.append(Command(control.name, control.value))
        for name, hand in self._acts:
            if name in self._controls:
                self._act(self._controls[name], (name, hand), shown)

    def _act(self, control: Control, button: tuple[str, int], shown: int) -> None:
        """Request what a button of a hand does: at its press or, for what is held, all the time."""
        is_held, was_held = self._acts[button]() != 0, self._held.get(button)
        if (is_held and was_held is None) or (control.kind == "hold" and self._holds not in (None, button)):
            return  # held since before; or the other hand holds something
        self._held[button] = is_held
        if not is_held and not was_held:
            return
        pose = self._aim(button[1], shown)
        if control.kind != "hold":
            if is_held and not was_held and pose is not None:
                self._commands.append(Command(control.name, control.value, hand=pose))
        elif not is_held:
            if self._holds is not None:
                self._commands.append(Command(control.name, False, hand=pose))
            self._holds = None
        elif pose is not None:
            self._commands.append(Command(control.name, MOVED if self._holds is not None else True, hand=pose))
            self._holds = button

    def _aim(self, hand: int, time: int) -> Pose | None:
        """Return world_from_hand at an instant; None while untracked. Errors: Lost."""
        self._calls("xrLocateSpace", self._spaces[hand], self._world, time, ctypes.byref(self._location))
        if self._location._location_flags & _VALID != _VALID:
            return None
        try:
            return pose_of(self._location.pose)
        except InputError:  # NaN, or a zero quaternion
            return None

    def commands(self) -> list[Command]:
        commands, self._commands = self._commands, []
        return commands


BUTTONS = ("left", "right", "up", "down", "confirm", "menu", "pad")
AXES = ("across", "along", "pad_across", "pad_along")
ACTS, AIM = ("select", "squeeze"), "aim"
HANDS = ("/user/hand/left", "/user/hand/right", "/user/gamepad")
_OF = {"left": HANDS[:1], "right": HANDS[1:2], "both": HANDS[:2], "gamepad": HANDS[2:]}
# (button or axis, path) of each kind of controller.
PROFILES: dict[str, tuple[tuple[str, str], ...]] = {
    f"/interaction_profiles/{name}": tuple(
        (button, f"{hand}/input/{path}")
        for place, pairs in profile.items()
        for hand in _OF[place]
        for button, paths in pairs.items()
        for path in ([paths] if isinstance(paths, str) else paths)
    )
    for name, profile in tomllib.loads(Path(__file__).with_name("controllers.toml").read_text(encoding="utf-8")).items()
}


PUSHED, LET_GO = 0.6, 0.4  # of a stick's travel: hysteresis, so that a trembling hand does not repeat
FIRST_NS, NEXT_NS = 450_000_000, 120_000_000  # delay until a held direction repeats, and its interval: as on keyboards
DIRECTIONS = {"left": ("across", -1), "right": ("across", 1), "up": ("along", 1), "down": ("along", -1)}
PAD = "pad_"  # prefix of an axis that counts only while the pad is pressed


class ButtonRepeat:
    """Buttons and sticks of one user. One that is down at the start counts after its release."""

    def __init__(self) -> None:
        # When each held button repeats; None for never.
        self._down: dict[str, int | None] = {}
        self._synced = False  # whether step() was called since the last pause

    def forget(self) -> None:
        """Forget held buttons: a press during a pause was not meant for this program."""
        self._down.clear()
        self._synced = False

    def step(self, buttons: Mapping[str, bool], axes: Mapping[str, float], now_ns: int) -> list[str]:
        """Return the names of the requests: "left", "right", "up", "down", "confirm", "menu"."""
        requests = []
        for name in ("left", "right", "up", "down", "confirm", "menu"):
            if not self._held(name, buttons, axes):
                self._down.pop(name, None)
            elif name not in self._down:
                self._down[name] = now_ns + FIRST_NS if self._synced and name in DIRECTIONS else None
                requests += [name] if self._synced else []
            elif (due := self._down[name]) is not None and now_ns >= due:
                self._down[name] = now_ns + NEXT_NS  # not due + NEXT_NS: one step after a stall, not many at once
                requests.append(name)
        self._synced = True
        return requests

    def _held(self, name: str, buttons: Mapping[str, bool], axes: Mapping[str, float]) -> bool:
        if buttons.get(name, False):
            return True
        if name not in DIRECTIONS:
            return False
        axis, sign = DIRECTIONS[name]
        pushed = sign * axes.get(axis, 0.0)
        if buttons.get("pad", False):
            pushed = max(pushed, sign * axes.get(PAD + axis, 0.0))
        least = LET_GO if name in self._down else PUSHED
        across_it = max(abs(axes.get(other, 0.0)) for other in ("across", "along") if other != axis)
        return pushed >= least and (name in self._down or pushed >= across_it)
