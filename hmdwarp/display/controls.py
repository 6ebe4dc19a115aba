"""What can be changed while a run goes on: every control has a key, and the panel shows the same ones."""

from __future__ import annotations

import attrs


@attrs.frozen
class Control:
    """name: as Command.control names it. key: as glfw's keys are named ("T", "[", "F11", "KP 1", "Left"); with shift it steps back.

    back: a key of its own for a step back, "" for shift. what: for the help, a few words; "" leaves it out there. of_display: whether the
    display does it by itself; the others change the run. kind: "choice", "number", "switch" or "action", for the panel; a "step" goes on
    while its key is held, as a number does. span: the least and most of a number. also: further keys for the same. value: what the command
    is given, where several keys are one control. buttons: of controllers, by their names in display/openxr/bindings.py. written: how the
    help names its keys, "" for as they are. beside_plate: of the help: it is to be had only while a plate lies over the picture, and goes
    with it, where nothing may be written over pictures.
    """

    name: str
    key: str
    what: str
    kind: str
    back: str = ""
    of_display: bool = False
    span: tuple[float, float] = (0.0, 0.0)
    also: tuple[str, ...] = ()
    value: object = None
    buttons: tuple[str, ...] = ()
    written: str = ""
    beside_plate: bool = False


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
    Control("quit", "Escape", "let go of the mouse; end", "action", of_display=True),
)
# Moving is no control: mouse (click into the window first) turns, W A S D walk, Q and E go down and up, shift is faster.
MOVING = (("mouse", "turn (click first)"), ("W A S D", "walk"), ("Q E", "down, up"), ("shift", "faster"))


def control(name: str) -> Control:
    """The control of that name."""
    return next(one for one in CONTROLS if one.name == name)


def help_goes(controls: tuple[Control, ...], plate: bool) -> bool:
    """Whether a help that is open must be closed now. plate: whether a plate lies over the picture."""
    return not plate and any(one.name == "help" and one.beside_plate for one in controls)
