"""Controllers' buttons: their paths on every kind, and one request a press, repeated while held."""

from __future__ import annotations

from collections.abc import Mapping

BUTTONS = ("left", "right", "up", "down", "confirm", "menu", "pad")
AXES = ("across", "along", "pad_across", "pad_along")
HANDS = ("/user/hand/left", "/user/hand/right", "/user/gamepad")
_LEFT, _RIGHT, _PAD = (f"{hand}/input" for hand in HANDS)
Bindings = tuple[tuple[str, str], ...]  # (button or axis, path)


def _both(*pairs: tuple[str, str]) -> Bindings:
    """Return the path for either hand."""
    return tuple((name, f"{hand}/{what}") for hand in (_LEFT, _RIGHT) for name, what in pairs)


_STICK = (("across", "thumbstick/x"), ("along", "thumbstick/y"))
_TRACKPAD = (("pad_across", "trackpad/x"), ("pad_along", "trackpad/y"), ("pad", "trackpad/click"))

PROFILES: dict[str, Bindings] = {
    # Two buttons a hand and no stick: each hand's main one moves the marker to its own side. Of the
    # others, the right hand's confirms, the one most people write with, and the left hand's is the
    # menu. Long presses mean nothing: a user would not discover them in a headset.
    "/interaction_profiles/khr/simple_controller": (
        ("left", f"{_LEFT}/select/click"),
        ("right", f"{_RIGHT}/select/click"),
        ("confirm", f"{_RIGHT}/menu/click"),
        ("menu", f"{_LEFT}/menu/click"),
    ),
    # The right hand's menu button is reserved by the system.
    "/interaction_profiles/oculus/touch_controller": (
        *_both(*_STICK, ("confirm", "trigger/value")),
        ("confirm", f"{_LEFT}/x/click"),
        ("confirm", f"{_RIGHT}/a/click"),
        ("menu", f"{_LEFT}/menu/click"),
        ("menu", f"{_LEFT}/y/click"),
        ("menu", f"{_RIGHT}/b/click"),
    ),
    "/interaction_profiles/valve/index_controller": _both(
        *_STICK, ("confirm", "trigger/click"), ("confirm", "a/click"), ("menu", "b/click")
    ),
    "/interaction_profiles/htc/vive_controller": _both(
        *_TRACKPAD, ("confirm", "trigger/click"), ("menu", "menu/click")
    ),
    "/interaction_profiles/microsoft/motion_controller": _both(
        *_STICK, *_TRACKPAD, ("confirm", "trigger/value"), ("menu", "menu/click")
    ),
    "/interaction_profiles/microsoft/xbox_controller": (
        ("across", f"{_PAD}/thumbstick_left/x"),
        ("along", f"{_PAD}/thumbstick_left/y"),
        ("left", f"{_PAD}/dpad_left/click"),
        ("right", f"{_PAD}/dpad_right/click"),
        ("up", f"{_PAD}/dpad_up/click"),
        ("down", f"{_PAD}/dpad_down/click"),
        ("confirm", f"{_PAD}/a/click"),
        ("menu", f"{_PAD}/menu/click"),
        ("menu", f"{_PAD}/y/click"),
    ),
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
            elif self._repeats(name, now_ns):
                requests.append(name)
        self._synced = True
        return requests

    def _repeats(self, name: str, now_ns: int) -> bool:
        due = self._down[name]
        if due is None or now_ns < due:
            return False
        self._down[name] = now_ns + NEXT_NS  # not due + NEXT_NS: one step after a stall, not many at once
        return True

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
