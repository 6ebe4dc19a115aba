"""The clock of the store: which instant it is, for people, and how much time has passed, for sums."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import Protocol


class Clock(Protocol):
    """utc: for people, may be set back. mono_ns: never goes back, and means nothing after the machine started anew."""

    def utc(self) -> datetime:
        """Now, with a time zone."""

    def mono_ns(self) -> int:
        """Nanoseconds from some instant on."""


class MachineClock:
    """The machine's own."""

    def utc(self) -> datetime:
        """As Clock.utc."""
        return datetime.now(UTC)

    def mono_ns(self) -> int:
        """As Clock.mono_ns."""
        return time.monotonic_ns()


def text_of(instant: datetime) -> str:
    """ISO 8601 to the millisecond, always as long: such texts sort as the instants do."""
    return instant.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def seconds_back(before: str, now: str) -> float:
    """By how much `now` lies before `before`; negative where it does not."""
    return (datetime.fromisoformat(before) - datetime.fromisoformat(now)).total_seconds()
