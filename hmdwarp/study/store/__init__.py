"""What happened, on the disk before the next thing happens."""

from .nouns import (
    COMPLETE,
    INTERRUPTED,
    ORIGINS,
    PERSON,
    PILOT,
    RUNNING,
    SICK,
    SIMULATED,
    STATUSES,
    STOPPED,
    Answer,
    Contents,
    Event,
    Session,
    Showing,
)

__all__ = [
    "COMPLETE",
    "INTERRUPTED",
    "ORIGINS",
    "PERSON",
    "PILOT",
    "RUNNING",
    "SICK",
    "SIMULATED",
    "STATUSES",
    "STOPPED",
    "Answer",
    "Contents",
    "Event",
    "Session",
    "Showing",
]
