"""A headset as a display.

The runtime says when, where and what each eye sees, and gets the pictures.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...errors import MachineError
from ...geometry import View
from .. import Command, DisplayOptions, Label, Tick
from ..present import Presenter
from . import WHO
from .calls import Calls
from .connection import IDLE_S, Connection, connect
from .eyes import RuntimeEyes
from .graphics import Graphics, open_graphics
from .instance import Instance
from .layer import NEAR_M
from .tracking import HeadTracker

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh

LOST = "tracking lost"
TITLE_NS = 250_000_000


class OpenXrDisplay:
    """display.Display for the headset of the active OpenXR runtime.

    Times are CLOCK_MONOTONIC's, which outlives the runtime's service; the runtime's own instants
    are converted. With an X display it has a window of its own that mirrors the left eye;
    HMDWARP_OPENXR_GRAPHICS=egl or glx in the environment insists on one of the two ways to draw.
    Errors: MachineError that says which of loader, runtime, service, headset or extension is
    missing.
    """

    name = "openxr"
    headset = None  # the runtime knows its lens, and corrects it
    distorts = WHO

    def __init__(self, options: DisplayOptions) -> None:
        self._options, self._calls = options, Calls(options.watching)
        self.eyes, self.source = RuntimeEyes(), HeadTracker()
        self._graphics: Graphics | None = None
        self._presenter: Presenter | None = None
        self._connection: Connection | None = None
        self._titled_ns = 0
        try:
            self._open()
        except BaseException:
            self.close()
            raise
        self.gpu = self._graphics.gpu

    def _open(self) -> None:
        """Open everything, or all but the graphics where they exist already."""
        self._connection = made = connect(self._calls, self._drawn_with, self.source, self._options.controls)
        self.about = {**made.instance.about, "graphics": self._graphics.name, "space": made.spaces.name}
        self.size = self._options.size or made.recommended
        self.takes_depth = WHO if made.has_depth and self._options.depth_layer else ""
        self._calls.stage = "running"
        made.settle(self._calls, self.eyes)
        made.make_pictures(self._calls, self._graphics, self.size, bool(self.takes_depth))
        self._period_ns = made.frames.state.predicted_display_period
        self.rate_hz = 1e9 / self._period_ns
        self._last_shown_ns = 0

    def _drawn_with(self, instance: Instance) -> Graphics:
        if self._graphics is None:
            self._graphics = open_graphics(instance, self._options.controls)
            self._presenter = Presenter(self._graphics.gpu)
        return self._graphics

    def now_ns(self) -> int:
        """Return this instant."""
        return time.monotonic_ns()

    def wait(self) -> Tick | None:
        """Wait as Display.wait; return None after 10 ms while the runtime wants no frames."""
        made, state = self._connection, self._connection.frames.state
        if self._graphics.mirror is not None:
            self._graphics.mirror.poll()
        made.session.poll()
        if not made.session.running:
            self._last_shown_ns = 0
            time.sleep(IDLE_S)
            return None
        made.frames.begin()
        if made.actions is not None:
            made.actions.sync(time.monotonic_ns())
        self.source.offset_ns = made.instance.offset_ns()
        self.eyes.locate(self._calls, made.session.handle, made.spaces.head, state.predicted_display_time)
        shown_ns = state.predicted_display_time - self.source.offset_ns
        self._period_ns = state.predicted_display_period or self._period_ns
        missed = self._missed(shown_ns)
        return Tick(shown_ns, self._period_ns, bool(state.should_render), LOST if self.source.lost else "", missed)

    def _missed(self, shown_ns: int) -> int:
        """Return missed refreshes of the display.

        A runtime may report a longer period to slow programs (Monado does); those refreshes go by
        all the same.
        """
        last, self._last_shown_ns = self._last_shown_ns, shown_ns
        return max(0, round((shown_ns - last) * 1e-9 * self.rate_hz) - 1) if last else 0

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Hand over as Display.show; returns when xrEndFrame has returned."""
        made = self._connection
        if made.frames.state.should_render and (refresh is not None or label):
            self._draw(refresh, label)
            made.frames.end(made.projection.struct)
        else:
            made.frames.end()
        submitted_ns = time.monotonic_ns()
        if self._graphics.mirror is not None:
            self._graphics.mirror.show(self._presenter, refresh.eyes[0].panel if refresh is not None else None, label)
        return submitted_ns

    def _draw(self, refresh: Refresh | None, label: Label) -> None:
        made, notice = self._connection, self._presenter.notice(label)
        for eye, view in enumerate(self._views(refresh)):
            result = refresh.eyes[eye] if refresh is not None else None
            colour = made.colours[eye]
            into = colour.acquire()
            # A float format holds linear light, which the switch leaves alone.
            self._presenter.show(
                result.panel if result else None,
                into,
                (0, 0, *colour.size),
                hardware_srgb=True,
                notice=notice,
                eye=view,
            )
            colour.release()
            has_depth = bool(made.depths) and result is not None and result.inverse_depth is not None
            if has_depth:
                self._presenter.depth(result.inverse_depth, made.depths[eye].acquire(), NEAR_M)
                made.depths[eye].release()
            made.projection.fill(eye, view, has_depth)

    def _views(self, refresh: Refresh | None) -> Sequence[View]:
        """Return the views the pictures were made for; for a black picture, this refresh's."""
        if refresh is not None:
            return [eye.view for eye in refresh.eyes]
        return self.eyes.views(self.source.head_at(self._last_shown_ns).pose)

    def look(self, view: str) -> None:
        """Do nothing: a headset has one view."""

    def restart(self) -> None:
        """Do nothing: the head goes on."""

    def commands(self) -> Sequence[Command]:
        """Return the window's keys, where there is one, and the controllers' buttons."""
        made, mirror = self._connection, self._graphics.mirror
        by_hand = made.actions.commands() if made is not None and made.actions is not None else ()
        return [*(mirror.commands() if mirror is not None else ()), *by_hand]

    def tell(self, status: object) -> None:
        """Show the status in the window's title, four times a second."""
        now_ns = time.monotonic_ns()
        if self._graphics.mirror is not None and now_ns - self._titled_ns >= TITLE_NS:
            self._titled_ns = now_ns
            self._graphics.mirror.title(status.title())

    def reopen(self) -> bool:
        """Release the old session and try again, as Display.reopen.

        Errors: Closed, for a closed window.
        """
        self._disconnect()
        if self._graphics.mirror is not None:
            self._graphics.mirror.poll()
        try:
            self._open()
        except MachineError:
            self._disconnect()
            return False
        return True

    def _disconnect(self) -> None:
        made, self._connection = self._connection, None
        if made is not None:
            made.close()

    def close(self) -> None:
        """Release everything, as Display.close."""
        self._disconnect()
        graphics, self._graphics = self._graphics, None
        if graphics is not None:
            if self._presenter is not None:
                self._presenter.close()
            graphics.close()
