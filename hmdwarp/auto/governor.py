"""Keeps a run within its time: goes down the ladder of warps when the measured time says so, and up again when there is room.

Pure: it reads no clock and no GPU. Time counts in refreshes.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

import attrs

from ..errors import HmdwarpError
from .levels import QualityLevel, best_within

# Evidence against a rung is what its time exceeds the budget by, as a share, summed while the sum is above 0 (CUSUM). One refresh
# counts for a quarter at most, so that a spike alone is no evidence: 4 refreshes far over the budget are, or 10 that are 10 % over.
CLIP = 0.25
ENOUGH = 1.0
# Up only into 95 % of the budget: from there, evenly spread noise of 10 % gathers enough evidence once in exp(30) times:
# exp(-2 m h / s^2) with m = 0.05 below, h = 1, s^2 = 0.1^2 / 3 (Siegmund 1985, the random walk's chance to ever get there).
MARGIN = 0.95
WINDOW = 31  # refreshes the level is the median of
PATIENCE = 60  # refreshes the room must last before going up
TRIAL = 240  # a way up was a failure if it led down again within so many refreshes
BACK_OFF = (
    4  # both grow by this factor with each failure: tries at 60, 240, 960, 3840 refreshes, six in an hour at 60 Hz
)
DOUBT = 0.85  # what this run has seen of a rung counts against the benchmark if it is this much better: two medians of noise differ by less
SETTLING = 2  # refreshes after a change that tell of the change


@attrs.frozen
class Change:
    """From one rung to another, and why, in words with figures. refresh: after which it was decided, counted from 0."""

    refresh: int
    before: QualityLevel
    after: QualityLevel
    reason: str


class Governor:
    """Which rung to run, from the ladder, the budget and what each refresh took.

    ladder: from cheapest to most accurate, as choice.ladder gives it. budget_ms: per eye. `rung` is the one to run now; tell what
    it took by measured(), the worse eye of each refresh. It starts at the most accurate rung within the budget.

    Down: as soon as there is enough evidence that the time exceeds the budget, to the most accurate rung that is expected to fit.
    Up: when a better rung has been expected within 95 % of the budget for a while; four times as long after each try that failed.
    What is expected of a rung: the time of the present one, times the ratio of the two by the benchmark, or by what this run has
    measured of both. Going down believes the worse of the two, so that it suffices; going up the benchmark, unless what was measured
    is clearly better: one bad moment is not for ever.
    Source: evidence by cumulative sums: Page, E. S. (1954), Continuous inspection schemes, Biometrika 41, eq. 1.
    Errors: InputError for a budget in which no rung fits; HmdwarpError for an empty or unsorted ladder.
    """

    def __init__(self, ladder: tuple[QualityLevel, ...], budget_ms: float) -> None:
        _check_ladder(ladder)
        self.ladder, self.budget_ms = tuple(ladder), float(budget_ms)
        self._at = best_within(self.ladder, budget_ms)
        self._refresh = -1
        self._own = {self._at: self.level.total_ms}  # the rungs this run has seen, up to one common factor
        self._failures = [0] * len(self.ladder)
        self._came: tuple[int, float] | None = (
            None  # from which rung, and its level when it was left; None once that is learnt
        )
        self._arrived, self._climbed = 0, False
        self._start_counting()

    def _start_counting(self) -> None:
        self._window: deque[float] = deque(maxlen=WINDOW)
        self._evidence = 0.0
        self._against: deque[float] = deque(maxlen=WINDOW // 2)  # the refreshes the evidence comes from
        self._room = [0] * len(self.ladder)

    @property
    def level(self) -> QualityLevel:
        """The one to run at the next refresh."""
        return self.ladder[self._at]

    def measured(self, total_ms: float) -> Change | None:
        """What the refresh just shown took with `rung`; the change for the next one, if there is one."""
        if not (math.isfinite(total_ms) and total_ms >= 0):
            raise HmdwarpError(f"a refresh took {total_ms} ms: wanted a finite time from 0")
        self._refresh += 1
        if self._refresh - self._arrived < SETTLING:
            return None
        self._window.append(total_ms)
        self._weigh(total_ms)
        if self._evidence >= ENOUGH and self._at > 0:
            return self._down()
        if len(self._window) == WINDOW:
            self._learn(median(self._window))
            return self._up(median(self._window))
        return None

    def _weigh(self, total_ms: float) -> None:
        over = min(max(total_ms / self.budget_ms - 1, -CLIP), CLIP)
        self._evidence = min(max(0.0, self._evidence + over), ENOUGH)
        if self._evidence == 0:
            self._against.clear()
        else:
            self._against.append(total_ms)

    def _down(self) -> Change:
        level = median(self._against)
        self._learn(level)
        fits = [k for k in range(self._at) if max(self._expected(k, level)) <= self.budget_ms]
        to = fits[-1] if fits else 0
        self._judge_climb()
        expected = max(self._expected(to, level))
        fate = f"{self.ladder[to]} is expected to take {expected:.2f} ms" + ("" if fits else ", the least there is")
        return self._change(
            to, level, f"{self.level} takes {level:.2f} ms, over the budget of {self.budget_ms:g} ms; {fate}"
        )

    def _judge_climb(self) -> None:
        """A way up that leads down again soon has failed, and dearer rungs with it; one that lasted makes up for a failure."""
        if self._climbed:
            failures = self._failures[self._at]
            lasted = self._refresh - self._arrived >= TRIAL * BACK_OFF**failures
            if lasted:
                self._failures[self._at] = max(0, failures - 1)
            else:
                self._failures[self._at :] = [max(failures + 1, f) for f in self._failures[self._at :]]

    def _up(self, level: float) -> Change | None:
        for k in range(self._at + 1, len(self.ladder)):
            self._room[k] = self._room[k] + 1 if self._hoped(k, level) <= MARGIN * self.budget_ms else 0
        ready = [
            k
            for k in range(self._at + 1, len(self.ladder))
            if self._room[k] >= PATIENCE * BACK_OFF ** self._failures[k]
        ]
        if not ready:
            return None
        to = ready[-1]
        reason = (
            f"{self.level} takes {level:.2f} ms, and for {self._room[to]} refreshes {self.ladder[to]} has been expected within "
            f"{MARGIN:.0%} of the budget of {self.budget_ms:g} ms, now to take {self._hoped(to, level):.2f} ms"
        )
        return self._change(to, level, reason)

    def _expected(self, k: int, level: float) -> tuple[float, float]:
        """What rung k would take now: by the benchmark, and by what this run has seen."""
        by_bench = level * self.ladder[k].total_ms / self.ladder[self._at].total_ms
        if not {k, self._at} <= self._own.keys():
            return by_bench, by_bench
        return by_bench, level * self._own[k] / self._own[self._at]

    def _hoped(self, k: int, level: float) -> float:
        by_bench, by_run = self._expected(k, level)
        return by_run if by_run < DOUBT * by_bench else by_bench

    def _learn(self, level: float) -> None:
        """How this rung compares with the one before, once for each stay: the machine was the same a moment ago."""
        if self._came is not None:
            before, its_level = self._came
            if its_level > 0 and level > 0:
                self._own[self._at] = self._own[before] * level / its_level
            self._came = None

    def _change(self, to: int, level: float, reason: str) -> Change:
        change = Change(self._refresh, self.level, self.ladder[to], reason)
        self._came = (self._at, level)
        self._climbed, self._arrived = to > self._at, self._refresh + 1
        self._at = to
        self._start_counting()
        return change


def _check_ladder(levels: tuple[QualityLevel, ...]) -> None:
    times, errors = [r.total_ms for r in levels], [r.error for r in levels]
    dearer = all(0 < a < b for a, b in zip([1e-300, *times], times, strict=False))
    if not levels or not dearer or any(a <= b for a, b in zip(errors, errors[1:], strict=False)):
        raise HmdwarpError(
            f"a ladder wants rungs that each take longer and err less than the one before, not {list(map(str, levels))}"
        )
