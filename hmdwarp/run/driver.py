"""The loop driven by a display, once a refresh; for live runs and for studies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from ..display import Command, Display, Label, Lost, Tick
from ..pipeline.loop import Refresh
from .ending import Ending, GarbageControl, come_back
from .host import PipelineHost
from .live_log import LiveLog
from .recorder import Recorder

Say = Callable[[str], None]
AfterRefresh = Callable[[int], None]
WAITING = "waiting for the first frame"


class FrameHandler(Protocol):
    """The behaviour of a stretch of refreshes: its label, its commands, its end."""

    # Whether the scene is shown. If not, the display stays black but for the label, and nothing is
    # logged.
    pictures: bool
    # Whether, without pictures, the server and the passes run all the same: then frames are in
    # transit and caches are warm when pictures begin.
    ahead: bool = False

    def over(self) -> bool:
        """Return whether to stop now; called before each refresh."""
        ...

    def label(self) -> Label:
        """Return the text over the picture, "" for none."""
        ...

    def handle(self, commands: Sequence[Command]) -> bool:
        """Apply the commands; return whether the options of the run changed."""
        ...

    def arrived(self, refresh: Refresh) -> None:
        """Handle a refresh that has a frame, shown or not."""
        ...

    def on_display_lost(self, why: str) -> None:
        """Handle the loss of the display; it may come back."""
        ...


class Driver:
    """Drive one display and its pipeline. A stretch may have its own log and recorder.

    Waits for a lost display as long as the options allow.
    """

    def __init__(self, display: Display, host: PipelineHost, ending: Ending, say: Say) -> None:
        """Drive a display.

        ending: a signal ends every stretch. say: called with a sentence for the user.
        """
        self._display, self._host, self._ending, self._say = display, host, ending, say

    def run(
        self,
        handler: FrameHandler,
        log: LiveLog | None = None,
        recorder: Recorder | None = None,
        after: AfterRefresh = lambda number: None,
    ) -> None:
        """Run until `handler` is over or a signal arrives.

        after(number): called after each refresh that showed a picture, counted from 1.
        Errors: Closed, when the window or session was closed; Lost, when the display did not come
        back in time.
        """
        number = 0
        with GarbageControl(self._host.options.collect and (handler.pictures or handler.ahead)) as garbage:
            while self._ending.asked is None and not handler.over():
                try:
                    tick = self._display.wait()
                    if tick is not None:
                        refresh = self._refresh(tick, handler, log)
                        if refresh is not None:
                            if recorder is not None:
                                recorder.add(refresh.head)
                            number += 1
                            after(number)
                            if log is not None:
                                self._display.show_status(log.status)
                        garbage.between()
                    if handler.handle(self._display.commands()) and log is not None:
                        log.changed(self._host)
                except Lost as lost:
                    self._come_back(lost, handler, log, recorder)

    def _refresh(self, tick: Tick, handler: FrameHandler, log: LiveLog | None) -> Refresh | None:
        """Submit a picture, and return it if one was shown."""
        refresh = self._made(tick, handler) if tick.render and (handler.pictures or handler.ahead) else None
        if not handler.pictures:
            # A question stays in place, even while tracking is lost.
            self._display.show(None, handler.label())
            return None
        label = tick.notice or handler.label() or (WAITING if tick.render and refresh is None else "")
        submitted_ns = self._display.show(refresh, label)
        if log is not None:
            log.add(tick, refresh, submitted_ns, label if isinstance(label, str) else "")
        return refresh

    def _made(self, tick: Tick, handler: FrameHandler) -> Refresh | None:
        self._host.fit()
        loop = self._host.loop
        loop.draw(self._display.now_ns())
        refresh = loop.show(tick.shown_ns)
        if refresh is not None:
            handler.arrived(refresh)
        return refresh

    def _come_back(self, lost: Lost, handler: FrameHandler, log: LiveLog | None, recorder: Recorder | None) -> None:
        """Wait until the display is back. Errors: Lost, when that takes too long."""
        handler.on_display_lost(str(lost))
        if recorder is not None:
            recorder.flush()
        if log is not None:
            log.on_display_lost(str(lost))
        back = come_back(self._display.reopen, lost, self._host.options.reconnect_s, self._ending, self._say)
        if back and log is not None:
            log.came_back()
