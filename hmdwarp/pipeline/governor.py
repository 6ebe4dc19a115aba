"""Governor: keep a run within its budget by moving between quality levels on measured times.

Pure: it reads neither clock nor GPU. Time counts in refreshes.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Mapping, Sequence
from statistics import median

import attrs

from ..base import HmdwarpError
from ..client import Compensator, EyeResult, PassInputs, Plan, Stages
from ..client.carry import PictureOf
from ..gpu import Canvas
from .levels import QualityLevel, best_within

# Evidence against a level is the share by which its time exceeds the budget, summed while the sum
# is above 0 (CUSUM). One refresh adds a quarter at most, so that a spike alone is no evidence: 4
# refreshes far over the budget are, or 10 that are 10 % over.
CLIP = 0.25
ENOUGH = 1.0
# Move up only into 95 % of the budget. From there, uniform noise of 10 % reaches the threshold with
# probability exp(-2 m h / s^2) = exp(-30), with m = 0.05, h = 1, s^2 = 0.1^2 / 3 (Siegmund 1985,
# random walk with drift).
MARGIN = 0.95
WINDOW = 31  # refreshes of the running median
PATIENCE = 60  # refreshes of headroom before a move up
TRIAL = 240  # a move up has failed if the level drops again within so many refreshes
# Both grow by this factor with each failure: attempts at 60, 240, 960, 3840 refreshes, six in an
# hour at 60 Hz.
BACK_OFF = 4
SETTLING = 2  # refreshes to ignore after a switch, which disturbs their times


@attrs.frozen
class Change:
    """A switch from one level to another."""

    refresh: int  # the refresh after which it was decided, counted from 0
    before: QualityLevel
    after: QualityLevel
    reason: str  # the reason, in words with figures


@attrs.define(eq=False)
class _Stay:
    """Evidence since the last switch."""

    room: list[int]  # for how many refreshes each level has had headroom
    arrived: int = 0  # first refresh at the level
    climbed: bool = False
    window: deque[float] = attrs.field(factory=lambda: deque(maxlen=WINDOW))
    evidence: float = 0.0
    # Times of the refreshes that the evidence comes from.
    against: deque[float] = attrs.field(factory=lambda: deque(maxlen=WINDOW // 2))


class Governor:
    """Choose the level to run from the levels, the budget and the time of each refresh.

    levels: from the cheapest to the most accurate, as levels_from returns them. budget_ms: per eye.
    It starts at the most accurate level within the budget. `level` is the one to run now; pass
    measured() its time, the worse eye of each refresh.

    Down: as soon as there is enough evidence that the time exceeds the budget, to the most accurate
    level that is expected to fit. Up: when a better level has been expected within 95 % of the
    budget for a while; each failed attempt makes that wait four times as long. The time expected of
    a level is that of the current one, times the ratio of the two by the benchmark.
    Source: evidence by cumulative sums: Page, E. S. (1954), Continuous inspection schemes,
    Biometrika 41, eq. 1.
    Errors: InputError for a budget in which no level fits; HmdwarpError for empty or unsorted
    levels.
    """

    def __init__(self, levels: tuple[QualityLevel, ...], budget_ms: float) -> None:
        pairs = list(itertools.pairwise(levels))
        ordered = all(a.total_ms < b.total_ms and a.error > b.error for a, b in pairs)
        if not levels or not 0 < levels[0].total_ms < math.inf or not ordered:
            raise HmdwarpError(
                f"expected levels that each take longer and err less than the one before, not {list(map(str, levels))}"
            )
        self.levels, self.budget_ms = tuple(levels), float(budget_ms)
        self._at = best_within(self.levels, budget_ms)
        self._refresh = -1
        self._failures = [0] * len(self.levels)
        self._stay = _Stay([0] * len(self.levels))

    @property
    def level(self) -> QualityLevel:
        """The level to run at the next refresh."""
        return self.levels[self._at]

    def measured(self, total_ms: float) -> Change | None:
        """Count the time of the refresh just shown; return the switch to make next, if any."""
        if not (math.isfinite(total_ms) and total_ms >= 0):
            raise HmdwarpError(f"a refresh took {total_ms} ms: expected a finite time from 0")
        stay = self._stay
        self._refresh += 1
        if self._refresh - stay.arrived < SETTLING:
            return None
        stay.window.append(total_ms)
        over = min(max(total_ms / self.budget_ms - 1, -CLIP), CLIP)
        stay.evidence = min(max(0.0, stay.evidence + over), ENOUGH)
        if stay.evidence == 0:
            stay.against.clear()
        else:
            stay.against.append(total_ms)
        if stay.evidence >= ENOUGH and self._at > 0:
            return self._down(median(stay.against))
        return self._up(median(stay.window)) if len(stay.window) == WINDOW else None

    def _down(self, time_ms: float) -> Change:
        expected = self._expected(time_ms)
        to = max((k for k in range(self._at) if expected[k] <= self.budget_ms), default=0)
        if self._stay.climbed:
            # A move up that soon led down has failed, of dearer levels too; one that lasted
            # cancels one failure.
            failures = self._failures[self._at]
            if self._refresh - self._stay.arrived >= TRIAL * BACK_OFF**failures:
                self._failures[self._at] = max(0, failures - 1)
            else:
                self._failures[self._at :] = [max(failures + 1, f) for f in self._failures[self._at :]]
        least = ", the least there is" if expected[to] > self.budget_ms else ""
        over = f"{self.level} takes {time_ms:.2f} ms, over the budget of {self.budget_ms:g} ms"
        return self._change(to, f"{over}; {self.levels[to]} is expected to take {expected[to]:.2f} ms{least}")

    def _up(self, time_ms: float) -> Change | None:
        room, expected, ready = self._stay.room, self._expected(time_ms), []
        for k in range(self._at + 1, len(self.levels)):
            room[k] = room[k] + 1 if expected[k] <= MARGIN * self.budget_ms else 0
            if room[k] >= PATIENCE * BACK_OFF ** self._failures[k]:
                ready.append(k)
        if not ready:
            return None
        to = ready[-1]
        reason = (
            f"{self.level} takes {time_ms:.2f} ms, and for {room[to]} refreshes {self.levels[to]} has been expected "
            f"within {MARGIN:.0%} of the budget of {self.budget_ms:g} ms, now to take {expected[to]:.2f} ms"
        )
        return self._change(to, reason)

    def _expected(self, time_ms: float) -> list[float]:
        """Return the time that each level is expected to take now."""
        return [time_ms * level.total_ms / self.level.total_ms for level in self.levels]

    def _change(self, to: int, reason: str) -> Change:
        change = Change(self._refresh, self.level, self.levels[to], reason)
        self._stay = _Stay([0] * len(self.levels), self._refresh + 1, climbed=to > self._at)
        self._at = to
        return change


class AdaptiveCompensator:
    """One compensator for each quality level, of which the governor chooses; as one Compensator.

    Frames carry what any of the levels needs. All levels are compiled and allocated at the start,
    so that a switch costs nothing at the refresh where it happens. Both eyes switch together.
    `changes` lists the switches.
    """

    def __init__(self, governor: Governor, compensators: Mapping[QualityLevel, Compensator]) -> None:
        self._governor, self._compensators = governor, dict(compensators)
        self.changes: list[Change] = []
        self.gpu = self._running.gpu

    @property
    def plan(self) -> Plan:
        """The plan of the next refresh."""
        return self._running.plan

    @property
    def _running(self) -> Compensator:
        return self._compensators[self._governor.level]

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the current level; see Compensator.run."""
        return self._running.run(inputs)

    def carry(self, inputs: PassInputs, picture_of: PictureOf, into: Canvas) -> None:
        """Warp further pictures as the current level does; see Compensator.carry."""
        self._running.carry(inputs, picture_of, into)

    def record_timings(self, stages: Sequence[Stages]) -> None:
        """Pass the stage times of the last refresh to the governor; the slower eye counts."""
        change = self._governor.measured(max(sum(milliseconds for _, milliseconds in eye) for eye in stages))
        if change is not None:
            self.changes.append(change)

    def close(self) -> None:
        """Free every texture and buffer of all levels."""
        for compensator in self._compensators.values():
            compensator.close()
