"""Refresh times of a replay's display."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import attrs

from ..errors import InputError
from ..pipeline.sizes import latency_ns, refreshes_of
from ..pipeline.source import Source
from ..poses import LoadedTrace, PoseTrack
from .options import RunOptions

_DAY_S = 86_400.0


@attrs.frozen
class Schedule:
    """Refreshes of a display in integer nanoseconds on the trace's clock, mostly evenly spaced."""

    # Time of the first shown refresh.
    first_ns: int
    rate_hz: float
    # Number of shown refreshes.
    count: int
    # Number of refreshes between drawing a frame and showing it.
    age: int
    # Number of refreshes before that until a proxy has something to draw it from.
    ahead: int = 0
    # Of refreshes that are not evenly spaced, those that only draw included; None for even ones.
    instants_ns: tuple[int, ...] | None = None

    @property
    def age_ns(self) -> int:
        """Time from drawing to showing, within 1 ns."""
        return round(self.age * 1e9 / self.rate_hz)

    def link_latency_ns(self, options: RunOptions) -> int:
        """Delay of the link.

        At most the time between any two refreshes `age` apart, which are rounded to whole ns.
        """
        return (
            min(latency_ns(options), max(0, self.age_ns - 2)) if options.client_link.is_plain else latency_ns(options)
        )

    def numbered(self) -> Iterator[tuple[int, int]]:
        """Yield (number, time_ns) of every refresh.

        Those with a negative number only draw, so that a frame has arrived by the first shown one.
        """
        if self.instants_ns is not None:
            yield from enumerate(self.instants_ns, -self.age)
            return
        for number in range(-self.age - self.ahead, self.count):
            yield number, self.first_ns + round(number * 1e9 / self.rate_hz)


def schedule_for(options: RunOptions, source: Source, trace: LoadedTrace, rate_hz: float) -> Schedule:
    """Return the refreshes of a run: evenly spaced, or at the instants of recorded frames.

    Errors: InputError if the run would show nothing.
    """
    if source.instants_ns and not options.trace and options.rate_hz is None:
        return _at_instants(source.instants_ns, source.headset.refresh_hz, str(trace.path), options)
    return schedule_of(trace.track, options, rate_hz)


def _at_instants(times: Sequence[int], rate_hz: float, place: str, options: RunOptions) -> Schedule:
    """Return refreshes at the instants of the frames, where the truth is what was recorded.

    The first is at the requested start, or when the first frame can have arrived.
    """
    if len(times) < 2:
        raise InputError(f"{place}: one frame; expected two or more: one that is late, and what is seen then")
    age, _ = _refreshes_before(options, rate_hz)
    first = next((i for i, at in enumerate(times) if i >= age and at >= options.start_s * 1e9), len(times))
    if first == len(times):
        raise InputError(
            f"{place}: its {len(times)} frames last {times[-1] * 1e-9:.3f} s: with --latency {options.latency_ms:g} ms "
            f"and --start {options.start_s:g} s none is left to show; use a shorter latency, an earlier start, or say "
            "how fast they were taken by --frames-rate"
        )
    seconds = math.inf if options.seconds is None else options.seconds
    end = next((i for i, at in enumerate(times) if at >= times[first] + seconds * 1e9), len(times))
    instants = tuple(times[first - age : max(end, first + 1)])
    return Schedule(times[first], rate_hz, max(1, end - first), age, instants_ns=instants)


def schedule_of(track: PoseTrack, options: RunOptions, rate_hz: float) -> Schedule:
    """Return the refreshes of a run.

    The first is at the requested start, or when the first frame can have arrived if that is later.
    There are as many as fit into the requested seconds and into the trace, at least one.
    Errors: InputError if the run would show nothing of the trace.
    """
    length_s = track.duration_ns * 1e-9
    if length_s == 0:
        raise InputError(f"the trace '{track.name}' has a single sample: expected head motion over time")
    if options.start_s >= length_s:
        raise InputError(
            f"--start {options.start_s:g} s: the trace '{track.name}' is {length_s:.3f} s long; start before its end"
        )
    age, ahead = _refreshes_before(options, rate_hz)
    first = (age + ahead) / rate_hz
    if first > length_s:
        raise InputError(
            f"--latency {options.total_latency_ms:g} ms is longer than the trace '{track.name}' ({length_s:.3f} s): no "
            "frame would arrive; use a shorter latency or a longer trace"
        )
    start_s = max(options.start_s, first)
    seconds = length_s - start_s if options.seconds is None else min(options.seconds, length_s - start_s)
    if options.seconds is None and seconds > _DAY_S and rate_hz > 1:
        raise InputError(
            f"the trace '{track.name}' has {seconds / _DAY_S:.1f} days to show, {math.floor(seconds * rate_hz)} "
            "refreshes: expected at most one day unless stated; say how much of it by --seconds"
        )
    # Within 1e-6 of a refresh: 1 s at 90 Hz is 90 refreshes despite rounding.
    count = max(1, math.floor(seconds * rate_hz + 1e-6))
    return Schedule(track.start_ns + round(start_s * 1e9), rate_hz, count, age, ahead)


def first_shown_s(options: RunOptions, rate_hz: float) -> float:
    """Return the seconds into a trace after which the first frame has arrived for certain."""
    return sum(_refreshes_before(options, rate_hz)) / rate_hz


def _refreshes_before(options: RunOptions, rate_hz: float) -> tuple[int, int]:
    """Return how many refreshes a frame is under way to the client, and to a proxy before that."""
    options.client_link.check(latency_ns(options))
    link_ms = options.client_link.longest_ns(latency_ns(options)) / 1e6
    return refreshes_of(link_ms, rate_hz), refreshes_of(options.proxy.longest_ms(options.network), rate_hz)
