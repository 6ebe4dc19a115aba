"""One condition, shown: black with its number first, then the pictures, and nothing written over them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...display import Command, Label
from ...errors import InputError
from ..steps import Show
from .room import Room
from .watch import LOST, StepWatch

if TYPE_CHECKING:
    from ...live.log import LiveLog
    from ...loop import Refresh

LEAD_S = 1.0  # black with the number before the first picture, at least: the last trial fades, eyes rest
SETTLED_S = 0.25  # beyond the longest latency: frames that come late now and then
PATIENCE_S = 30.0  # how long the first frame may take


def lead_s(latencies_ms: list[float]) -> float:
    """How long a trial is black before its pictures, the same for all trials of a study: a wait as long as the latency would tell it."""
    return max(LEAD_S, max(latencies_ms, default=0.0) * 1e-3 + SETTLED_S)


class Trial(StepWatch):
    """plate: lies over the black before it. log: of its pictures. In the lead the server draws already, so that at the first picture frames
    are under way as in the middle of a run. The time of a trial counts from its first picture on, on the display's clock.

    Errors, out of the driver: InputError where no frame arrives.
    """

    ahead = True
    phase = "showing"

    def __init__(self, room: Room, step: Show, plate: Label, log: LiveLog, lead: float) -> None:
        super().__init__(room, step)
        self._show, self._plate, self._log, self._lead_s = step, plate, log, lead
        self._arrived = False
        self._first_ns: int | None = None
        room.display.restart()

    @property
    def seen_s(self) -> float:
        """Since the first picture."""
        return 0.0 if self._first_ns is None else (self.room.display.now_ns() - self._first_ns) * 1e-9

    def finished(self) -> bool:
        """After its seconds."""
        return self._first_ns is not None and self.seen_s >= self._show.seconds

    def label(self) -> Label:
        """Nothing, while there are pictures."""
        return "" if self.pictures else self._plate

    def arrived(self, refresh: Refresh) -> None:
        """As Watch.arrived."""
        super().arrived(refresh)
        self._arrived = True
        if self.pictures and self._first_ns is None:
            self._first_ns = self.room.display.now_ns()

    def take(self, by: str, command: Command) -> None:
        """Nobody changes a trial."""

    def obey(self, commands: Sequence[Command]) -> bool:
        """As Watch.obey."""
        super().obey(commands)
        if not self.pictures and self.asked_s >= self._lead_s:
            self.pictures = self._arrived
            if not self._arrived and self.asked_s >= self._lead_s + PATIENCE_S:
                raise InputError(f"{self.step.key}: no frame came within {PATIENCE_S:g} s: see what loss and bandwidth let through")
        return False

    def went(self, why: str) -> None:
        """It is shown again, from its start: what was rated must have been seen undisturbed."""
        super().went(why)
        self.intent = LOST

    def told(self) -> dict[str, object]:
        """As StepWatch.told. How many pictures a second there are is told; how old they are would tell the condition."""
        status, room = self._log.status, self.room
        condition = self._show.condition.name if room.tells_condition else ""
        left = self._show.seconds - self.seen_s
        return {"phase": self.phase, "left_s": left, "rate_hz": status.rate_hz, "missed": status.missed, "condition": condition}
