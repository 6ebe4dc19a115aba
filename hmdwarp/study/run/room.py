"""What all steps of a session share: whose it is, who looks, who listens; the journal, and what is told on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import attrs

from ...display import Command, Display
from ...display.status import Status
from ...poses import Origin, PoseSample
from ..design import NOBODY, PARTICIPANT, Design, Show, Step
from ..desk import DeskState
from ..store import Session, Store
from .telling import told, turned_deg
from .voices import Voices

TELL_NS = 200_000_000  # between two tellings of the desk
TRACKING_LOST = "tracking lost"


@attrs.define(eq=False)
class Room:
    """session: as it was begun or gone on with. steps: all of it. done: keys of those that are over. heading: for the desk. status: what
    the window's title tells, never a condition. shown: what was last shown. break_due: whether a break
    was asked for that comes once the trial is over. late: what was asked for, and by whom, when its step had just ended, and is for the
    next. head: as it was last seen, None before.
    """

    design: Design
    session: Session
    store: Store
    display: Display
    voices: Voices
    steps: tuple[Step, ...]
    done: set[str]
    heading: str
    status: Status = attrs.field(factory=Status)
    shown: Show | None = None
    break_due: bool = False
    late: list[tuple[str, Command]] = attrs.field(factory=list)
    head: PoseSample | None = None
    _begun_ns: int = attrs.field(init=False)
    _told_ns: int | None = None

    def __attrs_post_init__(self) -> None:
        self._begun_ns = self.display.now_ns()

    @property
    def tells_condition(self) -> bool:
        """Whether the experimenter may know what is on."""
        return self.design.blind in (PARTICIPANT, NOBODY)

    def now_s(self) -> float:
        """The display's clock, in seconds."""
        return self.display.now_ns() * 1e-9

    @property
    def elapsed_s(self) -> float:
        """Of this sitting."""
        return (self.display.now_ns() - self._begun_ns) * 1e-9

    def say(self, text: str) -> None:
        """A line for the experimenter."""
        self.voices.desk.say(text)

    def record(self, kind: str, step: Step, **data: object) -> None:
        """Into the journal; on the disk when this returns."""
        self.store.record(self.session, kind, step.key, **data)

    def remark(self, by: str, command: Command, step: Step) -> None:
        """Somebody has something to say of it."""
        text = str(command.value or "").strip()
        if text:
            self.record("remark", step, by=by, text=text)
            self.say("the remark is kept")

    def plan_break(self, by: str, step: Step) -> None:
        """One that was not planned, once the trial and what is asked about it are over."""
        self.record("break", step, by=by)
        self.break_due = True
        self.say("a break comes after this trial")

    def entitle(self, step: Step) -> None:
        """What the window's title says from now on; the desk hears of it at the next refresh."""
        self._told_ns = None
        self.status.heading = f"study {self.design.name} - {told(step, self.steps)}"
        self.display.tell(self.status)

    def tell(self, step: Step, more: Callable[[], Mapping[str, object]], *, looks: bool = True) -> None:
        """What the desk shows, a few times a second. more: of desk.DeskState. looks: whether to ask where the head is, as no picture did.

        Errors: Lost.
        """
        now_ns = self.display.now_ns()
        if self._told_ns is not None and now_ns - self._told_ns < TELL_NS:
            return
        self._told_ns = now_ns
        if looks:
            self.head = self.display.source.head_at(now_ns)
        self.voices.desk.tell(self._state(step, more()))

    def _state(self, step: Step, more: Mapping[str, object]) -> DeskState:
        head = self.head
        place = None if head is None else tuple(map(float, head.pose.position_m))
        return DeskState(
            heading=self.heading,
            step=told(step, self.steps),
            done=len(self.done.intersection(one.key for one in self.steps)) / max(len(self.steps), 1),
            elapsed_s=self.elapsed_s,
            position_m=place,
            turned_deg=None if head is None else turned_deg(head.pose),
            notice=TRACKING_LOST if head is not None and head.origin is Origin.HELD else "",
            **more,
        )
