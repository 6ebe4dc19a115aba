"""A stretch of refreshes that belongs to one step of a session: what everybody may ask for in each of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...display import Command
from ...run.live.driver import FrameHandler
from ..steps import Step
from .room import Room
from .voices import BREAK, INTENTS, REMARK, STOP

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh

LOST = "lost"


class StepHandler(FrameHandler):
    """intent: what ended it before its time, a value of INTENTS or LOST; "" as long as nothing did. by: who asked for that.

    during: the step that is told of, where it is another: that which the menu came in between. Subclasses say what else they take, when
    they are finished, and what lies over the picture. An intent is in the journal before it has effect.
    """

    pictures = False
    phase = ""

    def __init__(self, room: Room, step: Step, during: Step | None = None) -> None:
        self.room, self.step, self._told_of = room, step, during or step
        self.intent = self.by = ""
        self.began_ns = room.display.now_ns()
        room.entitle(self._told_of)

    @property
    def asked_s(self) -> float:
        """How long it has been on."""
        return (self.room.display.now_ns() - self.began_ns) * 1e-9

    def finished(self) -> bool:
        """Whether it came to its end."""
        raise NotImplementedError

    def take(self, by: str, command: Command) -> None:
        """Do what was asked for, as far as it is this step's."""
        raise NotImplementedError

    def told(self) -> dict[str, object]:
        """What the desk is told of it, as desk.DeskState has it."""
        return {"phase": self.phase}

    def over(self) -> bool:
        """As Watch.over."""
        return bool(self.intent) or self.finished()

    def obey(self, commands: Sequence[Command]) -> bool:
        """As Watch.obey. What comes after the end of a step is not for the next one: it was meant for this. But who wants to stop, or to
        rest, is not passed over for having asked at the refresh at which a step ended."""
        room = self.room
        late, room.late = room.late, []
        for by, command in (*late, *room.voices.heard(commands, self.step, room.shown, self.asked_s)):
            if command.control == REMARK:
                room.remark(by, command, self.step)
            elif not self.over():
                self.hear(by, command)
            else:
                self._hear_late(by, command)
        room.tell(self._told_of, self.told, looks=not self.pictures)
        return False

    def _hear_late(self, by: str, command: Command) -> None:
        """Something asked for when it had just ended. A menu that was closed does not open again for one press too many."""
        if command.control == BREAK:
            self.room.plan_break(by, self.step)
        elif command.control == STOP or (command.control in INTENTS and not self.intent and self.phase != "paused"):
            self.room.late.append((by, command))

    def hear(self, by: str, command: Command) -> None:
        """Something asked for while it goes on."""
        if command.control in INTENTS:
            self.intend(INTENTS[command.control], by)
        elif command.control == BREAK:
            self.room.plan_break(by, self.step)
        else:
            self.take(by, command)

    def intend(self, intent: str, by: str) -> None:
        """End before its time."""
        self.room.record(intent, self.step, by=by, after_s=self.asked_s)
        self.intent, self.by = intent, by

    def arrived(self, refresh: Refresh) -> None:
        """As Watch.arrived."""
        self.room.head = refresh.head

    def went(self, why: str) -> None:
        """As Watch.went."""
        self.room.record(LOST, self.step, why=why)
