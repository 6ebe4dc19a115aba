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
# Offsets are fitted with a drift over this time, below it they are taken as equal.
_FIT_NS = 2_000_000_000


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
        jumped = bool(self._kept) and self._contradicts(one)
        if jumped:
            self._kept.clear()
            self.jumps += 1
        self._kept.append(one)
        return jumped

    def _contradicts(self, one: Exchange) -> bool:
        """Return whether no drift within reason makes it agree with the last one."""
        last = self._kept[-1]
        apart = abs(one.offset_ns - last.offset_ns)
        drifted = MOST_DRIFT * abs(one.middle_ns - last.middle_ns)
        return apart > (one.round_trip_ns + last.round_trip_ns) / 2 + drifted + 1

    @property
    def is_known(self) -> bool:
        """Whether there was an exchange."""
        return bool(self._kept)

    @property
    def round_trip_ns(self) -> int:
        """The shortest of those kept; half of it bounds the error of the offset."""
        return min(exchange.round_trip_ns for exchange in self._kept)

    @property
    def drift(self) -> float:
        """Seconds that their clock gains in one of ours; 0 until it is known."""
        return self._line()[2]

    def offset_at(self, time_ns: float) -> float:
        """Return their clock less this one, in ns, at an instant of this one."""
        middle, offset, drift = self._line()
        return offset + drift * (time_ns - middle)

    def _line(self) -> tuple[float, float, float]:
        """Return the middle of the best exchanges, the offset there, and the drift."""
        best = sorted(self._kept, key=lambda one: one.round_trip_ns)[: max(1, len(self._kept) // 4)]
        times, offsets = [exchange.middle_ns for exchange in best], [exchange.offset_ns for exchange in best]
        middle, offset = sum(times) / len(times), sum(offsets) / len(offsets)
        if max(times) - min(times) < _FIT_NS:
            return middle, offset, 0.0
        spread = sum((time - middle) ** 2 for time in times)
        slope = sum((time - middle) * (one - offset) for time, one in zip(times, offsets, strict=True)) / spread
        return middle, offset, max(-MOST_DRIFT, min(MOST_DRIFT, slope))

    def summary(self) -> dict[str, float | int]:
        """Return what summary.json has of the clocks."""
        if not self._kept:
            return {"jumps": self.jumps}
        return {
            "offset_ms": self.offset_at(self._kept[-1].heard_ns) / 1e6,
            "drift_ppm": self.drift * 1e6,
            "shortest_round_trip_ms": self.round_trip_ns / 1e6,
            "jumps": self.jumps,
        }
