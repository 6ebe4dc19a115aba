"""Controls: everything that the user can change during a run.

Every control has a key, and the control panel shows the same ones.
"""

from __future__ import annotations

import attrs


@attrs.frozen
class Command:
    """A user's request."""

    control: str  # its name in display.controls
    value: object = None  # what it is set to, None for one step
    back: bool = False  # a step back instead of forward


@attrs.frozen
class Control:
    """One thing that the user can change."""

    name: str  # as Command.control names it
    key: str  # as glfw names keys ("T", "[", "F11", "KP 1", "Left"); with shift it steps back
    what: str  # a short description for the help; "" omits it there
    # "choice", "number", "switch", "action", or "step", which repeats while its key is held, as a
    # number does
    kind: str
    back: str = ""  # a separate key for a step back, "" for shift
    of_display: bool = False  # whether the display handles it itself; all others change the run
    span: tuple[float, float] = (0.0, 0.0)  # smallest and largest value of a number
    also: tuple[str, ...] = ()  # further keys
    value: object = None  # value of the command, where several keys are one control
    buttons: tuple[str, ...] = ()  # of controllers, by their names in display/openxr/controllers.py
    written: str = ""  # how the help writes its keys, "" for their names
    # available only while a text panel lies over the picture: other pictures must stay free of text
    needs_text_panel: bool = False


CONTROLS: tuple[Control, ...] = (
    Control("latency", "]", "latency, 50 ms more or less", "number", back="[", span=(0.0, 2500.0)),
    Control("warp", "T", "next warp", "choice"),
    Control("fill", "F", "next fill", "choice"),
    Control("guard", "G", "guard band, 0.25 more or less", "number", span=(1.0, 3.0)),
    Control("scene", "N", "next scene", "choice"),
    Control("effects", "C", "compensate effects: auto or none", "choice"),
    Control("lens", "O", "lens on or off", "switch"),
    Control("view", "V", "both eyes or one flat view", "switch"),
    Control("recentre", "R", "head back to where it began", "action", of_display=True),
    Control("full_screen", "F11", "full screen", "switch", of_display=True),
    Control("vsync", "Y", "wait for the screen's refresh", "switch", of_display=True),
    Control("panel", "P", "panel", "switch", of_display=True),
    Control("help", "H", "this help", "switch", of_display=True),
    Control("quit", "Escape", "close this help; let go of the mouse; end", "action", of_display=True),
)
# Movement is no control: mouse (click into the window first) turns, W A S D walk, Q and E go down
# and up, shift is faster.
MOVING = (("mouse", "look around (click first)"), ("W A S D", "walk"), ("Q E", "down, up"), ("shift", "faster"))


def control(name: str) -> Control:
    """Return the control of that name."""
    return next(control for control in CONTROLS if control.name == name)


def help_closes(controls: tuple[Control, ...], has_text_panel: bool) -> bool:
    """Return whether an open help must be closed now.

    has_text_panel: whether a text panel is shown.
    """
    return not has_text_panel and any(control.name == "help" and control.needs_text_panel for control in controls)
