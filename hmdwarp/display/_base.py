"""The display protocol, as the live driver sees it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Protocol

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import MachineError
from .controls import CONTROLS, Control

if TYPE_CHECKING:
    from ..geometry import Eyes
    from ..gpu.context import Gpu
    from ..headsets import Headset
    from ..pipeline.loop import Refresh
    from ..poses import PoseSource, PoseTrack


class Closed(Exception):
    """The user is done: the window was closed, or the runtime ended the session.

    args: why, in words.
    """


class Lost(MachineError):
    """The display went away during a run and may come back: `Display.reopen`.

    The message says what happened.
    """


class TextPanel(Hashable, Protocol):
    """Something drawn over the picture instead of a line of text: a question with its scale.

    Equal panels look the same. While a panel that wants pointing lies there, a window's mouse is
    free and leads no head. What the mouse does on the panel comes as commands whose place is (u, v)
    of the panel, origin bottom left: "point" where it moves, "press" where it is clicked, "up" and
    "down" as its wheel turns. Walking stops meanwhile.
    """

    @property
    def pointed(self) -> bool: ...

    def ink(self) -> NDArray[np.uint8]:
        """Return (h, w), top row first: 255 where ink is.

        Called once for a panel, not at each refresh.
        """


Label = str | TextPanel  # what lies over a picture; "" for nothing


@attrs.frozen
class Tick:
    """One refresh to make a picture for."""

    shown_ns: int  # when it will be seen
    period_ns: int  # between refreshes
    # False where the picture would be invisible; the refresh is then handed over empty
    render: bool = True
    notice: str = ""  # for the user ("tracking lost"), "" for none
    missed: int = 0  # refreshes without a picture since the last tick


@attrs.frozen
class Command:
    """A user's request."""

    control: str  # its name in display.controls
    value: object = None  # what it is set to, None for one step
    back: bool = False  # a step back instead of forward


@attrs.frozen
class DisplayOptions:
    """What a display must know before it is opened."""

    headset: str = "rift-dk1"  # name of the one a window emulates
    view: str = "both"  # "both" eyes or one "flat" one
    size: tuple[int, int] | None = None  # (w, h) of one eye; None for what the display prefers
    full_screen: bool = False  # of a window
    vsync: bool = True
    panel: bool = True
    depth_layer: bool = True  # whether a runtime that takes the picture's depth gets it
    # put around every call into a runtime that may hang; it gets the call's name
    watching: Callable[[str], AbstractContextManager[object]] = lambda what: nullcontext()  # noqa: E731
    # a recording that a window or an offscreen display follows instead of a live head
    trace: PoseTrack | None = None
    rate_hz: float | None = None  # refreshes a second, where no screen says so
    controls: tuple[Control, ...] = CONTROLS  # what keys, mouse and controllers request


class Display(Protocol):
    """What every display does.

    All times are on its own clock, `now_ns`, which is its pose source's too.
    """

    name: str  # "openxr", "desktop" or "offscreen"
    about: dict[str, str]  # what it is, by name, for headers and summaries (runtime, headset, ..)
    gpu: Gpu  # its pictures can be shown; it belongs to the display
    eyes: Eyes
    source: PoseSource
    size: tuple[int, int]  # (w, h) of one eye that it prefers
    rate_hz: float  # nominal refresh rate
    headset: Headset | None  # whose lens the plan corrects; None where the runtime does that
    distorts: str  # as build_plan has it
    takes_depth: str  # as build_plan has it

    def now_ns(self) -> int:
        """Return this instant."""

    def wait(self) -> Tick | None:
        """Wait until it is time to make the next picture.

        None: nothing to do just now (not running, minimised); call again. Every tick must be
        answered by one show().
        Errors: Closed; Lost.
        """

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Hand over the picture of the tick that wait() returned; None for an empty one.

        label: text or a panel over it. Returns when it was handed over.
        Errors: Closed; Lost.
        """

    def look(self, view: str) -> None:
        """Switch to another view, as DisplayOptions.view.

        Eyes, size and headset may differ afterwards. A headset has only one view.
        """

    def restart(self) -> None:
        """Prepare for something new: a recorded head begins anew, a live one goes on."""

    def commands(self) -> Sequence[Command]:
        """Return the user's requests since the last call."""

    def tell(self, status: object) -> None:
        """Show a Status in the title line and the control panel."""

    def reopen(self) -> bool:
        """Tell, after Lost, whether the display is back. The gpu stays the same. Errors: Closed."""

    def close(self) -> None:
        """Release everything, the gpu last, in whatever state. May be called twice."""
