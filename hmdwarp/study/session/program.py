"""Program of a session: what it opens, always leaves in the store, and says last."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs

from ...display import Closed, Display
from ...errors import HmdwarpError, InputError
from ...pipeline import SceneKey, Source, source_of
from ...resources import __version__
from ...run import Driver, Ending, LiveOptions, Watchdog, open_display
from ..design import Ask, Design, Show, design_from_text, live_options, load_design, steps_of
from ..dialogs.dialog_panels import ACTING_CONTROLS, CONTROLS, hints_for
from ..line_console import LineConsole
from ..respondents import NoRespondent, Population, Respondent, Simulated, load_model, person_of
from ..store import INTERRUPTED, PILOT, SIMULATED, Session, Store, store_folder
from .markers import MarkerStream, load_lsl, marker_stream
from .runner import Interrupted, SessionRunner, TrialRunner, first_picture_wait_s
from .session_options import SessionOptions
from .step_handlers import CommandSources, SessionContext
from .wording import ClosingWords, scene_reacts

Say = Callable[[str], None]


def run_session(
    options: SessionOptions,
    say: Say = lambda text: None,
    *,
    console: LineConsole | None = None,
    respondent: Respondent | None = None,
    quiet: bool = False,
    on_end: Callable[[Session], None] = lambda session: None,
) -> Session:
    """Run a session until it is over or interrupted, and return it with its status.

    Whatever ends it, all answers are in the store, and a session that is not over can be resumed.

    say: gets the closing words, and messages from before there is a console. console, respondent:
    None for those of the options. quiet: whether the console of lines only answers commands.
    on_end: gets the session after the closing words, before the signal that ended it is raised once
    more; not where an error says it all.

    Errors: InputError for wrong options, before anything is opened; MachineError for what the
    machine lacks, and for a display that does not come back. Each says how to resume.
    """
    design = load_design(options.study)
    # Refuses a display without a head, before there is a store.
    live_options(design.parts[0].conditions[0].settings, source=options.source, trace=options.trace)
    if options.lsl:
        load_lsl()  # refuses a machine without it, before there is a store
    with ExitStack() as stack:
        ending = stack.enter_context(Ending(None, None))  # outermost: a signal ends the program last
        folder = store_folder(design, options.store, options.origin)
        store = stack.enter_context(Store(folder, create=True, study=design.name, say=say))
        part, design = _planned(options, design, store)
        answers_for = _respondent(options, design, part) if respondent is None else lambda session: respondent
        words = ClosingWords(options, design, store, say, on_end)
        stack.callback(words.say)
        shown_on = console or LineConsole(f"study {design.name}", kind=options.console, quiet=quiet)
        console = stack.enter_context(shown_on)

        def last_words() -> str:
            shown_on.__exit__()  # first: it gives the terminal back
            return words.last_words()

        first = design.part(part).conditions[0]
        live = live_options(first.settings, source=options.source, trace=options.trace)
        watchdog = stack.enter_context(Watchdog(live.hang_s, [last_words]))
        sources = {live.scene_key: source_of(live)}
        controls = ACTING_CONTROLS if any(map(scene_reacts, design.part(part).conditions)) else CONTROLS
        where = (live, sources[live.scene_key], watchdog.watching, console.say, controls)
        display = stack.enter_context(closing(open_display(*where, briefly=True)))
        markers = None
        if options.lsl:
            about = {"study": design.name, "title": design.title}
            name = f"hmdwarp study {design.name}"
            markers = stack.enter_context(closing(marker_stream(display, name, about)))
            console.say(markers.describe())
        parts = (options, design, part, ending, store, console, words, display, markers, live, answers_for)
        return _Program(*parts, sources).run()


def _planned(options: SessionOptions, design: Design, store: Store) -> tuple[str, Design]:
    """Return the part and the plan; a resumed session keeps the plan it began with."""
    if not options.resume:
        store.would_begin(design, options.part, options.participant, options.origin, options.new_session)
        return options.part or design.parts[0].name, design
    session = store.would_resume(options.participant, options.part)
    if session.origin != options.origin:  # simulated answers must not get into a person's session
        how = {PILOT: "give --pilot", SIMULATED: "give --simulate MODEL"}.get(
            session.origin, "leave --pilot and --simulate away"
        )
        raise InputError(
            f"participant {session.code} is a {session.origin} here, not a {options.origin}: {how} to resume"
        )
    began_with = design if session.plan == design.text else design_from_text(session.plan, design.path)
    store.check_same(session, began_with)
    return session.part, began_with


def _respondent(options: SessionOptions, design: Design, part: str) -> Callable[[Session], Respondent]:
    """Return who answers in a session besides the participant.

    Errors: InputError for a model that lacks something, before there is a session.
    """
    if options.simulate is None:
        return lambda session: NoRespondent()
    model = load_model(options.simulate)
    Population(model, design, part)  # raises where the model has no answer to what the study asks
    return lambda session: Simulated(model, design, part, design.seed, person_of(session.code), session.order)


@attrs.frozen(eq=False)
class _Program:
    """One run of the program, with everything open that it needs."""

    options: SessionOptions
    design: Design
    part: str
    ending: Ending
    store: Store
    console: LineConsole
    words: ClosingWords
    display: Display
    markers: MarkerStream | None
    live: LiveOptions  # between trials there is no pipeline, but the driver asks for these options
    answers_for: Callable[[Session], Respondent]
    sources: dict[SceneKey, Source]  # those that are open

    def run(self) -> Session:
        """Begin or resume, and leave the session as it ended."""
        session = self.words.session = self._session()
        try:
            runner = self._runner(session)
            status = runner.run()
            self.words.session = self.store.end(session, status, runner.why)
        except (Interrupted, Closed) as ended:
            try:
                self._interrupt(session, str(ended))
            except HmdwarpError as error:
                self._give_up(session, ended)
                raise self.words.explained(error) from error
        except HmdwarpError as error:
            self._give_up(session, error)
            raise self.words.explained(error) from error
        except BaseException as error:
            self._give_up(session, error)
            raise
        else:
            runner.farewell(self.words.session.status)
        finally:
            if self.markers is not None:
                who = {"participant": session.sub, "session": session.number}
                self.markers.send("session_end", self.display.now_ns(), **who, status=self.words.session.status)
        return self.words.session

    def _session(self) -> Session:
        options, facts = self.options, facts_of(self.display, self.design, self.options.trace)
        if options.resume:
            return self.store.resume(options.participant, options.part, facts)
        return self.store.begin(
            self.design, options.part, options.participant, options.origin, options.new_session, facts
        )

    def _interrupt(self, session: Session, why: str) -> None:
        self.words.session = self.store.end(session, INTERRUPTED, why)

    def _give_up(self, session: Session, error: BaseException) -> None:
        """Mark the session as interrupted; it can be resumed even where that cannot be written."""
        why = str(error) or type(error).__name__
        self.words.session = attrs.evolve(session, status=INTERRUPTED, why=why)
        with suppress(HmdwarpError):
            self._interrupt(session, why)

    def _runner(self, session: Session) -> SessionRunner:
        store, display = self.store, self.display
        steps = steps_of(self.design, session.order, session.part)
        sources = CommandSources(self.console, self.answers_for(session))
        context = SessionContext(
            self.design,
            session,
            store,
            display,
            sources,
            steps,
            store.done(session),
            before_s=store.passed_s(session),
            markers=self.markers,
        )
        practice = [self.design.practice] if self.design.practice is not None else []
        every = [live_options(condition.settings) for condition in (*self.design.part(self.part).conditions, *practice)]
        for options in every:
            self.sources[options.scene_key] = self.sources.get(options.scene_key) or source_of(options)
        wait_s = first_picture_wait_s([options.total_latency_ms for options in every])
        trials = TrialRunner(context, self.ending, self._options_of, wait_s, self.sources)
        self.words.recording = lambda: trials.recording
        no_pipeline: Any = _NoPipeline(self.live)
        answers = store.answers(session)
        asks = {step.key: step for step in steps if isinstance(step, Ask)}
        last = max(answers, key=lambda answer: answer.id, default=None)
        showings = {showing.id: showing for showing in store.contents(pilot=session.origin == PILOT).showings}
        return SessionRunner(
            context,
            trials,
            Driver(display, no_pipeline, self.ending, self.console.say),
            self.ending,
            hints_for(display.name, follows_trace=bool(self.options.trace)),
            resumed=self.options.resume,
            answered=asks.get(last.key) if last is not None else None,
            about={answer.key: showings[answer.showing] for answer in answers if answer.showing is not None},
        )

    def _options_of(self, step: Show) -> LiveOptions:
        return live_options(step.condition.settings, source=self.options.source, trace=self.options.trace)


@attrs.frozen
class _NoPipeline:
    """Stand-in for the driver's pipeline host where nothing is drawn."""

    options: LiveOptions


PACKAGES = ("numpy", "scipy", "moderngl", "glfw", "pyopenxr", "attrs")


def facts_of(display: Display, design: Design, trace: str) -> dict[str, Any]:
    """Return versions, machine, GPU, display and seed.

    No name of a host or a user is among them: a session's data may be passed on. Of a trace file
    the name is kept, not the folders.
    """
    gpu = display.gpu
    return {
        "hmdwarp": __version__,
        "python": platform.python_version(),
        "packages": {name: version for name in PACKAGES if (version := _version(name))},
        "machine": {
            "system": platform.system(),
            "release": platform.release(),
            "cpu": platform.machine(),
            "cpu_count": os.cpu_count() or 1,
        },
        "gpu": {"renderer": gpu.renderer, "version": gpu.version, "clock": gpu.timer.clock},
        "display": dict(display.about),
        "source": display.name,
        "headset": display.headset.name if display.headset is not None else display.about.get("headset", ""),
        "rate_hz": display.rate_hz,
        "seed": design.seed,
        "trace": Path(trace).name,
        "trace_axes": display.about.get("trace_axes", ""),
    }


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
