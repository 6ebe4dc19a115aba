"""Button bindings of every kind of controller in OpenXR's core.

Names of buttons: "left", "right", "up", "down", "confirm", "menu", as
display.controls.Control.buttons has them. A stick is two axes of -1..1, "across" and "along"; a
pad's axes count only while it is pressed ("pad"), because a thumb rests on it.

Source: OpenXR 1.0 specification, section 6.4, Interaction Profile Paths.
"""

from __future__ import annotations

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
    # menu. Long presses mean nothing: nobody would discover them in a headset.
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
