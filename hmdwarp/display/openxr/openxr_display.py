"""A headset as a display.

The runtime determines refresh times and eye views, and receives the pictures. Panels may be its
own quad layers: it composes them at its newest pose.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...base import HmdwarpError, MachineError
from ...pipeline import Refresh
from .. import Command, DisplayOptions, Label, Status, Tick
from ..present import Presenter
from .connection import IDLE_S, NEAR_M, Connection, Projection
from .diagnosis import RUNTIME_LABEL
from .graphics import Graphics, open_graphics
from .runtime import Calls, Instance
from .tracking import HeadTracker, RuntimeEyes

if TYPE_CHECKING:
    from .mirror_window import Mirror

LOST = "tracking lost"


class OpenXrDisplay:
    """display.Display for the headset of the active OpenXR runtime.

    Times are on CLOCK_MONOTONIC, which outlives the runtime's service; the runtime's own times are
    converted. With an X display it has a window that mirrors the left eye; the environment variable
    HMDWARP_OPENXR_GRAPHICS, egl or glx, forces one way to draw.
    Errors: MachineError naming which of loader, runtime, service, headset or extension is missing.
    """

    name = "openxr"
    headset = None  # the runtime knows its lens, and corrects it
    distorts = takes_panels = RUNTIME_LABEL

    def __init__(self, options: DisplayOptions) -> None:
        self._options, self._calls = options, Calls(options.watching)
        self.eyes, self.source = RuntimeEyes(), HeadTracker()
        # Outlasts a lost runtime; None before the first connection and after close().
        self._graphics: Graphics | None = None
        self._connection: Connection | None = None  # None while the runtime's service is away
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self._connection = made = Connection(self._calls, self._graphics_for, self.source, self.eyes, self._options)
        self.about = {**made.instance.about, "graphics": made.graphics.name, "space": made.spaces.name}
        self.size, self.takes_depth = made.size, RUNTIME_LABEL if made.pictures.depths else ""
        self._period_ns: int = made.frames.state.predicted_display_period
        self.rate_hz = 1e9 / self._period_ns
        self._last_shown_ns = 0

    def _graphics_for(self, instance: Instance) -> Graphics:
        if self._graphics is None:
            self._graphics = graphics = open_graphics(instance, self._options.controls)
            self.gpu, self._presenter = graphics.gpu, Presenter(graphics.gpu)
        return self._graphics

    def _connected(self) -> Connection:
        if self._connection is None:
            raise HmdwarpError("the headset's display is not connected: reopen() first")
        return self._connection

    def _disconnect(self) -> None:
        made, self._connection = self._connection, None
        if made is not None:
            made.close()

    @property
    def _mirror(self) -> Mirror | None:
        return None if self._graphics is None else self._graphics.mirror

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self) -> Tick | None:
        """Wait as Display.wait; return None after 10 ms while the runtime wants no frames."""
        made = self._connected()
        state = made.frames.state
        if self._mirror is not None:
            self._mirror.poll()
        made.session.poll()
        if not made.session.running:
            self._last_shown_ns = 0
            time.sleep(IDLE_S)
            return None
        made.frames.begin()
        if made.actions is not None:
            made.actions.sync(time.monotonic_ns(), state.predicted_display_time)
        self.source.offset_ns = made.instance.offset_ns()
        self.eyes.locate(self._calls, made.session.handle, made.spaces.head, state.predicted_display_time)
        shown_ns = state.predicted_display_time - self.source.offset_ns
        self._period_ns = state.predicted_display_period or self._period_ns
        # Of the display: a runtime may report a longer period to slow programs (Monado does).
        last, self._last_shown_ns = self._last_shown_ns, shown_ns
        missed = max(0, round((shown_ns - last) * 1e-9 * self.rate_hz) - 1) if last else 0
        return Tick(shown_ns, self._period_ns, bool(state.should_render), LOST if self.source.lost else "", missed)

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Submit as Display.show, by the time that xrEndFrame has returned."""
        made = self._connected()
        if made.frames.state.should_render and (refresh is not None or label):
            panels = refresh.eyes[0].panels if refresh is not None else ()
            made.frames.end(self._draw(made.pictures, refresh, label), *(made.quads.layers(panels) if panels else ()))
        else:
            made.frames.end()
        submitted_ns = time.monotonic_ns()
        if self._mirror is not None:
            self._mirror.show(self._presenter, refresh.eyes[0].panel if refresh is not None else None, label)
        return submitted_ns

    def _draw(self, pictures: Projection, refresh: Refresh | None, label: Label) -> ctypes.Structure:
        """Draw both eyes; return the layer to submit."""
        presenter = self._presenter
        notice, black = presenter.notice(label), self.eyes.views(self.source.head_at(self._last_shown_ns).pose)
        for eye, colour in enumerate(pictures.colours):
            result = refresh.eyes[eye] if refresh is not None else None
            view, panel = (result.view, result.panel) if result is not None else (black[eye], None)
            # A float format stores linear light and ignores hardware_srgb.
            whole = (0, 0, *colour.size)
            presenter.show(panel, colour.acquire(), whole, hardware_srgb=True, notice=notice, eye=view)
            colour.release()
            inverse_depth = result.inverse_depth if result is not None and pictures.depths else None
            if inverse_depth is not None:
                depth = pictures.depths[eye]
                presenter.depth(inverse_depth, depth.acquire(), NEAR_M)
                depth.release()
            pictures.fill(eye, view, inverse_depth is not None)
        struct: ctypes.Structure = pictures.struct
        return struct

    def set_view(self, view: str) -> None:
        """Do nothing: a headset has one view."""

    def restart(self) -> None:
        """Do nothing: the head is live."""

    def commands(self) -> Sequence[Command]:
        made, mirror = self._connection, self._mirror
        by_controllers = made.actions.commands() if made is not None and made.actions is not None else ()
        return [*(mirror.commands() if mirror is not None else ()), *by_controllers]

    def show_status(self, status: Status) -> None:
        if self._mirror is not None:
            self._mirror.show_status(status)

    def reopen(self) -> bool:
        """Release the old session and connect again, as Display.reopen. Errors: Closed."""
        self._disconnect()
        if self._mirror is not None:
            self._mirror.poll()
        try:
            self._open()
        except MachineError:
            self._disconnect()
            return False
        return True

    def close(self) -> None:
        self._disconnect()
        graphics, self._graphics = self._graphics, None
        if graphics is not None:
            self._presenter.close()  # before the context it draws in
            graphics.close()
