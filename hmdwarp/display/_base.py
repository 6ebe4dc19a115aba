"""What a display is, as the live driver sees it."""

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
    """Nobody looks any more: the window was closed, or the runtime ended the session. args: why, in words for the user."""


class Lost(MachineError):
    """The display went away in the middle of a run, and may come back: `Display.reopen`. The message says what happened."""


class TextPanel(Hashable, Protocol):
    """Something drawn that lies over the picture where a line of text would: a question with its scale. Equal plates look the same.

    pointed: whether it wants to be pointed at. While it lies there a window's mouse is free and leads no head, and what it does on the
    plate comes as commands, its place as (u, v) of the plate, origin bottom left: "point" where it moves, "press" where it is clicked,
    "up" and "down" as its wheel turns. Nobody walks meanwhile either.
    """

    @property
    def pointed(self) -> bool: ...

    def ink(self) -> NDArray[np.uint8]:
        """(h, w), top row first: 255 where ink is. Called once for a plate, not at each refresh."""


Label = str | TextPanel  # what lies over a picture; "" for nothing


@attrs.frozen
class Tick:
    """One refresh to make a picture for. shown_ns: when it will be seen. period_ns: between refreshes.

    render: whether anybody would see a picture; without, the refresh is handed over empty. notice: what the one who looks should be told
    ("tracking lost"), "" for nothing. missed: refreshes that went by without a picture since the last tick.
    """

    shown_ns: int
    period_ns: int
    render: bool = True
    notice: str = ""
    missed: int = 0


@attrs.frozen
class Command:
    """Something the one who looks asked for. control: its name in live.controls; value: what it is set to, None for one step on.

    back: a step back instead of on.
    """

    control: str
    value: object = None
    back: bool = False


@attrs.frozen
class DisplayOptions:
    """What a display must know before it is opened. headset: the name of the one a window stands for. view: "both" eyes or one "flat" one.

    size: (w, h) of one eye; None for what the display likes. full_screen, vsync, panel: of a window. depth_layer: whether a runtime that
    takes the picture's depth gets it. watching: put around every call into a runtime that may hang; it is given the call's name.
    trace: a recording that a window or an offscreen display follows instead of anybody's head. rate_hz: refreshes a second, where there is
    no screen to say. controls: what keys, mouse and controllers ask for.
    """

    headset: str = "rift-dk1"
    view: str = "both"
    size: tuple[int, int] | None = None
    full_screen: bool = False
    vsync: bool = True
    panel: bool = True
    depth_layer: bool = True
    watching: Callable[[str], AbstractContextManager[object]] = lambda what: nullcontext()  # noqa: E731
    trace: PoseTrack | None = None
    rate_hz: float | None = None
    controls: tuple[Control, ...] = CONTROLS


class Display(Protocol):
    """All times are on the display's own clock, `now_ns`, which is that of its pose source.

    name: "openxr", "desktop" or "offscreen". about: what it is, by name, for headers and summaries (runtime, headset, ..). gpu: whose
    pictures it can show; it belongs to the display. eyes, source: whose eyes and whose head. size: (w, h) of one eye it would like.
    rate_hz: its nominal refresh rate. headset: whose lens the plan corrects, None where that is not ours to do. distorts, takes_depth: as
    build_plan has them.
    """

    name: str
    about: dict[str, str]
    gpu: Gpu
    eyes: Eyes
    source: PoseSource
    size: tuple[int, int]
    rate_hz: float
    headset: Headset | None
    distorts: str
    takes_depth: str

    def now_ns(self) -> int:
        """This instant."""

    def wait(self) -> Tick | None:
        """Wait until it is time to make the next picture. None: nothing to do just now (not running, minimised); ask again.

        Every tick must be answered by one show(). Errors: Closed; Lost.
        """

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Hand the picture over for the tick that wait() gave; None for an empty one. label: what lies over it, text or a plate.

        Returns when it was handed over. Errors: Closed; Lost.
        """

    def look(self, view: str) -> None:
        """Another view from now on, as DisplayOptions.view; eyes, size and headset may be others afterwards. A headset has but one."""

    def restart(self) -> None:
        """Something new is about to be shown: a recorded head begins anew, a living one goes on."""

    def commands(self) -> Sequence[Command]:
        """What was asked for since the last time."""

    def tell(self, status: object) -> None:
        """What the title line and the panel show: a live.figures.Status."""

    def reopen(self) -> bool:
        """After Lost: whether it is there again. The gpu stays the same. Errors: Closed."""

    def close(self) -> None:
        """Let go of everything, the gpu last; whatever state it is in. May be called twice."""
