"""Trials: one condition each, on a pipeline built for it alone, with log, recording and store."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from typing import Any

import attrs

from ...display import MOVED, Command, Label
from ...errors import InputError
from ...pipeline import Refresh, SceneKey, Source
from ...run import Driver, Ending, Hand, LiveLog, LiveOptions, PipelineHost, Recorder, took_by
from ...scenes import ACTIONS, InputBook
from ..actual import actual_of
from ..design import Show
from ..dialogs.buttons import hints_for
from ..store import Showing
from .session_context import SessionContext
from .step_handlers import CONFIRMS, LOST, StepHandler
from .wording import HeadRange, number_panel

BY = "hmdwarp study"
TIME = "time"  # ended a trial, where no one did
# Least time of black with the number, before frames get under way: eyes rest, and building a
# pipeline seldom takes longer.
LEAD_S = 1.0
SETTLED_S = 0.25  # beyond the longest latency: some frames come later
PATIENCE_S = 30.0  # for the first frame


def first_picture_wait_s(latencies_ms: Sequence[float]) -> float:
    """Return how long frames are under way before the first picture, the same for all trials.

    A wait as long as the latency, or as building the pipeline, would tell the condition.
    """
    return max(latencies_ms, default=0.0) * 1e-3 + SETTLED_S


class TrialHandler(StepHandler):
    """One condition: black with its number, then the pictures, with nothing written over them.

    In the black the server draws already, so that frames are under way at the first picture as in
    the middle of a run; a recorded head starts anew that long before. The time of the trial counts
    from its first picture, on the display's clock.

    panel_ns: since when the panel lies over the black. wait_s: see first_picture_wait_s. showing:
    as it was begun. hand: None where the scene does not react.
    Errors, out of the driver: InputError where no frame arrives.
    """

    ahead = True
    phase = "showing"

    step: Show

    def __init__(
        self,
        context: SessionContext,
        step: Show,
        panel_ns: int,
        log: LiveLog,
        wait_s: float,
        showing: Showing,
        hand: Hand | None = None,
    ) -> None:
        super().__init__(context, step)
        self._hand = hand
        self._panel_ns, self._log, self._wait_s, self._showing = panel_ns, log, wait_s, showing
        self.head = HeadRange()  # of the pictures so far
        self._onset_s: float | None = None
        self._arrived = self._is_done = self._told = False
        self._restarted_ns: int | None = None
        self._first_ns: int | None = None
        self.last_shown_ns: int | None = None  # when its newest picture is seen; None before the first

    @property
    def seen_s(self) -> float:
        """Time since the first picture."""
        return self._since_s(self._first_ns)

    def _since_s(self, instant_ns: int | None) -> float:
        return 0.0 if instant_ns is None else (self.context.display.now_ns() - instant_ns) * 1e-9

    def finished(self) -> bool:
        """Return whether the trial's seconds are over, or someone ended it."""
        return self._is_done or (self._first_ns is not None and self.seen_s >= self.step.seconds)

    def label(self) -> Label:
        """Return the panel with the number, and nothing over pictures."""
        hints = hints_for(self.context.display.name)
        return "" if self.pictures else number_panel(self.step, self.context.steps, hints)

    def arrived(self, refresh: Refresh) -> None:
        """Start the trial's time at its first picture."""
        super().arrived(refresh)
        self._arrived = True
        if not self.pictures:
            return
        self.head.add(refresh.head)
        if self._hand is not None:
            self._hand.follow(refresh)
        if self._first_ns is None:
            self._first_ns = self.context.display.now_ns()
            self._onset_s = self.context.before_s + self.context.elapsed_s
            self.mark("trial_start", refresh.shown_ns, condition=self.step.condition.name)
        self.last_shown_ns = refresh.shown_ns

    def mark(self, event: str, at_ns: int, **data: object) -> None:
        """Send a marker of this showing."""
        shown = {"trial": self.step.trial, "showing": self._showing.id, "presentation": self._showing.presentation}
        self.context.mark(event, self.step, at_ns, **shown, **data)

    def figures(self) -> dict[str, Any]:
        """Return what the session adds to the figures of study/store/records.py."""
        ended_by = (self.by or TIME) if self.finished() and not self.interrupt else ""
        return {"onset_s": self._onset_s, "ended_by": ended_by, **self.head.figures()}

    def take(self, by: str, command: Command) -> None:
        """End a trial that is shown until the participant is done; no command changes another.

        In the black before the first picture there is nothing to end, or to act upon.
        """
        if self._first_ns is not None and command.control in ACTIONS:
            if self._hand is not None:
                self._hand.act(command)
            elif command.hand is None and not self._told:  # nothing may stand over the picture
                self._told = True
                self.context.say(f"{command.control}: the scene of this trial does not react to what people do")
        if self._first_ns is None or command.control not in CONFIRMS:
            return
        if self.step.until_done:
            self.by, self._is_done = by, True

    def handle(self, commands: Sequence[Command]) -> bool:
        """Carry out the commands, and lead from the black to the pictures.

        A button of a controller that acts in the scene confirms nothing.
        """
        if self._hand is not None and any(one.hand is not None and one.value != MOVED for one in commands):
            commands = [command for command in commands if command.control != "confirm"]
        super().handle(commands)
        if not self.pictures:
            self._lead()
        return False

    def _lead(self) -> None:
        if self._restarted_ns is None:
            if self._since_s(self._panel_ns) >= LEAD_S:
                self.context.display.restart()
                self._restarted_ns, self._arrived = self.context.display.now_ns(), False
            return
        over_s = self._since_s(self._restarted_ns) - self._wait_s
        self.pictures = self._arrived and over_s >= 0
        if not self._arrived and over_s >= PATIENCE_S:
            raise InputError(
                f"{self.step.key}: no frame came within {PATIENCE_S:g} s: see what loss and bandwidth let through"
            )

    def on_display_lost(self, why: str) -> None:
        """End the trial; it is shown again, as a rating must be about an undisturbed one."""
        super().on_display_lost(why)
        self.interrupt = LOST

    def describe(self) -> Mapping[str, Any]:
        """Return the times and the frame rate; the age of frames would tell the condition."""
        status = self._log.status
        return {
            "phase": self.phase,
            "left_s": self.step.seconds - self.seen_s,
            "seen_s": self.seen_s if self.step.until_done else None,
            "rate_hz": status.rate_hz,
            "missed": status.missed,
            "condition": self.step.condition.name if self.context.tells_condition else "",
        }


