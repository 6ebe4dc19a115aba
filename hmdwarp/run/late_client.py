"""The client of a replay that takes its time: a picture that is late is seen later."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import attrs

from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..pipeline.loop import Refresh
from ..pipeline.planning import build_plan_for
from .frame_rows import Row
from .misses import MEASURED, STANDS, TURNED, Misses, miss_figures
from .replay_setup import ReplaySetup
from .seen_offset import SeenOffset
from .truth import is_measured

MISS_COLUMNS = ("frame", "time_s", "stale", "off_deg", "took_ms")


@attrs.frozen
class _Work:
    """A picture in the making."""

    # The refresh it is made for, and the one that first shows it.
    instant_ns: int
    seen: int
    took_ms: float


@attrs.frozen(eq=False)
class Seen:
    """What a refresh showed."""

    refresh: Refresh
    # Whether its picture was seen before.
    stale: bool
    # From when to when the client worked on it, in ns; None for a stale one.
    work_ns: tuple[int, int] | None


class LateClient:
    """Show what the client has finished by each refresh.

    The first picture is there in time. Without misses every refresh is that of the loop, bit for
    bit. The loop makes a picture when it is first seen, for the refresh it was to be made for, so
    that the one before stands until then.
    """

    def __init__(self, setup: ReplaySetup, misses: Misses) -> None:
        self._setup, self._misses = setup, misses
        self._period_ms = 1e3 / setup.schedule.rate_hz
        self._turner = _turner(setup) if misses.turns else None
        self._offset = SeenOffset(turned=misses.turns)
        self._work: _Work | None = None
        self._made: Refresh | None = None
        self._took_ms = 0.0
        # (frame, time_s, stale, off_deg, took_ms) of each refresh.
        self._rows: list[tuple[int, float, bool, float, float | None]] = []

    def at(self, number: int, instant_ns: int) -> Seen | None:
        """Return what refresh `number` shows, None before the first frame has arrived."""
        if self._work is None:
            self._begin(number, instant_ns)
        work, made = self._work, self._made
        assert work is not None
        stale = work.seen > number
        if not stale:
            self._work = None
            made = self._made = self._setup.loop.show(work.instant_ns)
            self._took_ms = work.took_ms
        if made is None:
            return None
        refresh = made if made.shown_ns == instant_ns else self._again(made, instant_ns, stale=stale)
        self._add(refresh, made, None if stale else work.took_ms)
        begun_ns = work.instant_ns - round(self._period_ms * 1e6)
        return Seen(refresh, stale, None if stale else (begun_ns, begun_ns + round(work.took_ms * 1e6)))

    def _begin(self, number: int, instant_ns: int) -> None:
        made, loop = self._made, self._setup.loop
        if made is None or not self._misses.times_ms:
            loop.settle()
        else:
            loop.settle(((("warp", self._took_ms / len(made.eyes)),),) * len(made.eyes))
        took_ms = self._next_ms(number)
        late = self._misses.refreshes(took_ms, self._period_ms) - 1 if made is not None else 0
        self._work = _Work(instant_ns, number + late, took_ms)

    def _next_ms(self, number: int) -> float:
        """Return how long the client takes for the picture that it begins now."""
        given, auto = self._misses.times_ms, self._setup.auto
        if not given:
            return sum(ms for stages in self._made.stage_ms for _, ms in stages) if self._made is not None else 0.0
        return given[number % len(given)] * (auto.share_of_first if auto is not None else 1.0)

    def _again(self, made: Refresh, instant_ns: int, *, stale: bool) -> Refresh:
        refresh = self._setup.loop.again(made, instant_ns)
        if self._turner is not None:
            turned = tuple(self._turned(self._turner, *pair) for pair in zip(made.eyes, refresh.inputs, strict=True))
            self._setup.gpu.timer.collect()
            refresh = attrs.evolve(refresh, eyes=turned)
        return refresh if stale else attrs.evolve(refresh, laps=made.laps)

    def _turned(self, turner: Compensator, made: EyeResult, inputs: PassInputs) -> EyeResult:
        assert made.shown is not None  # options refuse a warp that is fused with the lens
        picture = attrs.evolve(inputs.rendered, view=made.view, colour=made.shown.texture, carried={})
        return turner.run(PassInputs(picture, inputs.shown, inputs.eye, shown_ns=inputs.shown_ns))

    def _add(self, refresh: Refresh, made: Refresh, took_ms: float | None) -> None:
        off = self._offset.off_deg(made, refresh)
        time_s = (refresh.shown_ns - self._setup.track.start_ns) * 1e-9
        self._rows.append((len(self._rows), time_s, took_ms is None, off, took_ms))

    def rows(self) -> Iterator[Row]:
        """Yield the rows of misses.csv, one for each refresh."""
        for row in self._rows:
            yield {**dict(zip(MISS_COLUMNS, row, strict=True)), "stale": int(row[2])}

    def entry(self) -> dict[str, Any]:
        """Return the `miss` of summary.json."""
        stale = [row[2] for row in self._rows]
        every = self._setup.options.metrics_every
        measured = [row[2] for row in self._rows if is_measured(row[0], every)]
        return {
            "budget_ms": self._misses.budget_ms or self._period_ms,
            "times": "given" if self._misses.times_ms else MEASURED,
            "show": TURNED if self._misses.turns else STANDS,
            **miss_figures(stale, [row[3] for row in self._rows]),
            "stale_share_measured": sum(measured) / len(measured),
        }


def _turner(setup: ReplaySetup) -> Compensator:
    """Return what turns a finished picture, before the lens."""
    turning = attrs.evolve(setup.options.with_pair("rotation", "none"), effects="none", strategy="", client="")
    return setup.pipeline.compensator_of_shown(build_plan_for(turning, setup.headset, None))
