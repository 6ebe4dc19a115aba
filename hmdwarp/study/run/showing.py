"""Everything around one trial: its pipeline, built for it alone, its log, its recording, and what the store is told of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from typing import Any

import attrs

from ...display import Label
from ...run.live import LiveOptions
from ...run.live.driver import Driver
from ...run.live.ending import Ending
from ...run.live.host import Stage
from ...run.live.log import LiveLog
from ...run.live.recorder import Recorder
from ...scenes import Scene
from ..steps import Show
from ..store import Showing
from .actual import actual_of
from .room import Room
from .trial import Trial

BY = "hmdwarp study"


@attrs.define(eq=False)
class Shower:
    """options_of: of a live run, for a step. plate_of: what stands in the black before it. under_way: as Trial has it. scenes:
    all that are shown, by name.

    recording: the one under way, None between trials; for last words.
    """

    room: Room
    ending: Ending
    options_of: Callable[[Show], LiveOptions]
    plate_of: Callable[[Show], Label]
    under_way: float
    scenes: Mapping[str, Scene]
    recording: Recorder | None = None

    def show(self, step: Show, plated_ns: int) -> tuple[Showing, Trial]:
        """From the black before it, whose plate has been there since plated_ns, to its last picture, or to what ended it before. The
        showing is in the store when this returns, and so it is, incomplete, when anything is raised out of it.

        Errors: Closed, Lost, as Driver.run; InputError and MachineError, as the store, the recorder and the pipeline have them.
        """
        room = self.room
        settings = dict(step.condition.settings)
        showing = room.store.begin_showing(room.session, step, settings)
        path = room.store.traces / showing.trace
        watch: Trial | None = None
        log = LiveLog(attrs.evolve(self.options_of(step), record=path, seconds=None, frames=None, out=None))
        complete = False
        try:
            with ExitStack() as stack:
                stack.enter_context(log)
                recorder = self.recording = stack.enter_context(Recorder(path, by=BY))
                stage = self._stage(step)
                stack.callback(stage.close)
                stack.callback(log.leave)
                recorder.begin(room.display)
                log.begin(room.display, stage)
                watch = Trial(room, step, self.plate_of(step), plated_ns, log, self.under_way)
                log.status.heading = room.status.heading
                Driver(room.display, stage, self.ending, room.say).run(watch, log, recorder)
            complete = watch.finished() and not watch.intent
        except BaseException:
            with suppress(Exception):  # what went wrong is what must be heard
                self._ended(showing, log, complete=False)
            raise
        finally:
            self.recording = None
        return self._ended(showing, log, complete), watch

    def _stage(self, step: Show) -> Stage:
        """New for every trial, even with the settings of the one before: nothing of that is remembered."""
        options = self.options_of(step)
        return Stage(self.room.display, options, self.scenes[options.scene])

    def _ended(self, showing: Showing, log: LiveLog, complete: bool) -> Showing:
        room = self.room
        actual: dict[str, Any] = actual_of(log.result().summary, log.column)
        return room.store.end_showing(room.session, showing, actual, complete)
