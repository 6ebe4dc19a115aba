"""Steps without pictures: a question, a text that is agreed to, a break, the menu, a plate that waits to be confirmed."""

from __future__ import annotations

from collections.abc import Sequence

from ...display import Command, Label
from ...run.live.driver import FrameHandler
from ..asking import Asked, Card, Menu, Reading, Resting, hints_for
from ..steps import Ask, Pause, Read, Step
from .room import Room
from .voices import PARTICIPANT
from .watch import StepHandler

CONFIRMS = frozenset({"confirm", "agree", "continue"})


class Question(StepHandler):
    """value: what was answered, None for "cannot say"; by: by whom; seconds: how long that took. again: whether it was before."""

    phase = "asking"

    def __init__(self, room: Room, ask: Ask, again: bool = False) -> None:
        super().__init__(room, ask)
        self._asked = Asked(ask, room.now_s, hints_for(room.display.name), again)
        self.seconds = 0.0

    def left_unanswered(self) -> Question:
        """By the menu."""
        self.by, self.seconds = self.by or PARTICIPANT, self.asked_s
        self._asked.obey((Command("answer", None),))
        return self

    @property
    def value(self) -> float | None:
        """Of the scale."""
        return self._asked.value

    def finished(self) -> bool:
        """Confirmed, or left unanswered."""
        return self._asked.confirmed

    def label(self) -> Label:
        """The question."""
        return self._asked.label()

    def take(self, by: str, command: Command) -> None:
        """To the question. The experimenter has confirmed a skip already."""
        if command.control == "skip" and by != PARTICIPANT:
            command = Command("answer", None)
        self._asked.obey((command,))
        if self.finished():
            self.by, self.seconds = by, self.asked_s

    def told(self) -> dict[str, object]:
        """With the question."""
        return {"phase": self.phase, "question": self._asked.question()}


class Consent(StepHandler):
    """refused: whether the end came by "I do not agree"."""

    phase = "reading"

    def __init__(self, room: Room, read: Read) -> None:
        super().__init__(room, read)
        self._reading = Reading(read.text, room.now_s, hints_for(room.display.name))

    @property
    def refused(self) -> bool:
        """Instead of agreed."""
        return self._reading.refused

    def finished(self) -> bool:
        """One way or the other."""
        return self._reading.agreed or self._reading.refused

    def label(self) -> Label:
        """A page of the text."""
        return self._reading.label()

    def take(self, by: str, command: Command) -> None:
        """Pages, and the choice."""
        self._reading.obey((command,))
        if self.finished():
            self.by = by


class Break(StepHandler):
    """A break, over when its time is and somebody says so. until_ns: when it may be, where it has begun before; None for from now on."""

    phase = "break"

    def __init__(self, room: Room, pause: Pause, until_ns: int | None = None) -> None:
        super().__init__(room, pause)
        self.until_ns = self.began_ns + round(pause.seconds * 1e9) if until_ns is None else until_ns
        left_s = max(0.0, (self.until_ns - self.began_ns) * 1e-9)
        self._resting = Resting(left_s, room.now_s, hints_for(room.display.name))

    def finished(self) -> bool:
        """When somebody went on."""
        return self._resting.over

    def label(self) -> Label:
        """With the time that is left."""
        return self._resting.label()

    def hear(self, by: str, command: Command) -> None:
        """A break within a break is none."""
        if command.control != "break":
            super().hear(by, command)

    def take(self, by: str, command: Command) -> None:
        """To go on."""
        self._resting.obey((command,))
        if self.finished():
            self.by = by

    def told(self) -> dict[str, object]:
        """With the time that is left."""
        return {"phase": self.phase, "left_s": self._resting.left_s}


class MenuWatch(StepHandler):
    """The menu, which the experimenter's pause opens too. during: what it came in between. chosen: of asking.CONTINUE, BREAK, AGAIN,
    SKIP, STOP."""

    phase = "paused"

    def __init__(self, room: Room, pause: Pause, offered: Sequence[str], during: Step) -> None:
        super().__init__(room, pause, during)
        self._menu = Menu(offered, hints_for(room.display.name))

    @property
    def chosen(self) -> str:
        """ "" before."""
        return self._menu.chosen

    def finished(self) -> bool:
        """When something was chosen."""
        return bool(self._menu.chosen)

    def label(self) -> Label:
        """The menu."""
        return self._menu.label()

    def hear(self, by: str, command: Command) -> None:
        """All of it is the menu's; what was chosen is in the journal before it has effect."""
        if command.control == "pause":
            return
        self._menu.obey((command,))
        if self.finished():
            self.by = by
            self.room.record(self.chosen, self.step, by=by)

    take = hear


class Waiting(StepHandler):
    """A plate that stands there until somebody confirms it."""

    phase = "waiting"

    def __init__(self, room: Room, read: Read, plate: Card) -> None:
        super().__init__(room, read)
        self._plate, self._confirmed = plate, False

    def finished(self) -> bool:
        """When somebody has confirmed."""
        return self._confirmed

    def label(self) -> Label:
        """The plate."""
        return self._plate

    def take(self, by: str, command: Command) -> None:
        """To confirm."""
        if command.control in CONFIRMS:
            self.by, self._confirmed = by, True


class Standing(FrameHandler):
    """A plate that stands there for some refreshes, or some seconds; what is asked for meanwhile waits for the next step, or is nothing."""

    pictures = False

    def __init__(
        self, room: Room, step: Step, plate: Card, refreshes: int = 1, seconds: float = 0.0, phase: str = "showing"
    ) -> None:
        self._room, self._step, self._plate, self._left, self._phase = room, step, plate, refreshes, phase
        self._until_ns = room.display.now_ns() + round(seconds * 1e9)
        room.entitle(step)

    def over(self) -> bool:
        """As Watch.over."""
        return self._left <= 0 and self._room.display.now_ns() >= self._until_ns

    def label(self) -> Label:
        """As Watch.label; asked once a refresh."""
        self._left -= 1
        return self._plate

    def obey(self, commands: Sequence[Command]) -> bool:
        """As Watch.obey."""
        self._room.tell(self._step, lambda: {"phase": self._phase})
        return False
