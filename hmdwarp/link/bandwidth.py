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
            raise InputError(
                f"--bandwidth queue={self.queue_ms:g} ms: expected the longest wait before it, 0 to 60000 ms"
            )

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
