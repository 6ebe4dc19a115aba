"""The live driver: the loop, once for each refresh of a display, until somebody ends it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from ..display import Closed, Display, Lost, Tick
from .changes import choices, values
from .ending import Ending
from .log import LiveLog, LiveResult
from .obeying import Obeying
from .openings import open_display
from .options import LiveOptions
from .recorder import Recorder
from .returning import come_back
from .stage import Stage, checked_scene
from .tidying import Tidying
from .watchdog import Watchdog

Say = Callable[[str], None]
AfterRefresh = Callable[[int], None]
WAITING = "waiting for the first frame"


def live(options: LiveOptions, say: Say = lambda text: None, after: AfterRefresh = lambda number: None) -> LiveResult:
    """Show it until it is ended: by the window, by the runtime, by Ctrl-C, or after the frames or seconds asked for.

    say: gets a sentence now and then. after(number): called after each refresh that showed a picture, counted from 1.
    Errors: InputError and its kin for what was asked; MachineError where there is no headset and no window, and where a lost headset
    does not come back. What was recorded and logged until then is written in any case.
    """
    scene = checked_scene(options)
    with ExitStack() as stack:
        ending = stack.enter_context(Ending(options.seconds, options.frames))  # outermost: a signal ends the program when all is written
        recorder = stack.enter_context(Recorder(options.record, say)) if options.record is not None else None
        log = stack.enter_context(LiveLog(options))
        watchdog = stack.enter_context(Watchdog(options.hang_s, _last_words(recorder, log)))
        display = stack.enter_context(_closing(open_display(options, watchdog.watching, say)))
        stage = Stage(display, options, scene)
        stack.callback(stage.close)
        stack.callback(log.leave)
        if recorder is not None:
            recorder.begin(display)
        log.begin(display, stage)
        _Driver(display, stage, log, recorder, ending, say, after).run()
    return log.result()


def _last_words(recorder: Recorder | None, log: LiveLog) -> list[Callable[[], str]]:
    """What the watchdog does before it ends the program: the recording first, it cannot be had again."""

    def save_recording() -> str:
        return recorder.save() if recorder is not None else ""

    def save_log() -> str:
        log.finish()
        folder = log.result().folder
        return f"the log until then is in {folder}" if folder is not None else ""

    return [save_recording, save_log]


class _closing:  # noqa: N801 (as contextlib.closing, which leaves out __enter__'s type)
    def __init__(self, display: Display) -> None:
        self._display = display

    def __enter__(self) -> Display:
        return self._display

    def __exit__(self, *_: object) -> None:
        self._display.close()


class _Driver:
    def __init__(
        self, display: Display, stage: Stage, log: LiveLog, recorder: Recorder | None, ending: Ending, say: Say, after: AfterRefresh
    ) -> None:
        self._display, self._stage, self._log, self._recorder = display, stage, log, recorder
        self._ending, self._say, self._after = ending, say, after
        self._obeying = Obeying(stage, say)
        self._status = log.status
        self._status.choices = choices()
        self._take_values()

    def run(self) -> None:
        with Tidying(self._stage.options.collect) as tidying:
            try:
                while not self._ending.due(self._log.count):
                    self._once(tidying)
            except Closed as closed:
                self._say(str(closed))

    def _once(self, tidying: Tidying) -> None:
        try:
            tick = self._display.wait()
            if tick is not None:
                self._refresh(tick)
                tidying.between()
            self._obey()
        except Lost as lost:
            self._come_back(lost)

    def _refresh(self, tick: Tick) -> None:
        refresh = None
        if tick.render:
            self._stage.fit()
            loop = self._stage.loop
            loop.draw(self._display.now_ns())
            refresh = loop.show(tick.shown_ns)
        notice = tick.notice or self._obeying.refusal or (WAITING if tick.render and refresh is None else "")
        submitted_ns = self._display.show(refresh, notice)
        self._log.add(tick, refresh, submitted_ns, notice)
        if refresh is None:
            return
        if self._recorder is not None:
            self._recorder.add(refresh.head)
        self._after(self._log.count)
        self._display.tell(self._status)

    def _obey(self) -> None:
        if self._obeying.obey(self._display.commands()):
            self._take_values()
            self._log.changed(self._stage)

    def _take_values(self) -> None:
        self._status.values = values(self._stage.options)

    def _come_back(self, lost: Lost) -> None:
        """Wait until the display is there again. Errors: Lost, once that has taken too long."""
        if self._recorder is not None:
            self._recorder.flush()
        self._log.went(str(lost))
        if come_back(self._display.reopen, lost, self._stage.options.reconnect_s, self._ending, self._say):
            self._log.came_back()


