"""Runner of a session: its steps one after the other, with everything that may come in between."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from typing import Any, TypeVar

import attrs

from ...base import InputError
from ...display import MOVED, Closed, Command, Label
from ...pipeline import Refresh, SceneKey, Source
from ...run import Driver, Ending, Hand, LiveLog, LiveOptions, PipelineHost, Recorder, took_by
from ...scenes import ACTIONS, InputBook
from ..actual import actual_of
from ..design import Ask, Page, PageStep, Pause, Read, Show, Sickness, Step, reading_s
from ..dialogs import dialog_panels as dialogs
from ..dialogs.dialog_panels import InputHints, hints_for
from ..store import COMPLETE, DECLINED, SICK, STOPPED, Answer, Showing
from . import step_handlers as handlers
from .step_handlers import DialogHandler, PanelHandler, SessionContext, StepHandler

BY = "hmdwarp study"
TIME = "time"  # ended a trial, where no one did
# Least time of black with the number, before frames get under way: eyes rest, and building a
# pipeline seldom takes longer.
LEAD_S = 1.0
SETTLED_S = 0.25  # beyond the longest latency: some frames come later
PATIENCE_S = 30.0  # for the first frame


def first_picture_wait_s(latencies_ms: Sequence[float]) -> float:
    """Return how long frames are under way first, for all trials, or it tells the condition."""
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
        self.head = handlers.HeadRange()  # of the pictures so far
        self._onset_s: float | None = None
        self._arrived = self._is_done = self._told = False
        self._restarted_ns: int | None = None
        self._first_ns: int | None = None
        self.last_shown_ns: int | None = None  # when its newest picture is seen; None before the first

    @property
    def seen_s(self) -> float:
        return self._since_s(self._first_ns)

    def _since_s(self, instant_ns: int | None) -> float:
        return 0.0 if instant_ns is None else (self.context.display.now_ns() - instant_ns) * 1e-9

    def finished(self) -> bool:
        return self._is_done or (self._first_ns is not None and self.seen_s >= self.step.seconds)

    def label(self) -> Label:
        hints = hints_for(self.context.display.name)
        return "" if self.pictures else handlers.number_panel(self.step, self.context.steps, hints)

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
        shown = {"trial": self.step.trial, "showing": self._showing.id, "presentation": self._showing.presentation}
        self.context.mark(event, self.step, at_ns, **shown, **data)

    def figures(self) -> dict[str, Any]:
        """Return what the session adds to the figures of study/actual.py."""
        ended_by = (self.by or TIME) if self.finished() and not self.interrupt else ""
        return {"onset_s": self._onset_s, "ended_by": ended_by, **self.head.figures()}

    def take(self, by: str, command: Command) -> None:
        """End a trial that lasts until done, or act in its scene; not in the black before."""
        if self._first_ns is not None and command.control in ACTIONS:
            if self._hand is not None:
                self._hand.act(command)
            elif command.hand is None and not self._told:  # nothing may stand over the picture
                self._told = True
                self.context.console.say(f"{command.control}: the scene of this trial does not react to what people do")
        if self._first_ns is None or command.control not in handlers.CONFIRMS:
            return
        if self.step.until_done:
            self.by, self._is_done = by, True

    def handle(self, commands: Sequence[Command]) -> bool:
        """Carry out the commands, and lead from the black to the pictures."""
        if self._hand is not None and any(one.hand is not None and one.value != MOVED for one in commands):
            commands = [command for command in commands if command.control != "confirm"]
        super().handle(commands)
        if self.pictures:
            return False
        if self._restarted_ns is not None:
            over_s = self._since_s(self._restarted_ns) - self._wait_s
            self.pictures = self._arrived and over_s >= 0
            if not self._arrived and over_s >= PATIENCE_S:
                wanted = "see what loss and bandwidth let through"
                raise InputError(f"{self.step.key}: no frame came within {PATIENCE_S:g} s: {wanted}")
        elif self._since_s(self._panel_ns) >= LEAD_S:
            self.context.display.restart()
            self._restarted_ns, self._arrived = self.context.display.now_ns(), False
        return False

    def on_display_lost(self, why: str) -> None:
        """End the trial; it is shown again, as a rating must be about an undisturbed one."""
        super().on_display_lost(why)
        self.interrupt = handlers.LOST

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


AFTER = "after"


def counting(answers: Iterable[Answer]) -> dict[str, Answer]:
    """Return each question's newest answer by key, in the order first answered."""
    newest: dict[str, Answer] = {}
    for answer in answers:
        known = newest.get(answer.key)
        if known is None or answer.revision > known.revision:
            newest[answer.key] = answer
    return newest


