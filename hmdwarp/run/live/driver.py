"""The loop on a display, once a refresh: for a run that whoever looks may change, and for a study, where nobody may."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

from ...display import Command, Display, Label, Lost, Tick
from .ending import Ending
from .garbage import GarbageControl
from .host import Stage
from .log import LiveLog
from .recorder import Recorder
from .returning import come_back

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh

Say = Callable[[str], None]
AfterRefresh = Callable[[int], None]
WAITING = "waiting for the first frame"


class FrameHandler(Protocol):
    """Whoever decides what a stretch of refreshes is: what is written over its pictures, what a command does, when it is over.

    pictures: whether the scene is shown; without, the display stays black but for the label, and nothing is logged. ahead: whether, while
    there are none, the server draws all the same and the passes run: frames are under way and everything is warm when pictures begin.
    """

    pictures: bool
    ahead: bool = False

    def over(self) -> bool:
        """Whether to stop now; asked before each refresh."""

    def label(self) -> Label:
        """What is written over the picture, "" for nothing."""

    def obey(self, commands: Sequence[Command]) -> bool:
        """Do what was asked for; whether the options of the run are others afterwards."""

    def arrived(self, refresh: Refresh) -> None:
        """A frame was there at this refresh, whether or not it was shown."""

    def on_display_lost(self, why: str) -> None:
        """The display went away just now. Whether it comes back is not known yet."""


class Driver:
    """One display and its stage. A stretch may have a log and a recorder of its own.

    ending: a signal ends every stretch. say: gets a sentence now and then. A lost display is waited for as long as the stage's options say.
    """

    def __init__(self, display: Display, stage: Stage, ending: Ending, say: Say) -> None:
        self._display, self._stage, self._ending, self._say = display, stage, ending, say

    def run(
        self,
        watch: FrameHandler,
        log: LiveLog | None = None,
        recorder: Recorder | None = None,
        after: AfterRefresh = lambda number: None,
    ) -> None:
        """Until `watch` is over or a signal came. after(number): after each refresh that showed a picture, counted from 1.

        Errors: Closed, when nobody looks any more; Lost, when the display went away and did not come back in time.
        """
        stretch = _Stretch(self._display, self._stage, self._ending, self._say, watch, log, recorder, after)
        with GarbageControl(self._stage.options.collect and (watch.pictures or watch.ahead)) as tidying:
            while self._ending.asked is None and not watch.over():
                stretch.once(tidying)


class _Stretch:
    def __init__(
        self,
        display: Display,
        stage: Stage,
        ending: Ending,
        say: Say,
        watch: FrameHandler,
        log: LiveLog | None,
        recorder: Recorder | None,
        after: AfterRefresh,
    ) -> None:
        self._display, self._stage, self._ending, self._say = display, stage, ending, say
        self._watch, self._log, self._recorder, self._after = watch, log, recorder, after
        self._count = 0

    def once(self, tidying: GarbageControl) -> None:
        """One refresh, or a wait for one."""
        try:
            tick = self._display.wait()
            if tick is not None:
                self._refresh(tick)
                tidying.between()
            if self._watch.obey(self._display.commands()) and self._log is not None:
                self._log.changed(self._stage)
        except Lost as lost:
            self._come_back(lost)

    def _refresh(self, tick: Tick) -> None:
        watch = self._watch
        refresh = self._made(tick) if tick.render and (watch.pictures or watch.ahead) else None
        if not watch.pictures:
            self._display.show(None, watch.label())  # a question stays where it is, whatever the tracking does
            return
        label = tick.notice or watch.label() or (WAITING if tick.render and refresh is None else "")
        submitted_ns = self._display.show(refresh, label)
        if self._log is not None:
            self._log.add(tick, refresh, submitted_ns, label if isinstance(label, str) else "")
        if refresh is not None:
            self._shown(refresh)

    def _made(self, tick: Tick) -> Refresh | None:
        self._stage.fit()
        loop = self._stage.loop
        loop.draw(self._display.now_ns())
        refresh = loop.show(tick.shown_ns)
        if refresh is not None:
            self._watch.arrived(refresh)
        return refresh

    def _shown(self, refresh: Refresh) -> None:
        if self._recorder is not None:
            self._recorder.add(refresh.head)
        self._count += 1
        self._after(self._count)
        if self._log is not None:
            self._display.tell(self._log.status)

    def _come_back(self, lost: Lost) -> None:
        """Wait until the display is there again. Errors: Lost, once that has taken too long."""
        self._watch.on_display_lost(str(lost))
        if self._recorder is not None:
            self._recorder.flush()
        if self._log is not None:
            self._log.on_display_lost(str(lost))
        if (
            come_back(self._display.reopen, lost, self._stage.options.reconnect_s, self._ending, self._say)
            and self._log is not None
        ):
            self._log.came_back()
