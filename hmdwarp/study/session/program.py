"""Program of a session: what it opens, always leaves in the store, and says last."""

from __future__ import annotations

import os
import platform
import shlex
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs

from ...base import HmdwarpError, InputError, __version__
from ...display import Closed, Display
from ...pipeline import SceneKey, Source, source_of
from ...report import counted
from ...run import OFFSCREEN, Driver, Ending, LiveOptions, Watchdog, open_display
from ..design import Ask, Design, Show, design_from_text, live_options, load_design, steps_of
from ..dialogs.dialog_panels import ACTING_CONTROLS, CONTROLS, hints_for
from ..line_console import LineConsole
from ..respondents import Simulated, load_model, person_of, ratings_for
from ..store import INTERRUPTED, PERSON, PILOT, SIMULATED, Session, Store, store_folder
from .markers import MarkerStream, load_lsl
from .runner import Interrupted, SessionRunner, first_picture_wait_s
from .session_options import SessionOptions
from .step_handlers import SessionContext, scene_reacts

Say = Callable[[str], None]


def run_session(
    options: SessionOptions,
    say: Say = lambda text: None,
    *,
    console: LineConsole | None = None,
    quiet: bool = False,
    on_end: Callable[[Session], None] = lambda session: None,
) -> Session:
    """Run a session until it is over or interrupted, and return it with its status.

    Whatever ends it, all answers are in the store, and a session that is not over can be resumed.

    say: gets the closing words, and messages from before there is a console. console: None for that
    of the options; quiet: it only answers commands. on_end: gets the session after the closing
    words, before the signal that ended it is raised once more; not where an error says it all.

    Errors, which say how to resume: InputError for wrong options, before anything is opened;
    MachineError for what the machine lacks, and for a display that does not come back.
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
        model = None if options.simulate is None else load_model(options.simulate)
        if model is not None:
            ratings_for(model, design, design.part(part))  # raises where the model has no answer to what the study asks
        program = _Program(options, design, part, ending, store, say, on_end)
        stack.callback(program.say_last)
        shown_on = console or LineConsole(f"study {design.name}", kind=options.console, quiet=quiet)
        console = stack.enter_context(shown_on)

        def last_words() -> str:
            shown_on.__exit__()  # first: it gives the terminal back
            return program.last_words()

        live = program.live_options(design.part(part).conditions[0].settings)
        watchdog = stack.enter_context(Watchdog(live.hang_s, [last_words]))
        sources = {live.scene_key: source_of(live)}
        controls = ACTING_CONTROLS if any(map(scene_reacts, design.part(part).conditions)) else CONTROLS
        where = (live, sources[live.scene_key], watchdog.watching, console.say, controls)
        display = stack.enter_context(closing(open_display(*where)))
        markers = None
        if options.lsl:
            about = {"study": design.name, "title": design.title, "display": display.name}
            about["rate_hz"] = f"{display.rate_hz:g}"
            how = (f"hmdwarp study {design.name}", about, display.now_ns)
            markers = MarkerStream(*how, is_simulated=display.name == OFFSCREEN)
            stack.enter_context(closing(markers))
            console.say(markers.describe())

        def runner_of(session: Session) -> SessionRunner:
            respondent = None
            if model is not None:
                person = person_of(session.code)
                respondent = Simulated(model, design, part, design.seed, person, session.order)
            steps = steps_of(design, session.order, session.part)
            of = (design, session, store, display, shown_on, respondent, steps, store.done(session), markers)
            return program.runner(SessionContext(*of, before_s=store.passed_s(session)), live, sources)

        return program.run(display, markers, runner_of)


def _planned(options: SessionOptions, design: Design, store: Store) -> tuple[str, Design]:
    """Return the part and the plan; a resumed session keeps the plan it began with."""
    if not options.resume:
        store.would_begin(design, options.part, options.participant, options.origin, options.new_session)
        return options.part or design.parts[0].name, design
    session = store.would_resume(options.participant, options.part)
    if session.origin != options.origin:  # simulated answers must not get into a person's session
        hows = {PILOT: "give --pilot", SIMULATED: "give --simulate MODEL"}
        how = hows.get(session.origin, "leave --pilot and --simulate away")
        found = f"participant {session.code} is a {session.origin} here, not a {options.origin}"
        raise InputError(f"{found}: {how} to resume")
    began_with = design if session.plan == design.text else design_from_text(session.plan, design.path)
    store.check_same(session, began_with)
    return session.part, began_with


@attrs.define(eq=False)
class _Program:
    """One run of the program: the session as it is left, and the closing words."""

    options: SessionOptions
    design: Design
    part: str
    ending: Ending
    store: Store
    say: Say
    on_end: Callable[[Session], None]
    session: Session | None = None  # None until there is one
    running: SessionRunner | None = None
    quiet: bool = False  # whether an error says it all

    def live_options(self, settings: Any) -> LiveOptions:
        return live_options(settings, source=self.options.source, trace=self.options.trace)

    def run(
        self, display: Display, markers: MarkerStream | None, runner_of: Callable[[Session], SessionRunner]
    ) -> Session:
        """Begin or resume, and leave the session as it ended."""
        options, store, facts = self.options, self.store, facts_of(display, self.design, self.options.trace)
        if options.resume:
            session = store.resume(options.participant, options.part, facts)
        else:
            who = (options.part, options.participant, options.origin, options.new_session)
            session = store.begin(self.design, *who, facts)
        self.session = session
        try:
            runner = self.running = runner_of(session)
            status = runner.run()
            self.session = store.end(session, status, runner.why)
        except (Interrupted, Closed) as ended:
            try:
                self.session = store.end(session, INTERRUPTED, str(ended))
            except HmdwarpError as error:
                self._give_up(session, ended)
                raise self._explained(error) from error
        except HmdwarpError as error:
            self._give_up(session, error)
            raise self._explained(error) from error
        except BaseException as error:
            self._give_up(session, error)
            raise
        else:
            runner.farewell(self.session.status)
        finally:
            if markers is not None:
                whose = {"participant": session.sub, "session": session.number, "status": self.session.status}
                markers.send("session_end", display.now_ns(), **whose)
        return self.session

    def _give_up(self, session: Session, error: BaseException) -> None:
        """Mark the session as interrupted; it can be resumed even where that cannot be written."""
        why = str(error) or type(error).__name__
        self.session = attrs.evolve(session, status=INTERRUPTED, why=why)
        with suppress(HmdwarpError):
            self.session = self.store.end(session, INTERRUPTED, why)

    def runner(self, context: SessionContext, live: LiveOptions, sources: dict[SceneKey, Source]) -> SessionRunner:
        """Return the runner of a session's steps. sources: those that are open."""
        store, session, display = self.store, context.session, context.display
        practice = [self.design.practice] if self.design.practice is not None else []
        every = [live_options(condition.settings) for condition in (*self.design.part(self.part).conditions, *practice)]
        for options in every:
            sources[options.scene_key] = sources.get(options.scene_key) or source_of(options)
        no_pipeline: Any = _NoPipeline(live)
        answers = store.answers(session)
        asks = {step.key: step for step in context.steps if isinstance(step, Ask)}
        last = max(answers, key=lambda answer: answer.id, default=None)
        showings = {showing.id: showing for showing in store.contents(pilot=session.origin == PILOT).showings}

        def options_of(step: Show) -> LiveOptions:
            return self.live_options(step.condition.settings)

        return SessionRunner(
            context,
            Driver(display, no_pipeline, self.ending, context.console.say),
            self.ending,
            hints_for(display.name, follows_trace=bool(self.options.trace)),
            options_of,
            first_picture_wait_s([options.total_latency_ms for options in every]),
            sources,
            resumed=self.options.resume,
            answered=asks.get(last.key) if last is not None else None,
            about={answer.key: showings[answer.showing] for answer in answers if answer.showing is not None},
        )

    @property
    def how_to_resume(self) -> str:
        assert self.session is not None
        several = len(self.design.parts) > 1
        return f"resume with: {self.options.command(self.session.code, self.session.part, several)}"

    def say_last(self) -> None:
        """Say the closing words, once everything else is closed."""
        if self.session is None or self.quiet:
            return
        session = self.session
        origin = "" if session.origin == PERSON else f" ({session.origin})"
        who = f"participant {session.code}{origin}, session {session.number}, part {session.part}"
        lines = [f"{who}: {session.status}{f': {session.why}' if session.why else ''}"]
        with suppress(HmdwarpError):  # a full disk may not even be readable
            answers = self.store.answers(session)
            rated = sum(answer.phase == "trial" and answer.value is not None for answer in answers)
            count = f"{counted(len(answers), 'answer')}, {rated} of them about trials" if answers else "no answers"
            lines.append(f"stored in {self.store.folder}: {count}")
            shown = [one for one in self.store.contents(pilot=session.origin == PILOT).showings if one.trial]
            trials = {one.key: one for one in shown if one.session == session.id and one.complete}
            if still := sum(bool(one.actual.get("head_still")) for one in trials.values()):
                of = f"{still} of {counted(len(trials), 'trial')}"
                lines.append(f"the head hardly moved in {of}: almost a still picture was rated (head_still)")
        lines.append(self.how_to_resume if session.status == INTERRUPTED else self._next())
        for line in lines:
            self.say(line)
        self.on_end(session)

    def _next(self) -> str:
        words = ["hmdwarp", "study", "export", self.options.study, "--out", "DIR"]
        words += ["--store", str(self.options.store)] if self.options.store is not None else []
        words += [f"--{self.options.origin}"] if self.options.origin != PERSON else []
        return f"next: another participant, or {shlex.join(words)}"

    def _explained(self, error: HmdwarpError) -> HmdwarpError:
        """Return the same error with how to resume: it is the only line that will be read."""
        self.quiet = True
        if self.session is None:
            return error
        return type(error)(f"{error}; what was answered before is stored, {self.how_to_resume}")

    def last_words(self) -> str:
        """Return the words for the watchdog, which ends the program; answers are on the disk."""
        recorder = None if self.running is None else self.running.recording
        saved = recorder.save() if recorder is not None else ""
        if self.session is None:
            return ""
        return "; ".join(filter(None, (saved, "what was answered is stored", self.how_to_resume)))


@attrs.frozen
class _NoPipeline:
    """Stand-in for the driver's pipeline host where nothing is drawn."""

    options: LiveOptions  # between trials there is no pipeline, but the driver asks for these


_PACKAGES = ("numpy", "scipy", "moderngl", "glfw", "pyopenxr", "attrs")


def facts_of(display: Display, design: Design, trace: str) -> dict[str, Any]:
    """Return versions, machine, GPU, display and seed: no host, user or folder."""
    gpu, packages = display.gpu, dict[str, str]()
    for name in _PACKAGES:
        with suppress(metadata.PackageNotFoundError):
            packages[name] = metadata.version(name)
    return {
        "hmdwarp": __version__,
        "python": platform.python_version(),
        "packages": packages,
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
