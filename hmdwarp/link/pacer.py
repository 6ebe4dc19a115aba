"""The instants at which the server draws, at its own rate."""

from __future__ import annotations

import math

# Two instants this close are one: replays round theirs to whole nanoseconds.
_SAME_INSTANT_NS = 1000
# A display's rate within this of a multiple of the server's is that multiple.
_SAME_RATE = 1e-3


class Pacer:
    """Say when the server draws: at every n-th refresh if the display's rate is n times its own.

    Otherwise freely, by a clock of its own that starts at the first refresh: between refreshes, and
    several times in one where the server is the faster of the two.

    server_hz: None for the display's rate, which is every refresh.
    """

    def __init__(self, server_hz: float | None, display_hz: float) -> None:
        ratio = display_hz / (server_hz or display_hz)
        self._every = round(ratio) if abs(ratio - round(ratio)) <= _SAME_RATE * ratio and ratio > 0.5 else None
        self._hz = server_hz or display_hz
        # After a stall older instants are passed over, so that the server does not draw them all.
        self._most = math.ceil(self._hz / display_hz) + 1
        self._refreshes = 0
        self._first_ns: int | None = None
        self._drawn = 0

    def due(self, now_ns: int) -> list[int]:
        """Return the instants since the last call, oldest first; call it once a refresh."""
        self._refreshes += 1
        if self._every is not None:
            return [now_ns] if (self._refreshes - 1) % self._every == 0 else []
        if self._first_ns is None:
            self._first_ns = now_ns
        count = math.floor((now_ns - self._first_ns + _SAME_INSTANT_NS) * 1e-9 * self._hz) + 1
        first, self._drawn = max(self._drawn, count - self._most), max(self._drawn, count)
        return [min(now_ns, self._first_ns + round(number * 1e9 / self._hz)) for number in range(first, count)]
