"""What happened, on the disk before the next thing happens."""

from .folders import store_folder
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
from .store import Store

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
    "Store",
    "store_folder",
]
