"""The display protocol, as the live driver sees it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import MachineError, option_of
from ..geometry import Eyes
from ..gpu import Gpu
from ..headsets import Headset
from ..pipeline import PipelineOptions, Refresh
from ..poses import PoseSource, PoseTrack
from .controls import CONTROLS, Command, Control, Status


class Closed(Exception):
    """The user has finished: the window or the session was closed. args: the reason, in words."""


class Lost(MachineError):
    """The display went away during a run and may come back: `Display.reopen`."""


class TextPanel(Hashable, Protocol):
    """A panel of text and figures over the picture, such as a question with its scale.

    Equal text panels look the same. On one that takes the pointer, a window's mouse is released and
    does not turn the head, and walking stops. Mouse events on it become commands whose value is (u,
    v) of the text panel, origin bottom left: "point" for motion, "press" for a click; "up" and
    "down" for the wheel have no value.
    """

    @property
    def pointed(self) -> bool:
        """Whether it takes the pointer."""

    @property
    def takes_text(self) -> bool:
        """Whether letters typed at a window become commands "type", each with its letter."""

    def ink(self) -> NDArray[np.uint8]:
        """Return (h, w), top row first: 255 where ink is; (h, w, 3) with linear light of a picture.

        Called once for each text panel, not once a refresh.
        """


Label = str | TextPanel  # shown over a picture; "" for nothing


@attrs.frozen
class Tick:
    """One refresh to make a picture for."""

    shown_ns: int  # when it will be seen
    period_ns: int  # between refreshes
    # False where the picture would be invisible; then show() gets no picture
    render: bool = True
    notice: str = ""  # for the user ("tracking lost"), "" for none
    missed: int = 0  # refreshes without a picture since the last tick


@attrs.frozen
class DisplayOptions:
    """Options that a display needs before it is opened."""

    headset: str = option_of(attrs.fields(PipelineOptions).headset).default  # the one a window emulates
    # in place of the one of that name
    emulated: Headset | None = None
    view: str = "both"  # "both" eyes or one "flat" one
    size: tuple[int, int] | None = None  # (w, h) of one eye; None for the display's preference
    full_screen: bool = False  # of a window
    vsync: bool = True
    control_panel: bool = True  # over a window, where its package is installed
    depth_layer: bool = True  # whether to submit the picture's depth to a runtime that accepts it
    # entered around every call into a runtime that may hang; it gets the call's name
    watching: Callable[[str], AbstractContextManager[object]] = lambda what: nullcontext()  # noqa: E731
    # a recording that a window or an offscreen display follows instead of live input
    trace: PoseTrack | None = None
    rate_hz: float | None = None  # refresh rate, where no screen defines it
    controls: tuple[Control, ...] = CONTROLS  # what keys, mouse and controllers request

    def about_trace(self) -> dict[str, str]:
        """Return the name of the recording and the axes that it was read in, as `Display.about`."""
        found = {"trace": self.trace.name, "trace_axes": self.trace.axes} if self.trace is not None else {}
        return {name: text for name, text in found.items() if text}


class Display(Protocol):
    """The protocol of displays.

    All times are on the display's own clock, `now_ns`, which its pose source shares.
    """

    name: str  # of the source: openxr, desktop or offscreen
    about: dict[str, str]  # its description by name, for headers and summaries (runtime, headset, ..)
    gpu: Gpu  # the context that it presents from; the display owns it
    distorts: str  # what corrects the lens instead of the plan, by name as in build_plan; "" for nothing
    takes_depth: str  # what reads the picture's depth, likewise
    takes_panels: str  # what composes panels itself, likewise

    @property
    def eyes(self) -> Eyes:
        """The poses of the eyes in the head, and their fields of view."""

    @property
    def source(self) -> PoseSource:
        """The source of head poses."""

    @property
    def size(self) -> tuple[int, int]:
        """Preferred (w, h) of one eye's picture in pixels."""

    @property
    def rate_hz(self) -> float:
        """Nominal refresh rate."""

    @property
    def headset(self) -> Headset | None:
        """The headset whose lens the plan corrects; None where the runtime corrects it."""

    def now_ns(self) -> int:
        """Return the current time."""

    def wait(self) -> Tick | None:
        """Wait until it is time to make the next picture.

        None: nothing to do now (not running, minimised); call again. Answer every tick by one
        show().
        Errors: Closed; Lost.
        """

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Submit the picture of the tick that wait() returned; None for an empty one.

        label: text or a text panel over it. Return the time of submission.
        Errors: Closed; Lost.
        """

    def set_view(self, view: str) -> None:
        """Switch to another DisplayOptions.view: eyes, size and headset may change."""

    def restart(self) -> None:
        """Let a recorded head begin anew, or a window's mouse turn the head without a click."""

    def commands(self) -> Sequence[Command]:
        """Return the user's requests since the last call."""

    def show_status(self, status: Status) -> None:
        """Show the status in the window's title and the control panel."""

    def reopen(self) -> bool:
        """Reconnect after Lost; return whether it is back, with the same gpu. Errors: Closed."""

    def close(self) -> None:
        """Release everything, the gpu last, in any state. Safe to call twice."""
