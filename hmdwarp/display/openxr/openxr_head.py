"""Head tracking alone, for recording.

Without pictures where the runtime allows it, else with empty frames.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext

import xr

from ...errors import MachineError
from ...poses import PoseSample
from .. import Closed
from .connection import IDLE_S, READY_S, Connected, connect
from .graphics import Graphics, open_graphics
from .runtime import (
    HEADLESS_EXTENSION,
    RATE_EXTENSION,
    WITHOUT_PICTURES,
    Calls,
    Instance,
    Session,
    offered_extensions,
    open_instance,
)
from .tracking import HeadTracker, RuntimeEyes, Spaces

DEFAULT_HZ = 90.0  # the rate of most headsets


class OpenXrHead(Connected):
    """A PoseSource on CLOCK_MONOTONIC, for the headset of the active OpenXR runtime.

    Call poll() at least every tenth of a second. Use as a context manager, or call close(). about:
    runtime, runtime_version, headset, graphics ("none" where none was needed), space. rate_hz: of
    the display, 90 where the runtime does not report it. watching: as in DisplayOptions.
    Errors: MachineError naming which of loader, runtime, service, headset or extension is missing.
    """

    name = "openxr"

    def __init__(self, watching: Callable[[str], AbstractContextManager[object]] = nullcontext) -> None:
        self._calls, self._tracker = Calls(watching), HeadTracker()
        self._graphics: Graphics | None = None
        self._cleanup = ExitStack()
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        if HEADLESS_EXTENSION in offered_extensions(self._calls):
            self._open_headless()
        else:
            self._open_with_frames()

    def _open_headless(self) -> None:
        instance = open_instance(self._calls, WITHOUT_PICTURES)
        self._cleanup.callback(instance.destroy)
        self._session = Session(self._calls, instance, None)
        self._cleanup.callback(self._session.destroy)
        spaces = Spaces(self._calls, instance, self._session.handle)
        self._tracker.attach(self._calls, instance, spaces)
        self._session.on_world_change = self._tracker.world_changes
        self._instance, self.about = instance, {**instance.about, "graphics": "none", "space": spaces.name}
        self._calls.stage = "running"
        self._until_running()
        self.rate_hz = self._reported_rate() or DEFAULT_HZ

    def _open_with_frames(self) -> None:
        self._connection = made = connect(self._calls, self._graphics_for, self._tracker)
        self._instance, self._session = made.instance, made.session
        name = self._graphics.name if self._graphics is not None else "none"
        self.about = {**made.instance.about, "graphics": name, "space": made.spaces.name}
        self._calls.stage = "running"
        made.settle(self._calls, RuntimeEyes())
        self.rate_hz = 1e9 / made.frames.state.predicted_display_period

    def _graphics_for(self, instance: Instance) -> Graphics:
        self._graphics = self._graphics or open_graphics(instance)
        return self._graphics

    def _until_running(self) -> None:
        until = time.monotonic() + READY_S
        while not self.poll():
            if time.monotonic() > until:
                raise MachineError(f"{self._calls.name} did not begin a session within {READY_S:g} s: wake the headset")
            time.sleep(IDLE_S)

    def _reported_rate(self) -> float:
        if RATE_EXTENSION not in self._instance.extensions:
            return 0.0
        try:
            rate_hz = xr.get_display_refresh_rate_fb(self._session.handle)
            return float(getattr(rate_hz, "value", rate_hz))
        except xr.XrException:  # a display without any, if no pictures are submitted
            return 0.0

    def now_ns(self) -> int:
        """Return the current time."""
        return time.monotonic_ns()

    def poll(self) -> bool:
        """Process the runtime's events; return whether poses are available.

        Where frames are needed for that it submits an empty one, which takes until the next
        refresh.
        Errors: Closed; Lost.
        """
        if self._graphics is not None and self._graphics.mirror is not None:
            self._graphics.mirror.poll()
        self._session.poll()
        if not self._session.running:
            return False
        self._tracker.offset_ns = self._instance.offset_ns()
        if self._connection is not None:
            self._connection.frames.begin()
            self._connection.frames.end()
        return True

    def start(self) -> None:
        """Do nothing: it is already running."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the head pose as PoseSource.head_at: HELD while tracking is lost.

        Errors: Lost.
        """
        return self._tracker.head_at(time_ns)

    @property
    def lost(self) -> bool:
        """Whether tracking was lost at the last reading."""
        return self._tracker.lost

    def reopen(self) -> bool:
        """Reconnect after Lost; return whether the runtime is back."""
        self._disconnect()
        try:
            self._open()
        except (MachineError, Closed):
            self._disconnect()
            return False
        return True

    def _disconnect(self) -> None:
        super()._disconnect()
        self._cleanup.close()

    def close(self) -> None:
        """Release everything. Safe to call twice."""
        self._disconnect()
        graphics, self._graphics = self._graphics, None
        if graphics is not None:
            graphics.close()

    def __enter__(self) -> OpenXrHead:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
