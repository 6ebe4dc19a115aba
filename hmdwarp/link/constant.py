"""A link that delays every frame by the same time."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from ..errors import InputError

Payload = TypeVar("Payload")


class ConstantLink(Generic[Payload]):
    """Hands out the newest frame that has arrived by now, each arriving `latency_ns` after it was sent.

    Never early, never passes over a due frame, never goes back. It holds the frames under way and the one that is shown, no
    more: each that can no longer be shown is given to `discard` (to be drawn into again).
    Errors: InputError for a negative latency; ValueError for times that run backwards, which is a fault of the caller.
    """

    def __init__(self, latency_ns: int, discard: Callable[[Payload], None] = lambda frame: None) -> None:
        if not 0 <= latency_ns < math.inf:  # NaN too
            raise InputError(f"latency {latency_ns / 1e6:g} ms: wanted 0 or more")
        self.latency_ns, self._discard = latency_ns, discard
        self._under_way: deque[tuple[int, Payload]] = deque()
        self._shown: Payload | None = None
        self._last_sent_ns: int | None = None
        self._last_asked_ns: int | None = None

    def __len__(self) -> int:
        """Frames held, under way or shown."""
        return len(self._under_way) + (self._shown is not None)

    def send(self, frame: Payload, now_ns: int) -> None:
        """A frame leaves the server."""
        if self._last_sent_ns is not None and now_ns < self._last_sent_ns:
            raise ValueError(f"sent at {now_ns} ns after one sent at {self._last_sent_ns} ns")
        self._last_sent_ns = now_ns
        self._under_way.append((now_ns + self.latency_ns, frame))

    def newest(self, now_ns: int) -> Payload | None:
        """The newest frame that has arrived by now, the same one again until a newer has, None before the first."""
        if self._last_asked_ns is not None and now_ns < self._last_asked_ns:
            raise ValueError(f"asked at {now_ns} ns after {self._last_asked_ns} ns")
        self._last_asked_ns = now_ns
        while self._under_way and self._under_way[0][0] <= now_ns:
            if self._shown is not None:
                self._discard(self._shown)
            self._shown = self._under_way.popleft()[1]
        return self._shown

    def close(self) -> None:
        """Give every frame still held to `discard`."""
        held = [frame for _, frame in self._under_way] + ([self._shown] if self._shown is not None else [])
        self._under_way.clear()
        self._shown = None
        for frame in held:
            self._discard(frame)
