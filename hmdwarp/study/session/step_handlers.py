"""What all steps of a session share, what each shows at a refresh and does at a command.

Names of steps, and panels between them; none of it tells a condition.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, Protocol, TypeVar

import attrs

from ...display import Command, Display, Label, Status
from ...geometry import Pose
from ...pipeline import Refresh
from ...poses import Origin, PoseSample
from ...run import FrameHandler
from ...scenes import scenes
from .. import design
from ..design import Ask, Condition, Design, Page, PageStep, Pause, Read, Show, Step
from ..dialogs import dialog_panels as dialogs
from ..dialogs.dialog_panels import InputHints, MessagePanel, hints_for, message_panel
from ..line_console import ConsoleState, LineConsole
from ..respondents import Simulated
from ..scales import WORDS
from ..store import COMPLETE, DECLINED, PILOT, SICK, SIMULATED, STOPPED, UNCONSENTED, Session, Store
from .markers import MarkerStream

PARTICIPANT, _EXPERIMENTER, RESPONDENT = "participant", "experimenter", "simulated"  # who sends commands
# Why a step ends before its time, by the command that requests it.
PAUSE, AGAIN, STOP, LOST = "pause", "again", "stop", "lost"
INTERRUPTS = {"menu": PAUSE, "pause": PAUSE, "again": AGAIN, "stop": STOP}
BREAK, REMARK = "break", "remark"  # the first waits for the end of the trial, the second changes nothing
CONFIRMS = frozenset({"confirm", "agree", "continue"})
TELL_NS = 200_000_000  # between two states for the console
_TRACKING_LOST = "tracking lost"


# Below both, a trial counts as one in which the head hardly moved. A head that is held still sways
# by some 2 degrees and 2 cm; one that looks around turns by tens of degrees within seconds. A warp
# has next to nothing to correct below these, whatever the latency.
_STILL_DEG, STILL_M = 5.0, 0.05


@attrs.define
class HeadRange:
    """Largest distances of a head from where it was first."""

    turn_deg: float = 0.0
    shift_m: float = 0.0
    _first: Pose | None = None

    def add(self, head: PoseSample) -> None:
        """Take a head; one held because tracking was lost is no motion."""
        if head.origin is Origin.HELD:
            return
        pose = head.pose
        if self._first is None:
            self._first = pose
            return
        near = abs(sum(a * b for a, b in zip(pose.unit_quaternion, self._first.unit_quaternion, strict=True)))
        self.turn_deg = max(self.turn_deg, math.degrees(2 * math.acos(min(near, 1.0))))
        self.shift_m = max(self.shift_m, math.dist(pose.position_m, self._first.position_m))

    @property
    def is_still(self) -> bool:
        return self.turn_deg < _STILL_DEG and self.shift_m < STILL_M

    def figures(self) -> dict[str, float | bool | None]:
        """Return the figures of study/actual.py; None throughout where no head was seen."""
        if self._first is None:
            return {"head_turn_deg": None, "head_shift_m": None, "head_still": None}
        return {"head_turn_deg": self.turn_deg, "head_shift_m": self.shift_m, "head_still": self.is_still}


# Keys of what comes between the steps.
READY, MENU, REQUESTED_BREAK, STOP_RULE, END = ("ready", "menu", "asked-break", "sick", "end")
_NO_PART = ("Thank you", "You are not taking part. Nothing was asked or shown.")
FAREWELL = {
    COMPLETE: ("Thank you", "That was all. You may take off the headset."),
    STOPPED: ("Thank you", "The session has ended. What you answered is kept."),
    DECLINED: _NO_PART,
    UNCONSENTED: _NO_PART,
    SICK: ("Thank you", "The session has ended. Take your time, have some water, and tell us how you feel."),
}


def step_name(step: Step, steps: Sequence[Step]) -> str:
    """Return "trial 3 of 12", and the like."""
    if isinstance(step, Pause):
        return "break"
    if isinstance(step, PageStep):
        return "instructions"
    if isinstance(step, Read):
        names = {READY: "about to begin", STOP_RULE: "the session ends", END: "session finished"}
        return names.get(step.key, "consent")
    if isinstance(step, Ask) and not step.about:
        items, title = step.scale.items, step.scale.title
        return title if len(items) == 1 else f"{title}, item {items.index(step.item) + 1} of {len(items)}"
    turn = f", {step.turn}" if isinstance(step, Show) and step.turn else ""
    return f"trial {step.trial} of {_trials(steps)}{turn}" if step.trial else "practice"


def ready_panel(
    next_step: Step, steps: Sequence[Step], resumed: bool, hints: InputHints, own: Page | None = None
) -> MessagePanel:
    """Make the panel before the first step, and the first trial. own: the plan's words."""
    next_name = "a break" if isinstance(next_step, Pause) else step_name(next_step, steps)
    resumes = f"We go on with {next_name}. " if resumed else ""
    look = f"{hints.look} " if isinstance(next_step, Show) else ""
    begin = f"{hints.confirm}: begin"
    if own is not None:
        keys = f"{look}{hints.menu}: menu, break, stop\n{begin}"
        return page_panel(own, keys, f"{resumes}{own.text}")
    menu = f"{hints.menu} opens a menu at any time: to have a break, or to stop without a reason."
    return message_panel("Ready?", f"{resumes}Sit comfortably. {look}{menu}", begin)


