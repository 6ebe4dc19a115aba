"""One condition, shown: black with its number first, then the pictures, and nothing written over them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...display import Command, Label
from ...errors import InputError
from ..steps import Show
from .room import Room
from .watch import LOST, StepHandler

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh
    from ...run.live.log import LiveLog

LEAD_S = 1.0  # black with the number, at least, before frames get under way: eyes rest, and building a pipeline takes no longer mostly
SETTLED_S = 0.25  # beyond the longest latency: frames that come late now and then
PATIENCE_S = 30.0  # how long the first frame may take


def under_way_s(latencies_ms: list[float]) -> float:
    """How long frames are under way before the first picture, the same for all trials of a study: a wait as long as the latency, or as
    building the pipeline takes, would tell which condition comes."""
    return max(latencies_ms, default=0.0) * 1e-3 + SETTLED_S


class Trial(StepHandler):
    """plate: lies over the black before it, and has since plated_ns. log: of its pictures. under_way: see under_way_s. In the black the
    server draws already, so that at the first picture frames are under way as in the middle of a run; a recorded head begins anew that
    long before it. The time of a trial counts from its first picture on, on the display's clock.

    Errors, out of the driver: InputError where no frame arrives.
    """

    ahead = True
    phase = "showing"

    def __init__(self, room: Room, step: Show, plate: Label, plated_ns: int, log: LiveLog, under_way: float) -> None:
        super().__init__(room, step)
        self._show, self._plate, self._plated_ns, self._log, self._under_way_s = step, plate, plated_ns, log, under_way
        self._arrived = False
        self._restarted_ns: int | None = None
        self._first_ns: int | None = None

    @property
    def seen_s(self) -> float:
        """Since the first picture."""
        return self._since_s(self._first_ns)

    def _since_s(self, instant_ns: int | None) -> float:
        return 0.0 if instant_ns is None else (self.room.display.now_ns() - instant_ns) * 1e-9

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
        if not self.pictures:
            self._lead()
        return False

    def _lead(self) -> None:
        """The black before the pictures."""
        if self._restarted_ns is None:
            if self._since_s(self._plated_ns) >= LEAD_S:
                self.room.display.restart()
                self._restarted_ns, self._arrived = self.room.display.now_ns(), False
            return
        late_s = self._since_s(self._restarted_ns) - self._under_way_s
        self.pictures = self._arrived and late_s >= 0
        if not self._arrived and late_s >= PATIENCE_S:
            raise InputError(
                f"{self.step.key}: no frame came within {PATIENCE_S:g} s: see what loss and bandwidth let through"
            )

    def went(self, why: str) -> None:
        """It is shown again, from its start: what was rated must have been seen undisturbed."""
        super().went(why)
        self.intent = LOST

    def told(self) -> dict[str, object]:
        """As StepWatch.told. How many pictures a second there are is told; how old they are would tell the condition."""
        status, room = self._log.status, self.room
        condition = self._show.condition.name if room.tells_condition else ""
        left = self._show.seconds - self.seen_s
        return {
            "phase": self.phase,
            "left_s": left,
            "rate_hz": status.rate_hz,
            "missed": status.missed,
            "condition": condition,
        }
