"""Controls: everything that the user can change during a run.

Every control has a key, and the control panel shows the same ones.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from functools import partial
from statistics import fmean

import attrs

from .. import geometry  # a face: help texts load this file, and no NumPy

MOVED = "moved"  # value of a command of kind "hold" whose hand has gone on


@attrs.frozen
class Command:
    """A user's request."""

    control: str  # its name in display.controls
    value: object = None  # what it is set to, None for one step
    back: bool = False  # a step back instead of forward
    # of a controller: world_from_hand, which points along -z; None for keys and mouse
    hand: geometry.Pose | None = None


@attrs.frozen
class Control:
    """One thing that the user can change."""

    name: str  # as Command.control names it
    key: str  # as glfw names keys ("T", "[", "F11", "KP 1", "Left"); with shift it steps back
    what: str  # a short description for the help; "" omits it there
    # "choice", "number", "switch", "action"; "hold", which lasts as long as its mouse button is
    # held, or until its key is pressed again; "step", which repeats while its key is held, as a
    # number does
    kind: str
    back: str = ""  # a separate key for a step back, "" for shift
    of_display: bool = False  # whether the display handles it itself; others change the run or act in its scene
    span: tuple[float, float] = (0.0, 0.0)  # smallest and largest value of a number
    also: tuple[str, ...] = ()  # further keys
    value: object = None  # value of the command, where several keys are one control
    buttons: tuple[str, ...] = ()  # of controllers, by their names in display/openxr/actions.py
    mouse: str = ""  # button of a mouse that turns the head: "left", "middle" or "right"
    written: str = ""  # how the help writes its keys, "" for their names
    # available only while a text panel lies over the picture: other pictures must stay free of text
    needs_text_panel: bool = False
    needs: str = ""  # what the run must have (`run.live_run.has`) for it to be offered, "" for nothing


CONTROLS: tuple[Control, ...] = (
    Control("latency", "]", "latency, 50 ms more or less", "number", back="[", span=(0.0, 2500.0)),
    Control("warp", "T", "next warp", "choice"),
    Control("fill", "F", "next fill", "choice"),
    Control("guard", "G", "guard band, 0.25 more or less", "number", span=(1.0, 3.0)),
    Control("scene", "N", "next scene", "choice", needs="scenes"),
    Control("effects", "C", "compensate effects: auto or none", "choice"),
    Control("lens", "O", "lens on or off", "switch", needs="lens"),
    Control("view", "V", "both eyes or one flat view", "switch"),
    Control("push", "Z", "push what is ahead", "action", mouse="left", buttons=("select",), needs="push"),
    Control("switch", "L", "switch a lamp on or off", "action", mouse="middle", needs="switch"),
    Control("grab", "B", "grab what is ahead, or let go", "hold", mouse="right", buttons=("squeeze",), needs="grab"),
    Control("recentre", "R", "head back to where it began", "action", of_display=True),
    Control("full_screen", "F11", "full screen", "switch", of_display=True),
    Control("panel", "P", "panel", "switch", of_display=True),
    Control("help", "H", "this help", "switch", of_display=True),
    Control("quit", "Escape", "close this help; let go of the mouse; end", "action", of_display=True),
)
# Movement is no control: mouse (click into the window first) turns, W A S D walk, Q and E go down
# and up, shift is faster.
MOVING = (("mouse", "look around (click first)"), ("W A S D", "walk"), ("Q E", "down, up"), ("shift", "faster"))


def and_mouse(control: Control) -> str:
    """Return what follows the keys of a control in a list of them."""
    return f" ({control.mouse} button)" if control.mouse else ""


def control(name: str) -> Control:
    return next(control for control in CONTROLS if control.name == name)


def help_closes(controls: tuple[Control, ...], has_text_panel: bool) -> bool:
    """Return whether an open help must be closed now, by whether a text panel is shown."""
    return not has_text_panel and any(control.name == "help" and control.needs_text_panel for control in controls)


KEPT = 240  # refreshes in the plots
_plot = partial(deque[float], maxlen=KEPT)


@attrs.define(eq=False)
class Status:
    """What the title line and the control panel show.

    Deques hold the last refreshes, oldest first.
    """

    # the current value of each control, by its name
    values: dict[str, object] = attrs.field(factory=dict)
    # values of controls of kind "choice", including the current one
    choices: Mapping[str, tuple[object, ...]] = attrs.field(factory=dict)
    has: frozenset[str] | None = None  # what controls may need; None before a run has begun
    budget_ms: float = 0.0  # a refresh of the display
    stage_ms: dict[str, float] = attrs.field(factory=dict)  # of the last refresh, both eyes
    total_ms: deque[float] = attrs.field(factory=_plot)  # all passes of both eyes
    age_ms: deque[float] = attrs.field(factory=_plot)  # from drawing the shown frame to showing it
    # from reading the head to handing the picture over
    pose_age_ms: deque[float] = attrs.field(factory=_plot)
    # share of pixels without coverage after the warp; NaN where not counted
    holes: deque[float] = attrs.field(factory=_plot)
    period_ms: deque[float] = attrs.field(factory=_plot)  # between two pictures
    missed: int = 0  # refreshes without a new picture, since the start
    notice: str = ""  # as Tick.notice
    recording: bool = False
    # title instead of settings and numbers, which would reveal the condition; "" for those
    heading: str = ""

    def offers(self, control: Control) -> bool:
        """Return whether the run can follow a control."""
        return not control.needs or self.has is None or control.needs in self.has

    @property
    def rate_hz(self) -> float:
        """Pictures a second, over the last second or so; 0 before there were two."""
        last = list(self.period_ms)[-60:]
        return 1e3 / fmean(last) if last and fmean(last) > 0 else 0.0

    def title(self) -> str:
        notice = f" - {self.notice}" if self.notice else ""
        if self.heading:
            return f"hmdwarp - {self.heading}{notice}"
        v = self.values
        chosen = f"{v.get('scene', '')} - {v.get('warp', '')} + {v.get('fill', '')} - {v.get('latency', 0):g} ms"
        holes = f", holes {self.holes[-1]:.1%}" if self.holes and self.holes[-1] == self.holes[-1] else ""
        age = f", age {self.age_ms[-1]:.0f} ms" if self.age_ms else ""
        return f"hmdwarp - {chosen} - {self.rate_hz:.0f} fps{age}{holes}, {self.missed} missed{notice}"