def scene_reacts(condition: Condition) -> bool:
    """Return whether the scene of a trial reacts to what people do."""
    name = condition.settings.get("scene")
    return name in scenes.names() and scenes.get(str(name)).reacts is not None


def number_panel(step: Show, steps: Sequence[Step], hints: InputHints) -> MessagePanel:
    """Make the panel before a trial: its number, never its condition, and what to do in it."""
    reacts = scene_reacts(step.condition)
    confirm = (reacts and hints.done) or hints.confirm
    hint = f"Look around as long as you like. {confirm}: done" if step.until_done else ""
    number = f"Trial {step.trial} of {_trials(steps)}{f': {step.turn}' if step.turn else ''}"
    title = number if step.trial else "Practice: look around, it is not rated"
    return message_panel(title, hint=f"{hint}\n{hints.act if reacts else ''}".strip())


def sick_panel(asks_after: bool, hints: InputHints) -> MessagePanel:
    """Make the panel that the stop rule shows in place of the next trial."""
    left = "A few questions are left, if you like; each may be left out."
    text = "You do not feel well enough to go on, so this is the last of it. "
    text += left if asks_after else "There is nothing more to do."
    return message_panel("We stop here", text, f"{hints.confirm}: go on · {hints.menu}: menu")


def page_panel(page: Page, hint: str, text: str) -> MessagePanel:
    """Make the panel of a page without buttons."""
    return attrs.evolve(message_panel(page.title, text, hint), picture=page.picture)


def _trials(steps: Sequence[Step]) -> int:
    """Count the trials, without the practice."""
    return max((step.trial for step in steps if isinstance(step, Show)), default=0)


@attrs.define(eq=False)
class SessionContext:
    """Context that all steps of a session share."""

    design: Design
    session: Session  # as it was begun or resumed
    store: Store
    display: Display
    console: LineConsole
    respondent: Simulated | None  # who answers in place of the participant
    steps: tuple[Step, ...]  # all of the session
    done: set[str]  # keys of the steps that are over
    markers: MarkerStream | None = None
    shown: Show | None = None  # the step shown last
    break_due: bool = False  # whether a requested break waits for the end of the trial
    head: PoseSample | None = None  # as it was last seen, None before
    before_s: float = 0.0  # from the session's start to that of this run of the program
    # (sender, command) that came when its step had just ended, for the next one.
    late: list[tuple[str, Command]] = attrs.field(factory=list)
    _begun_ns: int = attrs.field(init=False)
    _state_ns: int | None = None  # when the console got its last state

    def __attrs_post_init__(self) -> None:
        self._begun_ns = self.display.now_ns()

    @property
    def tells_condition(self) -> bool:
        """Whether the experimenter may know the condition."""
        return self.design.blind in (design.PARTICIPANT, design.UNBLINDED)

    @property
    def elapsed_s(self) -> float:
        """Time since this run of the program began."""
        return (self.display.now_ns() - self._begun_ns) * 1e-9

    def now_s(self) -> float:
        return self.display.now_ns() * 1e-9

    def received(self, commands: Sequence[Command], step: Step, elapsed_s: float) -> list[tuple[str, Command]]:
        """Return (sender, command) since the last call. commands: those of the display."""
        late, self.late = self.late, []
        answers = self.respondent.commands(step, self.shown, elapsed_s) if self.respondent is not None else ()
        return [
            *late,
            *((PARTICIPANT, command) for command in commands),
            *((_EXPERIMENTER, command) for command in self.console.commands()),
            *((RESPONDENT, command) for command in answers),
        ]

    def title(self, step: Step) -> str:
        """Return the title of the window, which never tells a condition."""
        return f"study {self.design.name} - {step_name(step, self.steps)}"

    def record(self, kind: str, step: Step, **data: object) -> None:
        """Write to the journal of the session; on the disk when this returns."""
        self.store.record(self.session, kind, step.key, **data)

    def mark(self, event: str, step: Step, at_ns: int, **data: object) -> None:
        """Send a marker of the step, with the word that stands for the participant in exports."""
        if self.markers is not None:
            who = {"participant": self.session.sub, "session": self.session.number}
            self.markers.send(event, at_ns, step=step.key, **who, **data)

    def plan_break(self, by: str, step: Step) -> None:
        """Plan a requested break for the end of the trial and its questions."""
        self.record("break", step, by=by)
        self.break_due = True
        self.console.say("a break comes after this trial")

    def begin_step(self, step: Step) -> None:
        """Set the title of the window; the console gets a state at the next refresh."""
        self._state_ns = None
        self.display.show_status(Status(heading=self.title(step)))

    def tell(self, step: Step, describe: Callable[[], Mapping[str, Any]], *, looks: bool = True) -> None:
        """Tell the console a few times a second. looks: asks for the head, as no frame did."""
        now_ns = self.display.now_ns()
        if self._state_ns is not None and now_ns - self._state_ns < TELL_NS:
            return
        self._state_ns = now_ns
        if looks:
            self.head = self.display.source.head_at(now_ns)
        head, session = self.head, self.session
        origin = {PILOT: " - PILOT", SIMULATED: " - SIMULATED"}.get(session.origin, "")
        state = ConsoleState(
            heading=f"study {self.design.name}, participant {session.code}, session {session.number}{origin}",
            participant=f"{session.code}{origin}",
            step=step_name(step, self.steps),
            elapsed_s=self.elapsed_s,
            notice=_TRACKING_LOST if head is not None and head.origin is Origin.HELD else "",
            **describe(),
        )
        self.console.tell(state)


