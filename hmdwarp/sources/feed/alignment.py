"""Two clocks that tick apart: the offset of the server's from the client's, and its drift.

Source: Mills 2010, RFC 5905 (NTP), section 8, for the offset of one exchange; the samples of the
shortest round trips bound it best (Mills 1995, clock filter).
"""

from __future__ import annotations

from collections import deque

import attrs

KEPT = 256
# A quartz is within this; what lies further apart is a clock that was set, or another machine's.
MOST_DRIFT = 500e-6


@attrs.frozen
class Exchange:
    """One request and its answer, by both clocks: ours at its ends, theirs between."""

    sent_ns: int
    received_ns: int
    answered_ns: int
    heard_ns: int

    @property
    def round_trip_ns(self) -> int:
        """Time on the way, both ways, without what the other end took."""
        return (self.heard_ns - self.sent_ns) - (self.answered_ns - self.received_ns)

    @property
    def offset_ns(self) -> float:
        """Their clock less this one, within half the round trip."""
        return ((self.received_ns - self.sent_ns) + (self.answered_ns - self.heard_ns)) / 2

    @property
    def middle_ns(self) -> float:
        """The instant of the offset, on this clock."""
        return (self.sent_ns + self.heard_ns) / 2


class Alignment:
    """Offset and drift between two clocks, from the exchanges so far.

    jumps: how often the other clock was found to have been set; each starts anew.
    """

    def __init__(self) -> None:
        self._kept: deque[Exchange] = deque(maxlen=KEPT)
        self.jumps = 0

    def add(self, one: Exchange) -> bool:
        """Take an exchange; return whether the other clock has jumped.

        One that cannot be (answered before it was received or sent) is left out.
        """
        if one.round_trip_ns < 0 or one.answered_ns < one.received_ns:
            return False
        last = self._kept[-1] if self._kept else one
        # No drift within reason makes it agree with the last one.
        drifted = MOST_DRIFT * abs(one.middle_ns - last.middle_ns)
        within_ns = (one.round_trip_ns + last.round_trip_ns) / 2 + drifted + 1
        if jumped := abs(one.offset_ns - last.offset_ns) > within_ns:
            self._kept.clear()
            self.jumps += 1
        self._kept.append(one)
        return jumped

    @property
    def is_known(self) -> bool:
        """Whether there was an exchange."""
        return bool(self._kept)

    @property
    def _by_round_trip(self) -> list[Exchange]:
        return sorted(self._kept, key=lambda one: one.round_trip_ns)

    @property
    def round_trip_ns(self) -> int:
        """The shortest of those kept."""
        return self._by_round_trip[0].round_trip_ns

    @property
    def offset_ns(self) -> float:
        """Their clock less this one at the shortest round trip, within half of it."""
        return self._by_round_trip[0].offset_ns

    @property
    def drift(self) -> float | None:
        """Seconds that their clock gains in one of ours, by a line through the best exchanges.

        None where their round trips could feign as much as a quartz drifts, and beyond that.
        """
        best = self._by_round_trip[: max(1, len(self._kept) // 4)]
        times, offsets = [exchange.middle_ns for exchange in best], [exchange.offset_ns for exchange in best]
        if best[-1].round_trip_ns >= MOST_DRIFT * (max(times) - min(times)):
            return None
        middle, offset = sum(times) / len(times), sum(offsets) / len(offsets)
        spread = sum((time - middle) ** 2 for time in times)
        slope = sum((time - middle) * (one - offset) for time, one in zip(times, offsets, strict=True)) / spread
        return slope if abs(slope) <= MOST_DRIFT else None

    def summary(self) -> dict[str, float | int | None]:
        """Return what summary.json has of the clocks; a drift of None is not known."""
        if not self._kept:
            return {"jumps": self.jumps}
        return {
            "offset_ms": self.offset_ns / 1e6,
            "drift_ppm": None if self.drift is None else self.drift * 1e6,
            "shortest_round_trip_ms": self.round_trip_ns / 1e6,
            "jumps": self.jumps,
        }
