"""A bottleneck: frames go through it one after the other, each for as long as its size takes."""

from __future__ import annotations

import math

import attrs

from ..errors import InputError

QUEUE_MS = (
    250.0  # what routers are commonly built to hold; a queue without an end would delay, and hold in memory, ever more
)


@attrs.frozen
class Bandwidth:
    """mbit: rate in Mbit/s (1e6 bits). queue_ms: a frame that would wait longer than this before its first bit goes is dropped.

    A frame that finds the bottleneck free is never dropped, however large it is. Errors: InputError.
    """

    mbit: float
    queue_ms: float = QUEUE_MS

    def __attrs_post_init__(self) -> None:
        if not (math.isfinite(self.mbit) and 1e-3 <= self.mbit <= 1e6):
            raise InputError(
                f"bandwidth {self.mbit:g} Mbit/s: wanted 0.001 to 1000000; leave it out for a link without a limit"
            )
        if not 0 <= self.queue_ms <= 60_000:
            raise InputError(f"queue {self.queue_ms:g} ms: wanted the longest wait at the bottleneck, 0 to 60000 ms")

    @property
    def queue_ns(self) -> int:
        return round(self.queue_ms * 1e6)

    def transfer_ns(self, size_bytes: int) -> int:
        """From the first bit to the last."""
        return round(size_bytes * 8e3 / self.mbit)


class Bottleneck:
    """Where frames queue: `enter` says how long one waits and is transferred."""

    def __init__(self, bandwidth: Bandwidth) -> None:
        self.bandwidth = bandwidth
        self._free_ns: int | None = None

    def enter(self, now_ns: int, size_bytes: int) -> tuple[int, int, bool]:
        """(queue_ns, transfer_ns, taken) of a frame that comes now, not before the last one; a refused one changes nothing."""
        wait = 0 if self._free_ns is None else max(0, self._free_ns - now_ns)
        if wait > self.bandwidth.queue_ns:
            return wait, 0, False
        transfer = self.bandwidth.transfer_ns(size_bytes)
        self._free_ns = now_ns + wait + transfer
        return wait, transfer, True