class StepHandler(FrameHandler):
    """Refreshes of one step; an interrupt is in the journal before it has effect."""

    pictures = False
    phase = ""  # as in ConsoleState

    def __init__(self, context: SessionContext, step: Step, during: Step | None = None) -> None:
        self.context, self.step = context, step
        self._named = during or step  # the step that title and console name: the menu names the interrupted one
        self.interrupt = ""  # why it ended before its time: a value of INTERRUPTS, or LOST
        self.by = ""  # who ended it
        self.began_ns = context.display.now_ns()
        context.begin_step(self._named)

    @property
    def elapsed_s(self) -> float:
        return (self.context.display.now_ns() - self.began_ns) * 1e-9

    def finished(self) -> bool:
        """Return whether the step came to its end."""
        raise NotImplementedError

    def take(self, by: str, command: Command) -> None:
        """Carry out a command of this step alone."""
        raise NotImplementedError

    def describe(self) -> Mapping[str, Any]:
        """Return the fields of ConsoleState that belong to the step."""
        return {"phase": self.phase}

    def over(self) -> bool:
        return bool(self.interrupt) or self.finished()

    def handle(self, commands: Sequence[Command]) -> bool:
        """Carry out all commands; never changes the options of the run.

        After its end they are dropped but for stop, menu and break, which wait for the next step.
        """
        context = self.context
        for by, command in context.received(commands, self.step, self.elapsed_s):
            if command.control == REMARK:
                if text := str(command.value or "").strip():
                    context.record("remark", self.step, by=by, text=text)
                    context.console.say("the remark is kept")
            elif not self.over():
                self.receive(by, command)
            elif command.control == BREAK:
                context.plan_break(by, self.step)
            elif command.control == STOP or (
                command.control in INTERRUPTS and not self.interrupt and self.phase != "paused"
            ):
                context.late.append((by, command))
        context.tell(self._named, self.describe, looks=not self.pictures)
        return False

    def receive(self, by: str, command: Command) -> None:
        """Carry out a command that came during the step."""
        if command.control in INTERRUPTS:
            self.interrupt, self.by = INTERRUPTS[command.control], by
            self.context.record(self.interrupt, self.step, by=by, after_s=self.elapsed_s)
        elif command.control == BREAK:
            self.context.plan_break(by, self.step)
        else:
            self.take(by, command)

    def arrived(self, refresh: Refresh) -> None:
        self.context.head = refresh.head

    def on_display_lost(self, why: str) -> None:
        self.context.record(LOST, self.step, why=why)


class Dialog(Protocol):
    """Dialog with the participant."""

    @property
    def over(self) -> bool: ...

    def panel(self) -> Label: ...

    def handle(self, commands: Sequence[Command]) -> None: ...


D = TypeVar("D", bound=Dialog)


