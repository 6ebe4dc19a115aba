"""A sitting: the steps of a session one after the other, with everything that may come in between."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import suppress

import attrs

from ...display import Closed
from ...run.live.driver import Driver
from ...run.live.ending import Ending
from ..asking import AGAIN, BREAK, CONTINUE, SKIP, STOP, Hints
from ..steps import Ask, Pause, Read, Show, Step
from ..store import COMPLETE, STOPPED, Showing
from ..store import SICK as ENDED_SICK
from . import plates
from .ended import Broken, Over
from .questions import Break, Consent, MenuWatch, Question, Standing, Waiting
from .room import Room
from .showing import Shower
from .sickness import why_sick
from .telling import ASKED_BREAK, END, MENU, READY, SICK, told
from .voices import PAUSE
from .watch import LOST, StepHandler

FAREWELL_S = 3.0
PLATE_REFRESHES = 2  # before a pipeline is built, which takes a while: a double-buffered window shows the second one


@attrs.define(eq=False)
class Sitting:
    """driver: for all that shows no pictures. resumed: whether the session began in another sitting. answered: the question that was
    answered last, in other sittings too. about: by the key of a question, the showing it was answered for. seen: by the key of a trial,
    the showing that was seen to its end in this sitting. why: it ended, where somebody must know.
    """

    room: Room
    shower: Shower
    driver: Driver
    ending: Ending
    hints: Hints
    resumed: bool = False
    answered: Ask | None = None
    about: dict[str, Showing] = attrs.field(factory=dict)
    seen: dict[str, Showing] = attrs.field(factory=dict)
    why: str = ""
    _asking_again: bool = False
    _is_sick: bool = False

    def run(self) -> str:
        """All of it. Returns the status that the session ends with: COMPLETE, STOPPED or SICK.

        Errors: Broken, where it ended for now; Closed, Lost, as Driver.run; InputError and MachineError.
        """
        try:
            self._end_if_sick()  # before the program died, maybe
            self._begin()
            for step in self._undone():
                if self.room.break_due and not (isinstance(step, Ask) and step.about):
                    self._rest(Pause(ASKED_BREAK, 0.0))
                self._do(step)
        except Over as over:
            return over.status
        return COMPLETE

    def _undone(self) -> list[Step]:
        return [step for step in self.room.steps if step.key not in self.room.done]

    def _begin(self) -> None:
        """A text to be agreed to waits by itself; where there is none, something else must."""
        undone = self._undone()
        if undone and not isinstance(undone[0], Read):
            plate = plates.ready(undone[0], self.room.steps, self.resumed, self.hints)
            self._pursue(lambda: Waiting(self.room, Read(READY, ""), plate))

    def farewell(self, status: str) -> None:
        """The last plate. Everything is in the store by now: whatever happens here is nobody's concern any more."""
        plate = plates.farewell(status)
        with suppress(Closed, Exception):
            self.driver.run(Standing(self.room, Read(END, ""), plate, seconds=FAREWELL_S, phase="over"))

    # --- steps ---

    def _do(self, step: Step) -> None:
        does: dict[type, Callable[..., None]] = {Read: self._read, Show: self._show, Ask: self._ask, Pause: self._pause}
        does[type(step)](step)

    def _read(self, step: Read) -> None:
        watch = self._pursue(lambda: Consent(self.room, step))
        if watch.refused:
            self.room.record("refused", step, by=watch.by)
            raise Over(STOPPED)
        self._finish(step)

    def _pause(self, step: Pause) -> None:
        self._rest(step)
        self._finish(step)

    def _finish(self, step: Step) -> None:
        self.room.store.finish_step(self.room.session, step.key)
        self.room.done.add(step.key)

    def _show(self, step: Show) -> None:
        """Until it was seen undisturbed."""
        room = self.room
        while True:
            plated_ns = room.display.now_ns()
            self._drive(Standing(room, step, plates.number_of(step, room.steps), refreshes=PLATE_REFRESHES))
            showing, watch = self.shower.show(step, plated_ns)
            room.shown = step
            self._refuse_signal()
            if showing.complete:
                break
            if watch.intent != LOST:
                self._between(watch.intent, step)
            room.say(f"{told(step, room.steps)}: shown again, from its start")
        room.done.add(step.key)
        self.seen[step.key] = showing

    def _ask(self, step: Ask) -> None:
        """What it is about is shown again first, where it was not seen in this sitting."""
        if step.about and step.about not in self.seen:
            self._show(next(one for one in self.room.steps if one.key == step.about))
        if step.about:
            self.about[step.key] = self.seen[step.about]
        self._answer(step)

    def _answer(self, step: Ask) -> None:
        room = self.room
        watch = self._pursue(lambda: Question(room, step, self._asking_again))
        answer = room.store.answer(room.session, step, watch.value, watch.seconds, watch.by, self.about.get(step.key))
        room.done.add(step.key)
        self.answered = step
        said = "left unanswered" if answer.value is None else f"{answer.value:g}"
        about = f"{told(step, room.steps)}, {step.scale.title}" if step.about else told(step, room.steps)
        room.say(f"{about}: {said}" + (" (answered again)" if answer.revision > 1 else ""))
        rule = room.design.sickness
        if rule is not None and step.scale.name == rule.scale.name:
            self._end_if_sick()

    # --- what comes in between ---

    def _drive(self, watch: StepHandler | Standing) -> None:
        self.driver.run(watch)
        self._refuse_signal()

    def _refuse_signal(self) -> None:
        if self.ending.asked is not None:
            raise Broken(f"ended by {signal.Signals(self.ending.asked).name}")

    def _pursue(self, make: Callable[[], StepHandler]):
        """Until it came to its end, however often something came in between; each time anew. A question that the menu leaves
        unanswered has come to its end."""
        while True:
            watch = make()
            self._drive(watch)
            if not watch.intent:
                return watch
            if self._between(watch.intent, watch.step) == SKIP:
                return watch.left_unanswered()

    def _between(self, intent: str, step: Step) -> str:
        """Returns what was done."""
        chosen = self._menu(step) if intent == PAUSE else intent
        if chosen == STOP:
            raise Over(STOPPED)
        if chosen == BREAK:
            self._rest(Pause(ASKED_BREAK, 0.0))
        elif chosen == AGAIN:
            self._ask_again()
        return chosen

    def _menu(self, step: Step) -> str:
        offers = {
            CONTINUE: True,
            BREAK: not isinstance(step, Pause),
            AGAIN: self.answered is not None and not self._asking_again,
            SKIP: isinstance(step, Ask),
            STOP: True,
        }
        watch = MenuWatch(
            self.room, Pause(MENU, 0.0), [name for name, is_offered in offers.items() if is_offered], step
        )
        self._drive(watch)
        return watch.chosen

    def _rest(self, step: Pause) -> None:
        """The time of a break goes on in the menu."""
        self.room.break_due = False
        until_ns = self.room.display.now_ns() + round(step.seconds * 1e9)
        self._pursue(lambda: Break(self.room, step, until_ns))

    def _ask_again(self) -> None:
        if self.answered is None:
            self.room.say("nothing has been answered yet")
        elif not self._asking_again:
            self._asking_again = True
            try:
                self._answer(self.answered)
            finally:
                self._asking_again = False

    # --- the stop rule ---

    def _end_if_sick(self) -> None:
        """At the stop rule: the session goes over to what is asked after it, each of which may be left out, and ends. An answer that was
        a slip can be given again before."""
        if self._is_sick or not self._why_sick():
            return
        try:
            while why := self._why_sick():
                self._tell_sick(why)
                watch = Waiting(self.room, Read(SICK, ""), plates.sick(bool(self._after()), self.hints))
                self._drive(watch)
                if not watch.intent:
                    self._ask_after()
                    raise Over(ENDED_SICK)
                self._between(watch.intent, watch.step)
            self.why = ""  # it was a slip, and is corrected
        except Over:
            raise Over(ENDED_SICK) from None

    def _why_sick(self) -> str:
        return why_sick(self.room.design.sickness, self.room.store.answers(self.room.session))

    def _tell_sick(self, why: str) -> None:
        self.room.record(SICK, Read(SICK, ""), why=why)
        self.room.say(f"the stop rule: {why}")
        self.why = why

    def _after(self) -> list[Step]:
        return [step for step in self._undone() if isinstance(step, Ask) and step.phase == "after"]

    def _ask_after(self) -> None:
        self._is_sick = True
        for step in self._after():
            self._do(step)
