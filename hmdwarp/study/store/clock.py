"""Clock of the store: the time of day, and a monotonic clock for durations."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import Protocol


class Clock(Protocol):
    """Time of day, which may be set back, and time since boot, which never is."""

    def utc(self) -> datetime:
        """Return the time of day, with a time zone."""

    def mono_ns(self) -> int:
        """Return nanoseconds since some instant."""


class MachineClock:
    """The machine's own clock."""

    def utc(self) -> datetime:
        """Return the time of day, in UTC."""
        return datetime.now(UTC)

    def mono_ns(self) -> int:
        """Return nanoseconds of the monotonic clock."""
        return time.monotonic_ns()


def text_of(instant: datetime) -> str:
    """Format as ISO 8601 to the millisecond, of fixed length: texts sort as instants do."""
    return instant.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def seconds_since(before: str) -> float:
    """Return the time from an instant to now, by the time of day."""
    return -seconds_back(before, text_of(datetime.now(UTC)))


def seconds_back(before: str, now: str) -> float:
    """Return by how much `now` lies before `before`; negative where it does not."""
    return (datetime.fromisoformat(before) - datetime.fromisoformat(now)).total_seconds()
