"""The live driver: the loop, once for each refresh of a display, until somebody ends it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from ...display import Closed, Command, Display
from .changes import choices, values
from .commands import CommandHandler
from .driver import AfterRefresh, Driver, FrameHandler, Say
from .ending import Ending
from .host import Stage, checked_scene
from .log import LiveLog, LiveResult
from .openings import open_display
from .options import LiveOptions
from .recorder import Recorder
from .watchdog import Watchdog


def live(options: LiveOptions, say: Say = lambda text: None, after: AfterRefresh = lambda number: None) -> LiveResult:
    """Show it until it is ended: by the window, by the runtime, by Ctrl-C, or after the frames or seconds asked for.

    say: gets a sentence now and then. after(number): called after each refresh that showed a picture, counted from 1.
    Errors: InputError and its kin for what was asked; MachineError where there is no headset and no window, and where a lost headset
    does not come back. What was recorded and logged until then is written in any case.
    """
    scene = checked_scene(options)
    with ExitStack() as stack:
        ending = stack.enter_context(
            Ending(options.seconds, options.frames)
        )  # outermost: a signal ends the program when all is written
        recorder = stack.enter_context(Recorder(options.record, say)) if options.record is not None else None
        log = stack.enter_context(LiveLog(options))
        watchdog = stack.enter_context(Watchdog(options.hang_s, _last_words(recorder, log)))
        display = stack.enter_context(_closing(open_display(options, watchdog.watching, say)))
        ending.now_ns = display.now_ns
        stage = Stage(display, options, scene)
        stack.callback(stage.close)
        stack.callback(log.leave)
        if recorder is not None:
            recorder.begin(display)
        log.begin(display, stage)
        try:
            Driver(display, stage, ending, say).run(_Free(stage, log, ending, say), log, recorder, after)
        except Closed as closed:
            say(str(closed))
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


class _Free(FrameHandler):
    """Whoever looks may change everything, until as much was shown as was asked for."""

    pictures = True

    def __init__(self, stage: Stage, log: LiveLog, ending: Ending, say: Say) -> None:
        self._log, self._ending, self._stage = log, ending, stage
        self._obeying = CommandHandler(stage, say)
        self._status = log.status
        self._status.choices = choices()
        self._take_values()

    def over(self) -> bool:
        """As Watch.over."""
        return self._ending.due(self._log.count)

    def label(self) -> str:
        """What was refused last, for a while."""
        return self._obeying.refusal

    def obey(self, commands: Sequence[Command]) -> bool:
        """As Watch.obey."""
        changed = self._obeying.obey(commands)
        if changed:
            self._take_values()
        return changed

    def _take_values(self) -> None:
        self._status.values = values(self._stage.options)
