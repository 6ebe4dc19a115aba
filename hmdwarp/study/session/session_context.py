"""Context that all steps of a session share: participant, display, journal, console."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs

from ...display import Command, Display, Status
from ...poses import Origin, PoseSample
from ..console.line_console import ConsoleState, LineConsole
from ..design import PARTICIPANT as BLIND_TO_PARTICIPANT
from ..design import UNBLINDED, Design, Show, Step
from ..respondents import Respondent
from ..store import PILOT, SIMULATED, Session, Store
from .markers import MarkerStream
from .wording import step_name

PARTICIPANT, EXPERIMENTER, RESPONDENT = "participant", "experimenter", "simulated"  # who sends commands
# Why a step ends before its time, by the command that requests it.
PAUSE, AGAIN, STOP = "pause", "again", "stop"
INTERRUPTS = {"menu": PAUSE, "pause": PAUSE, "again": AGAIN, "stop": STOP}
BREAK, REMARK = "break", "remark"  # the first waits for the end of the trial, the second changes nothing
TELL_NS = 200_000_000  # between two states for the console
TRACKING_LOST = "tracking lost"


@attrs.define
class CommandSources:
    """Everything that sends commands: the participant's input, the console, a respondent."""

    console: LineConsole
    respondent: Respondent
    # (sender, command) that came when its step had just ended, for the next one.
    late: list[tuple[str, Command]] = attrs.field(factory=list)

    def received(
        self, commands: Sequence[Command], step: Step, shown: Show | None, elapsed_s: float
    ) -> list[tuple[str, Command]]:
        """Return (sender, command) since the last call. commands: those of the display."""
        late, self.late = self.late, []
        return [
            *late,
            *((PARTICIPANT, command) for command in commands),
            *((EXPERIMENTER, command) for command in self.console.commands()),
            *((RESPONDENT, command) for command in self.respondent.commands(step, shown, elapsed_s)),
        ]


@attrs.define(eq=False)
class SessionContext:
    """Context that all steps of a session share."""

    design: Design
    session: Session  # as it was begun or resumed
    store: Store
    display: Display
    sources: CommandSources
    steps: tuple[Step, ...]  # all of the session
    done: set[str]  # keys of the steps that are over
    markers: MarkerStream | None = None
    shown: Show | None = None  # the step shown last
    break_due: bool = False  # whether a requested break waits for the end of the trial
    head: PoseSample | None = None  # as it was last seen, None before
    before_s: float = 0.0  # from the session's start to that of this run of the program
    _begun_ns: int = attrs.field(init=False)
    _state_ns: int | None = None  # when the console got its last state

    def __attrs_post_init__(self) -> None:
        self._begun_ns = self.display.now_ns()

    @property
    def tells_condition(self) -> bool:
        """Whether the experimenter may know the condition."""
        return self.design.blind in (BLIND_TO_PARTICIPANT, UNBLINDED)

    @property
    def elapsed_s(self) -> float:
        """Time since this run of the program began."""
        return (self.display.now_ns() - self._begun_ns) * 1e-9

    def now_s(self) -> float:
        """Return the time of the display's clock in seconds."""
        return self.display.now_ns() * 1e-9

    def title(self, step: Step) -> str:
        """Return the title of the window, which never tells a condition."""
        return f"study {self.design.name} - {step_name(step, self.steps)}"

    def say(self, text: str) -> None:
        """Add a line to the experimenter's console."""
        self.sources.console.say(text)

    def record(self, kind: str, step: Step, **data: object) -> None:
        """Write to the journal of the session; on the disk when this returns."""
        self.store.record(self.session, kind, step.key, **data)

    def mark(self, event: str, step: Step, at_ns: int, **data: object) -> None:
        """Send a marker of the step, with the word that stands for the participant in exports."""
        if self.markers is not None:
            who = {"participant": self.session.sub, "session": self.session.number}
            self.markers.send(event, at_ns, step=step.key, **who, **data)

    def remark(self, by: str, command: Command, step: Step) -> None:
        """Keep a remark."""
        text = str(command.value or "").strip()
        if text:
            self.record("remark", step, by=by, text=text)
            self.say("the remark is kept")

    def plan_break(self, by: str, step: Step) -> None:
        """Plan a requested break for the end of the trial and its questions."""
        self.record("break", step, by=by)
        self.break_due = True
        self.say("a break comes after this trial")

    def begin_step(self, step: Step) -> None:
        """Set the title of the window; the console gets a state at the next refresh."""
        self._state_ns = None
        self.display.show_status(Status(heading=self.title(step)))

    def tell(self, step: Step, describe: Callable[[], Mapping[str, Any]], *, looks: bool = True) -> None:
        """Tell the console a few times a second.

        describe: returns fields of ConsoleState. looks: whether to ask for the head, as no frame
        did.
        Errors: Lost.
        """
        now_ns = self.display.now_ns()
        if self._state_ns is not None and now_ns - self._state_ns < TELL_NS:
            return
        self._state_ns = now_ns
        if looks:
            self.head = self.display.source.head_at(now_ns)
        self.sources.console.tell(self._state(step, describe()))

    def _state(self, step: Step, described: Mapping[str, Any]) -> ConsoleState:
        head, session = self.head, self.session
        origin = {PILOT: " - PILOT", SIMULATED: " - SIMULATED"}.get(session.origin, "")
        return ConsoleState(
            heading=f"study {self.design.name}, participant {session.code}, session {session.number}{origin}",
            participant=f"{session.code}{origin}",
            step=step_name(step, self.steps),
            elapsed_s=self.elapsed_s,
            notice=TRACKING_LOST if head is not None and head.origin is Origin.HELD else "",
            **described,
        )