@attrs.define(eq=False)
class TrialRunner:
    """Runs trials, one at a time."""

    context: SessionContext
    ending: Ending
    options_of: Callable[[Show], LiveOptions]  # of the live run that a step is
    wait_s: float  # see first_picture_wait_s
    sources: Mapping[SceneKey, Source]  # all that are shown
    recording: Recorder | None = None  # the one under way, None between trials

    def run(self, step: Show, panel_ns: int) -> tuple[Showing, TrialHandler]:
        """Run a trial from the black before it to its last picture, or to what ended it before.

        panel_ns: since when the panel before it is shown. The showing is in the store when this
        returns, and also, as incomplete, when an error leaves it.

        Errors: Closed, Lost, as Driver.run; InputError and MachineError of store, recorder and
        pipeline.
        """
        context = self.context
        options = self.options_of(step)
        source = self.sources[options.scene_key]
        options = source.fitted(options)
        showing = context.store.begin_showing(context.session, step, dict(step.condition.settings))
        path = context.store.traces / showing.trace
        log = LiveLog(attrs.evolve(options, record=path, seconds=None, pictures=None, out=None))
        handler: TrialHandler | None = None
        complete = False
        try:
            with ExitStack() as stack:
                stack.enter_context(log)
                recorder = self.recording = stack.enter_context(Recorder(path, by=BY))
                host = PipelineHost(context.display, options, source)  # a new one: it remembers nothing
                stack.callback(host.close)
                stack.callback(log.leave)
                recorder.begin(context.display.about, context.display.rate_hz)
                log.begin(context.display, host)
                hand = None
                if source.scene.inputs is not None:
                    source.scene.inputs.book = InputBook()  # as if nobody had ever been there
                    hand = Hand(host, context.display.now_ns, took_by(recorder, log))
                handler = TrialHandler(context, step, panel_ns, log, self.wait_s, showing, hand)
                log.status.heading = context.title(step)
                Driver(context.display, host, self.ending, context.say).run(handler, log, recorder)
            complete = handler.finished() and not handler.interrupt
        except BaseException:
            with suppress(Exception):  # the first error is the one to report
                self._end(showing, log, handler, complete=False)
            raise
        finally:
            self.recording = None
        return self._end(showing, log, handler, complete), handler

    def _end(self, showing: Showing, log: LiveLog, handler: TrialHandler | None, complete: bool) -> Showing:
        actual = actual_of(log.result().summary, log.column) | ({} if handler is None else handler.figures())
        ended = self.context.store.end_showing(self.context.session, showing, actual, complete)
        if handler is not None and handler.last_shown_ns is not None:
            handler.mark("trial_end", handler.last_shown_ns, complete=complete)
        return ended