def why_sick(rule: Sickness | None, answers: Iterable[Answer]) -> str:
    """Return why the stop rule ends the session, in words; "" as long as it may go on.

    The newest answer decides, so that a slip can be corrected; "cannot say" decides nothing, nor do
    questions after all trials. A rise counts from the first answer of the session.
    """
    if rule is None:
        return ""
    asked = [found for found in counting(answers).values() if found.scale == rule.scale.name and found.phase != AFTER]
    given = [answer.value for answer in asked if answer.value is not None]
    if not given:
        return ""
    first, last = given[0], given[-1]
    title = rule.scale.title
    if rule.stop_at is not None and rule.scale.badness(last) >= rule.scale.badness(rule.stop_at):
        return f"{title}: {last:g}, and the session ends at {rule.stop_at:g}"
    if rule.rise is not None and rule.scale.badness(last) - rule.scale.badness(first) >= rule.rise:
        return f"{title}: {last:g} after {first:g} at first, and the session ends at a rise of {rule.rise:g}"
    return ""


FAREWELL_S = 3.0
# Before a pipeline is built, which takes a while: a double-buffered window shows the second panel.
_PANEL_REFRESHES = 2

H = TypeVar("H", bound=StepHandler)


class Over(Exception):  # noqa: N818 (nothing went wrong)
    """The session ends for good. args: its status, as in the store."""

    @property
    def status(self) -> str:
        return str(self.args[0])


class Interrupted(Exception):  # noqa: N818 (nothing went wrong)
    """The session ends for now, and can be resumed. args: why, in words."""


