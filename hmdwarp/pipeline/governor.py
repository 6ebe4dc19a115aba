"""Quality levels, and the governor that keeps a run within its budget by moving between them.

Levels are the Pareto-optimal combinations of warp and fill in a benchmark. The governor is pure: it
reads neither clock nor GPU, and time counts in refreshes.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

import attrs

from .. import client, report
from ..base import NO_NUMBERS, HmdwarpError, InputError, in_brief
from ..base.documents import json_in
from ..base.named_files import RESULTS

# The keys that two rows must share for their figures to be comparable.
_CASE = (
    *("trace", "scene", "latency_ms", "lens", "headset", "size"),
    *("rate_hz", "server_rate_hz", "guard", "predict", "frames"),
)
Row = Mapping[str, Any]


@attrs.frozen
class QualityLevel:
    """One Pareto-optimal combination: nothing as cheap is more accurate."""

    # A registered name with its settings, as --warp takes it.
    warp: str
    fill: str
    total_ms: float  # per eye
    # Mean FLIP; 0 is perfect.
    error: float
    psnr_db: float | None = None

    def __str__(self) -> str:
        return self.warp if self.fill == "none" else f"{self.warp} + {self.fill}"

    def scaled(self, factor: float) -> QualityLevel:
        """Return the level on a machine, or at a size, that takes `factor` times as long."""
        return attrs.evolve(self, total_ms=self.total_ms * factor)


def levels_from(rows: Iterable[Row]) -> tuple[QualityLevel, ...]:
    """Return the Pareto front of error against time, from the cheapest level to the most accurate.

    Each is slower and better than the last. rows: as in bench.json. Figures are means over the
    cases (trace, scene, latency, ..) that every combination was measured in; of several sizes the
    largest counts, where time is scarcest; of several machines the one with the most rows. Rows
    without a time or a FLIP are ignored.
    Errors: InputError if no combination was measured, or no case is common to all.
    """
    timed = [row for row in rows if (row["time_ms"]["total"]["median"] or 0) > 0]
    timed = [row for row in timed if row["quality"]["flip"]["mean"] is not None]
    if not timed:
        raise InputError("no combination was measured with a time and a FLIP: run the benchmark with both")
    most = max(math.prod(row["size"]) for row in timed)
    # Times of two machines are not comparable.
    places = [(math.prod(row["size"]), (row.get("machine") or {}).get("host")) for row in timed]
    chosen = Counter(place for place in places if place[0] == most).most_common(1)[0][0]
    combined: dict[tuple[str, str], dict[tuple[Any, ...], list[Any]]] = defaultdict(lambda: defaultdict(list))
    for row, place in zip(timed, places, strict=True):
        if place == chosen:
            case = tuple(tuple(value) if isinstance(value := row.get(key), list) else value for key in _CASE)
            quality = row["quality"]
            figures = row["time_ms"]["total"]["median"], quality["flip"]["mean"], quality["psnr_db"]["mean"]
            combined[row["warp"], row["fill"]][case].append(figures)
    shared = set.intersection(*(set(cases) for cases in combined.values()))
    if not shared:
        how = "measure all of them with the same traces, scenes and latencies"
        raise InputError(f"{len(combined)} combinations of warp and fill were measured in no common case: {how}")
    levels = []  # fmean: no mean depends on the order of the rows
    for (warp, fill), cases in combined.items():
        times, errors, psnr = zip(*(figures for case in shared for figures in cases[case]), strict=True)
        levels.append(QualityLevel(warp, fill, fmean(times), fmean(errors), None if None in psnr else fmean(psnr)))
    return front(levels)


def best_within(levels: tuple[QualityLevel, ...], budget_ms: float | None, name: str = "--budget") -> int:
    """Return the index of the most accurate level within the budget.

    name: of the budget, in errors. Errors: InputError with the cheapest time if none fits.
    """
    budget_ms = check_budget(budget_ms, name)
    fitting = [number for number, level in enumerate(levels) if level.total_ms <= budget_ms]
    if not fitting:
        raise InputError(
            f"{name} {budget_ms:g} ms: nothing is that fast here; the cheapest, {levels[0]}, takes "
            f"{levels[0].total_ms:.2f} ms per eye: allow that much, or use a smaller size"
        )
    return fitting[-1]


def check_budget(budget_ms: float | None, name: str) -> float:
    """Return the budget. Errors: InputError for one that is no time above 0."""
    try:
        found = float(budget_ms or 0)
    except NO_NUMBERS:
        found = math.nan
    if budget_ms is None or not 0 < found < math.inf:
        said = in_brief(budget_ms) if math.isnan(found) else f"{found:g}"
        raise InputError(f"{name} {said} ms: expected a time above 0 ms for one eye")
    return budget_ms


def front(levels: list[QualityLevel]) -> tuple[QualityLevel, ...]:
    """Return those that nothing as cheap is more accurate than, from the cheapest on."""
    found: list[QualityLevel] = []
    for level in sorted(levels, key=lambda one: (one.total_ms, one.error, one.warp, one.fill)):
        if not found or level.error < found[-1].error:
            found.append(level)
    return tuple(found)


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a bench.json, less those of strategies.

    Errors: InputError naming the file and its fault.
    """
    bench = json_in(path, attrs.evolve(RESULTS, what="the bench.json that hmdwarp bench wrote"))
    if not isinstance(bench, dict) or not isinstance(bench.get("rows"), list):
        raise InputError(f"{path}: it has no list of 'rows'; expected the bench.json that hmdwarp bench wrote")
    if bench.get("schema") != report.SCHEMA:
        found = f"its schema is {bench.get('schema')!r}, this program reads {report.SCHEMA}"
        raise InputError(f"{path}: {found}: run hmdwarp bench again")
    for number, row in enumerate(bench["rows"]):
        faults = report.summary_faults(row)
        if faults:
            raise InputError(f"{path}: row {number}: {'; '.join(faults)}")
    return [row for row in bench["rows"] if not row.get("strategy")]


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
        is_over = stay.evidence >= ENOUGH and self._at > 0
        if not is_over and len(stay.window) < WINDOW:
            return None
        time_ms = median(stay.against if is_over else stay.window)
        # The time that each level is expected to take now.
        expected = [time_ms * level.total_ms / self.level.total_ms for level in self.levels]
        return self._down(time_ms, expected) if is_over else self._up(time_ms, expected)

    def _down(self, time_ms: float, expected: list[float]) -> Change:
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

    def _up(self, time_ms: float, expected: list[float]) -> Change | None:
        room, ready = self._stay.room, []
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

    def __init__(self, governor: Governor, compensators: Mapping[QualityLevel, client.Compensator]) -> None:
        self._governor, self._compensators = governor, dict(compensators)
        self.changes: list[Change] = []
        self.gpu = self._running.gpu

    @property
    def plan(self) -> client.Plan:
        """The plan of the next refresh."""
        return self._running.plan

    @property
    def _running(self) -> client.Compensator:
        return self._compensators[self._governor.level]

    def run(self, inputs: client.PassInputs) -> client.EyeResult:
        """Run the current level; see Compensator.run."""
        return self._running.run(inputs)

    def record_timings(self, stages: Sequence[client.Stages]) -> None:
        """Pass the stage times of the last refresh to the governor; the slower eye counts."""
        change = self._governor.measured(max(sum(milliseconds for _, milliseconds in eye) for eye in stages))
        if change is not None:
            self.changes.append(change)

    def close(self) -> None:
        """Free every texture and buffer of all levels."""
        for compensator in self._compensators.values():
            compensator.close()
