"""A session from its beginning to its end: what it opens, what it leaves in the store whatever happens, and what it says last."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing, suppress

import attrs

from ...display import Closed, Display
from ...errors import HmdwarpError, InputError
from ...run.live import LiveOptions
from ...run.live.driver import Driver
from ...run.live.ending import Ending
from ...run.live.openings import open_display
from ...run.live.watchdog import Watchdog
from ...scenes import load_scene
from ..asking import CONTROLS, hints_for
from ..design import Design
from ..design.read import design_from_text, load_design
from ..design.settings import live_options
from ..desk import Desk, make_desk
from ..respondents import Nobody, Respondent
from ..steps import Ask, Show, Step, steps_of
from ..store import INTERRUPTED, PILOT, SIMULATED, Session, Showing, Store, store_folder
from . import plates
from .afterwards import Afterwards
from .ended import Broken
from .facts import facts_of
from .idle import Idle
from .options import RunSession
from .room import Room
from .showing import Shower
from .sitting import Sitting
from .trial import under_way_s
from .voices import Voices

Say = Callable[[str], None]


def run_session(
    options: RunSession,
    say: Say = lambda text: None,
    *,
    desk: Desk | None = None,
    respondent: Respondent | None = None,
    told: Callable[[Session], None] = lambda session: None,
) -> Session:
    """Run it, until it is over or interrupted; what it is then is in the session's status. say: gets what is to be told at the end, and
    what nobody else was there to be told before. desk, respondent: None for what the options say. told: gets the session when all of its
    end has been said; not where an error says it. That comes before the signal which ended it is raised once more.

    Whatever ends it, what was answered is in the store, and a session that is not over can be gone on with.
    Errors: InputError for what was asked, before anything is opened; MachineError for what the machine lacks, and for a display that does
    not come back; each then says how to go on.
    """
    design = load_design(options.study)
    with ExitStack() as stack:
        ending = stack.enter_context(Ending(None, None))  # outermost: a signal ends the program when all is told
        store = stack.enter_context(Store(store_folder(design, options.store), create=True, study=design.name, say=say))
        part, design = _asked_for(options, design, store)
        answers_for = _respondent(options, design, part) if respondent is None else lambda session: respondent
        afterwards = Afterwards(options, design, store, say, told)
        stack.callback(afterwards.tell)
        desk = stack.enter_context(desk if desk is not None else make_desk(options.desk, f"study {design.name}"))
        first = design.part(part).conditions[0]
        live = live_options(first.settings, source=options.source, trace=options.trace)
        watchdog = stack.enter_context(Watchdog(live.hang_s, [afterwards.last_words]))
        display = stack.enter_context(closing(open_display(live, watchdog.watching, desk.say, CONTROLS, briefly=True)))
        return _Program(options, design, part, ending, store, desk, afterwards, display, live, answers_for).run()


def _asked_for(options: RunSession, design: Design, store: Store) -> tuple[str, Design]:
    """The part, and the plan: where a session is gone on with, the one it began with."""
    if not options.resume:
        store.would_begin(design, options.part, options.participant, options.origin, options.new_session)
        return options.part or design.parts[0].name, design
    session = store.would_resume(options.participant, options.part)
    if session.origin != options.origin:  # made-up answers must not get into somebody's session
        how = {PILOT: "give --pilot", SIMULATED: "give --simulate MODEL"}.get(
            session.origin, "leave --pilot and --simulate away"
        )
        raise InputError(
            f"participant {session.code} is a {session.origin} here, not a {options.origin}: {how} to go on"
        )
    began_with = design if session.plan == design.text else design_from_text(session.plan, design.path)
    store.check_same(session, began_with)
    return session.part, began_with


def _respondent(options: RunSession, design: Design, part: str) -> Callable[[Session], Respondent]:
    """Who answers in a session, beside the participant. Errors: InputError for a model that cannot be used, before there is a session."""
    if options.simulate is None:
        return lambda session: Nobody()
    from ..respondents.cohort import Population
    from ..respondents.simulated import Simulated, load_model, person_of

    model = load_model(options.simulate)
    Population(model, design, part)  # raises where the model has no answer to what the study asks
    return lambda session: Simulated(model, design, part, design.seed, person_of(session.code), session.order)


@attrs.frozen(eq=False)
class _Program:
    """One run of the program, with all that it needs open."""

    options: RunSession
    design: Design
    part: str
    ending: Ending
    store: Store
    desk: Desk
    afterwards: Afterwards
    display: Display
    live: LiveOptions
    answers_for: Callable[[Session], Respondent]

    def run(self) -> Session:
        """Begin or go on, and leave the session as it ended."""
        session = self.afterwards.session = self._session()
        try:
            sitting = self._sitting(session, self.answers_for(session))
            status = sitting.run()
            self.afterwards.session = self.store.end(session, status, sitting.why)
        except (Broken, Closed) as ended:
            try:
                self._interrupt(session, str(ended))
            except HmdwarpError as error:
                self._give_up(session, ended)
                raise self.afterwards.explained(error) from error
        except HmdwarpError as error:
            self._give_up(session, error)
            raise self.afterwards.explained(error) from error
        except BaseException as error:
            self._give_up(session, error)
            raise
        else:
            sitting.farewell(status)
        return self.afterwards.session

    def _session(self) -> Session:
        options, facts = self.options, facts_of(self.display, self.design, self.options.trace)
        if options.resume:
            return self.store.resume(options.participant, options.part, facts)
        return self.store.begin(
            self.design, options.part, options.participant, options.origin, options.new_session, facts
        )

    def _interrupt(self, session: Session, why: str) -> None:
        self.afterwards.session = self.store.end(session, INTERRUPTED, why)

    def _give_up(self, session: Session, error: BaseException) -> None:
        """Where even that cannot be written, the session is found running and nobody's, and is gone on with all the same."""
        self.afterwards.session = attrs.evolve(session, status=INTERRUPTED, why=str(error) or type(error).__name__)
        with suppress(HmdwarpError):
            self._interrupt(session, str(error) or type(error).__name__)

    def _sitting(self, session: Session, respondent: Respondent) -> Sitting:
        design, store, display = self.design, self.store, self.display
        steps = steps_of(design, session.order, session.part)
        beside = {PILOT: " - PILOT", SIMULATED: " - SIMULATED"}.get(session.origin, "")
        heading = f"study {design.name}, participant {session.code}, session {session.number}{beside}"
        room = Room(design, session, store, display, Voices(self.desk, respondent), steps, store.done(session), heading)
        every = self._all_options()
        scenes = {name: load_scene(name) for name in {one.scene for one in every}}
        under_way = under_way_s([one.latency_ms for one in every])
        shower = Shower(
            room, self.ending, self._options_of, lambda step: plates.number_of(step, steps), under_way, scenes
        )
        self.afterwards.recording = lambda: shower.recording
        driver = Driver(display, Idle(self.live), self.ending, self.desk.say)
        before = _Before(store, session, steps)
        return Sitting(
            room,
            shower,
            driver,
            self.ending,
            hints_for(display.name),
            self.options.resume,
            before.answered,
            before.about,
        )

    def _options_of(self, step: Show) -> LiveOptions:
        return live_options(step.condition.settings, source=self.options.source, trace=self.options.trace)

    def _all_options(self) -> list[LiveOptions]:
        """Of everything that is shown."""
        shown = [
            *self.design.part(self.part).conditions,
            *([self.design.practice] if self.design.practice is not None else []),
        ]
        return [live_options(one.settings) for one in shown]


class _Before:
    """What other sittings of the session have left. answered, about: as Sitting has them."""

    def __init__(self, store: Store, session: Session, steps: tuple[Step, ...]) -> None:
        answers = store.answers(session)
        asks = {step.key: step for step in steps if isinstance(step, Ask)}
        showings = {
            one.id: one for one in store.contents(pilot=session.origin == PILOT).showings if one.session == session.id
        }
        self.about: dict[str, Showing] = {one.key: showings[one.showing] for one in answers if one.showing is not None}
        last = max(answers, key=lambda one: one.id, default=None)
        self.answered = asks.get(last.key) if last is not None else None