@attrs.define(eq=False)
class SessionRunner:
    """Runs the steps of a session that are not done."""

    context: SessionContext
    driver: Driver  # for everything without pictures
    ending: Ending
    hints: InputHints
    options_of: Callable[[Show], LiveOptions]  # of the live run that a step is
    wait_s: float  # see first_picture_wait_s
    sources: Mapping[SceneKey, Source]  # all that are shown
    resumed: bool = False  # whether the session began in another run of the program
    answered: Ask | None = None  # the question answered last, in other runs too
    about: dict[str, Showing] = attrs.field(factory=dict)  # showing that a question was about, by key
    seen: dict[str, Showing] = attrs.field(factory=dict)  # showing seen to its end in this run, by key
    recording: Recorder | None = None  # the one under way, None between trials
    why: str = ""  # why the session ended, where that needs words
    _just_seen: str = ""  # key of the Show that came to its end last, with nothing shown since
    _asking_again: bool = False
    _is_sick: bool = False
    _knows_how_to_look: bool = False

    def run(self) -> str:
        """Run all steps, and return the session's status. Errors: Interrupted; Closed."""
        try:
            self._end_if_sick()  # the last run of the program may have died at the stop rule
            first = next(iter(self._undone()), None)
            shows = isinstance(first, Show) or (isinstance(first, Ask) and first.about)
            if first is not None and not isinstance(first, Read | PageStep) and not shows:
                self._wait_until_ready(first, None)  # the other steps do so themselves
            for step in self._undone():
                if self.context.break_due and not (isinstance(step, Ask) and step.about):
                    self._rest(Pause(handlers.REQUESTED_BREAK, 0.0))
                self._do(step)
        except Over as over:
            return over.status
        return COMPLETE

    def _undone(self) -> list[Step]:
        return [step for step in self.context.steps if step.key not in self.context.done]

    def _wait_until_ready(self, next_step: Step, own: Page | None) -> None:
        panel = handlers.ready_panel(next_step, self.context.steps, self.resumed, self.hints, own)
        self._pursue(lambda: handlers.ConfirmHandler(self.context, Read(handlers.READY, ""), panel))

    def farewell(self, status: str) -> None:
        """Show the last panel. All is stored by now: an error here no longer matters."""
        own = self.context.design.thanks if status == COMPLETE else None
        seconds = FAREWELL_S if own is None else reading_s(own.text)
        how: dict[str, Any] = {"seconds": seconds, "phase": "over", "may_close": own is not None}
        with suppress(Closed, Exception):
            if own is None:
                panel = dialogs.message_panel(*handlers.FAREWELL[status])
            else:
                panel = handlers.page_panel(own, f"{self.hints.confirm}: close", own.text)
            self.driver.run(PanelHandler(self.context, Read(handlers.END, ""), panel, **how))

    # --- steps ---

    def _do(self, step: Step) -> None:
        match step:
            case Read():
                self._read(step)
            case PageStep():
                page = step.page
                dialog = partial(dialogs.PageDialog, page.title, page.text, self.hints, page.picture)
                self._pursue(lambda: DialogHandler(self.context, step, dialog(), phase="waiting"))
                self._finish(step)
            case Show():
                self._show(step)
            case Ask():
                if step.about and step.about not in self.seen:
                    self._show(self._show_of(step.about))
                if step.about:
                    self.about[step.key] = self.seen[step.about]
                self._answer(step)
            case Pause():
                self._rest(step)
                self._finish(step)

    def _read(self, step: Read) -> None:
        dialog = partial(dialogs.ConsentDialog, step.text, self.hints)
        handler = self._pursue(lambda: DialogHandler(self.context, step, dialog(), phase="reading"))
        if handler.dialog.refused:
            self.context.record("refused", step, by=handler.by)
            raise Over(DECLINED)
        self._finish(step)

    def _finish(self, step: Step) -> None:
        self.context.store.finish_step(self.context.session, step.key)
        self.context.done.add(step.key)

    def _show(self, step: Show) -> None:
        """Show a condition until it was seen undisturbed."""
        context, say = self.context, self.context.console.say
        if not self._knows_how_to_look:
            self._wait_until_ready(step, context.design.ready)
            self._knows_how_to_look = True
        while True:
            if step.after and self._just_seen != step.after:
                self._show(self._show_of(step.after))
            if context.markers is not None and not context.markers.are_received:
                say("no program receives the markers: start the recorder")
            panel_ns = context.display.now_ns()
            panel = handlers.number_panel(step, context.steps, self.hints)
            self._drive(PanelHandler(context, step, panel, refreshes=_PANEL_REFRESHES))
            showing, handler = self._run_trial(step, panel_ns)
            context.shown = step
            self._refuse_signal()
            self._just_seen = step.key if showing.complete else ""
            if showing.complete:
                break
            if handler.interrupt != handlers.LOST:
                self._between(handler.interrupt, step)
            say(f"{handlers.step_name(step, context.steps)}: shown again, from its start")
        context.done.add(step.key)
        self.seen[step.key] = showing
        if (head := handler.head).is_still:
            moved = f"the head hardly moved ({head.turn_deg:.1f} degrees, {head.shift_m * 100:.1f} cm)"
            say(f"{handlers.step_name(step, context.steps)}: {moved}: what was rated is almost a still picture")

    def _show_of(self, key: str) -> Show:
        shown = next(step for step in self.context.steps if step.key == key)
        assert isinstance(shown, Show)
        return shown

    def _run_trial(self, step: Show, panel_ns: int) -> tuple[Showing, TrialHandler]:
        """Run a trial from its black (since panel_ns); the showing is in the store then."""
        context = self.context
        options = self.options_of(step)
        source = self.sources[options.scene_key]
        options = source.fitted(options)
        showing = context.store.begin_showing(context.session, step, dict(step.condition.settings))
        path = context.store.traces / showing.trace
        log = LiveLog(attrs.evolve(options, record=path, seconds=None, pictures=None, out=None))
        handler: TrialHandler | None = None

        def end(complete: bool) -> Showing:
            actual = actual_of(log.result().summary, log.column) | ({} if handler is None else handler.figures())
            ended = context.store.end_showing(context.session, showing, actual, complete)
            if handler is not None and handler.last_shown_ns is not None:
                handler.mark("trial_end", handler.last_shown_ns, complete=complete)
            return ended

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
                Driver(context.display, host, self.ending, context.console.say).run(handler, log, recorder)
        except BaseException:
            with suppress(Exception):  # the first error is the one to report
                end(complete=False)
            raise
        finally:
            self.recording = None
        assert handler is not None
        return end(handler.finished() and not handler.interrupt), handler

    def _answer(self, step: Ask) -> None:
        context = self.context
        handler = self._pursue(lambda: handlers.QuestionHandler(context, step, self._asking_again))
        dialog, seconds = handler.dialog, handler.seconds
        given = (dialog.value, seconds, handler.by, self.about.get(step.key), dialog.text)
        answer = context.store.answer(context.session, step, *given)
        about = {"scale": answer.scale, "item": answer.item, "value": answer.value, "showing": answer.showing}
        context.mark("answer", step, handler.began_ns + round(seconds * 1e9), **about, revision=answer.revision)
        context.done.add(step.key)
        self.answered = step
        text = step.scale.words_for(step.item, answer.value, answer.text) or (
            "left unanswered" if answer.value is None else f"{answer.value:g}"
        )
        name = handlers.step_name(step, context.steps)
        where = f"{name}, {step.scale.title}" if step.about else name
        context.console.say(f"{where}: {text}" + (" (answered again)" if answer.revision > 1 else ""))
        rule = context.design.sickness
        if rule is not None and step.scale.name == rule.scale.name:
            self._end_if_sick()

    # --- between the steps ---

    def _drive(self, handler: StepHandler | PanelHandler) -> None:
        self.driver.run(handler)
        self._refuse_signal()

    def _refuse_signal(self) -> None:
        if self.ending.asked is not None:
            raise Interrupted(f"ended by {signal.Signals(self.ending.asked).name}")

    def _pursue(self, make: Callable[[], H]) -> H:
        """Run a step to its end, anew after each interrupt but a question left unanswered."""
        while True:
            handler = make()
            self._drive(handler)
            if not handler.interrupt:
                return handler
            if self._between(handler.interrupt, handler.step) == dialogs.SKIP and isinstance(
                handler, handlers.QuestionHandler
            ):
                handler.leave_unanswered()
                return handler

    def _between(self, interrupt: str, step: Step) -> str:
        """Do what an interrupt requests. Returns what was done."""
        chosen = self._menu(step) if interrupt == handlers.PAUSE else interrupt
        if chosen == dialogs.STOP:
            raise Over(STOPPED)
        if chosen == dialogs.BREAK:
            self._rest(Pause(handlers.REQUESTED_BREAK, 0.0))
        elif chosen == dialogs.AGAIN:
            if self.answered is None:
                self.context.console.say("nothing has been answered yet")
            elif not self._asking_again:
                self._asking_again = True
                try:
                    self._answer(self.answered)
                finally:
                    self._asking_again = False
        return chosen

    def _menu(self, step: Step) -> str:
        offers = {
            dialogs.CONTINUE: True,
            dialogs.BREAK: not isinstance(step, Pause),
            dialogs.AGAIN: self.answered is not None and not self._asking_again,
            dialogs.SKIP: isinstance(step, Ask),
            dialogs.STOP: True,
        }
        offered = [name for name, is_offered in offers.items() if is_offered]
        handler = handlers.MenuHandler(self.context, Pause(handlers.MENU, 0.0), offered, step)
        self._drive(handler)
        return handler.dialog.chosen

    def _rest(self, step: Pause) -> None:
        """Have a break; the menu does not stop its time."""
        self.context.break_due = False
        until_ns = self.context.display.now_ns() + round(step.seconds * 1e9)
        self._pursue(lambda: handlers.BreakHandler(self.context, step, until_ns))

    # --- the stop rule ---

    def _end_if_sick(self) -> None:
        """End the session at the stop rule, after the last questions, but for a slip."""
        context, rule = self.context, Read(handlers.STOP_RULE, "")
        if self._is_sick or not self._why_sick():
            return
        try:
            while why := self._why_sick():
                context.record(handlers.STOP_RULE, rule, why=why)
                context.console.say(f"the stop rule: {why}")
                self.why = why
                last = [step for step in self._undone() if isinstance(step, Ask) and step.phase == AFTER]
                handler = handlers.ConfirmHandler(context, rule, handlers.sick_panel(bool(last), self.hints))
                self._drive(handler)
                if not handler.interrupt:
                    self._is_sick = True
                    for step in last:
                        self._do(step)
                    raise Over(SICK)
                self._between(handler.interrupt, handler.step)
            self.why = ""  # the slip is corrected
        except Over:
            raise Over(SICK) from None

    def _why_sick(self) -> str:
        return why_sick(self.context.design.sickness, self.context.store.answers(self.context.session))