class DialogHandler(StepHandler, Generic[D]):
    """Step that is a dialog."""

    def __init__(
        self, context: SessionContext, step: Step, dialog: D, during: Step | None = None, phase: str = ""
    ) -> None:
        self.phase = phase or self.phase
        super().__init__(context, step, during)
        self.dialog = dialog
        self.seconds = 0.0  # until it was over

    def finished(self) -> bool:
        return self.dialog.over

    def label(self) -> Label:
        return self.dialog.panel()

    def take(self, by: str, command: Command) -> None:
        self.dialog.handle((command,))
        if self.finished():
            self.by, self.seconds = by, self.elapsed_s


class QuestionHandler(DialogHandler[dialogs.QuestionDialog | dialogs.TextDialog]):
    """Question. again: whether it was asked before."""

    phase = "asking"

    def __init__(self, context: SessionContext, ask: Ask, again: bool = False) -> None:
        hints, is_text = hints_for(context.display.name), ask.item.answer == WORDS
        dialog = (
            dialogs.TextDialog(ask, hints, again)
            if is_text
            else dialogs.QuestionDialog(ask, context.now_s, hints, again)
        )
        super().__init__(context, ask, dialog)

    def leave_unanswered(self) -> None:
        self.take(self.by or PARTICIPANT, Command("answer", None))

    def take(self, by: str, command: Command) -> None:
        """Pass the command to the question; the experimenter's skip leaves it unanswered."""
        skips = command.control == "skip" and by != PARTICIPANT
        super().take(by, Command("answer", None) if skips else command)

    def describe(self) -> Mapping[str, Any]:
        return {"phase": self.phase, "question": self.dialog.question()}


class BreakHandler(DialogHandler[dialogs.BreakDialog]):
    """Break. until_ns: when it may end, on the display's clock."""

    phase = "break"

    def __init__(self, context: SessionContext, pause: Pause, until_ns: int) -> None:
        left_s = max(0.0, (until_ns - context.display.now_ns()) * 1e-9)
        super().__init__(context, pause, dialogs.BreakDialog(left_s, context.now_s, hints_for(context.display.name)))

    def receive(self, by: str, command: Command) -> None:
        """Ignore a request for a break within a break."""
        if command.control != BREAK:
            super().receive(by, command)

    def describe(self) -> Mapping[str, Any]:
        return {"phase": self.phase, "left_s": self.dialog.left_s}


class MenuHandler(DialogHandler[dialogs.MenuDialog]):
    """Menu, which the experimenter's pause opens too. during: the interrupted step."""

    phase = "paused"

    def __init__(self, context: SessionContext, pause: Pause, offered: Sequence[str], during: Step) -> None:
        super().__init__(context, pause, dialogs.MenuDialog(offered, hints_for(context.display.name)), during)

    def receive(self, by: str, command: Command) -> None:
        """Pass every command to the menu; the choice is in the journal before it has effect."""
        if command.control != "pause":
            self.take(by, command)
            if self.finished():
                self.context.record(self.dialog.chosen, self.step, by=by)


class ConfirmHandler(StepHandler):
    """Panel that stays until it is confirmed."""

    phase = "waiting"

    def __init__(self, context: SessionContext, read: Read, panel: MessagePanel) -> None:
        super().__init__(context, read)
        self._panel, self._confirmed = panel, False

    def finished(self) -> bool:
        return self._confirmed

    def label(self) -> Label:
        return self._panel

    def take(self, by: str, command: Command) -> None:
        if command.control in CONFIRMS:
            self.by, self._confirmed = by, True


class PanelHandler(FrameHandler):
    """Panel that stays for some refreshes or seconds; commands wait for the next step."""

    pictures = False

    def __init__(
        self,
        context: SessionContext,
        step: Step,
        panel: MessagePanel,
        refreshes: int = 1,
        seconds: float = 0.0,
        phase: str = "showing",
        may_close: bool = False,
    ) -> None:
        self._context, self._step, self._panel, self._left, self._phase = context, step, panel, refreshes, phase
        self._may_close, self._is_closed = may_close, False
        self._until_ns = context.display.now_ns() + round(seconds * 1e9)
        context.begin_step(step)

    def over(self) -> bool:
        """Return whether both the refreshes and the seconds are over."""
        return self._is_closed or self._left <= 0 and self._context.display.now_ns() >= self._until_ns

    def label(self) -> Label:
        """Return the panel; called once a refresh."""
        self._left -= 1
        return self._panel

    def handle(self, commands: Sequence[Command]) -> bool:
        """Tell the console; no command does anything but close it, where it may be."""
        self._is_closed = self._may_close and any(command.control in CONFIRMS for command in commands)
        self._context.tell(self._step, lambda: {"phase": self._phase})
        return False

    def arrived(self, refresh: Refresh) -> None: ...

    def on_display_lost(self, why: str) -> None: ...  # the step itself has not begun
