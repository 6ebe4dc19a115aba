"""A bottleneck: frames pass one after the other, each for as long as its size takes."""

from __future__ import annotations

import math

import attrs

from ..errors import InputError

# A common buffer size of routers; without a limit, delay and memory would grow for ever.
QUEUE_MS = 250.0


@attrs.frozen
class Bandwidth:
    """The limits of the bottleneck. Errors: InputError for a number out of range.

    A frame that meets a free bottleneck is never dropped, whatever its size.
    """

    # Rate in Mbit/s (1e6 bits).
    mbit: float
    # A frame that would wait longer than this before its first bit leaves is dropped.
    queue_ms: float = QUEUE_MS

    def __attrs_post_init__(self) -> None:
        if not (math.isfinite(self.mbit) and 1e-3 <= self.mbit <= 1e6):
            raise InputError(
                f"--bandwidth {self.mbit:g} Mbit/s: expected 0.001 to 1000000; leave it out for a link without a limit"
            )
        if not 0 <= self.queue_ms <= 60_000:
            raise InputError(f"--queue {self.queue_ms:g} ms: expected the longest wait of a frame, 0 to 60000 ms")

    @property
    def queue_ns(self) -> int:
        """The longest wait in ns."""
        return round(self.queue_ms * 1e6)

    def transfer_ns(self, size_bytes: int) -> int:
        """Return the time from the first bit to the last."""
        return round(size_bytes * 8e3 / self.mbit)


class Bottleneck:
    """The queue before the limit."""

    def __init__(self, bandwidth: Bandwidth) -> None:
        self.bandwidth = bandwidth
        self._free_ns: int | None = None

    def enter(self, now_ns: int, size_bytes: int) -> tuple[int, int, bool]:
        """Return (queue_ns, transfer_ns, taken) of a frame that arrives now.

        Frames arrive in order of time; a refused one changes nothing.
        """
        wait = 0 if self._free_ns is None else max(0, self._free_ns - now_ns)
        if wait > self.bandwidth.queue_ns:
            return wait, 0, False
        transfer = self.bandwidth.transfer_ns(size_bytes)
        self._free_ns = now_ns + wait + transfer
        return wait, transfer, True


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
