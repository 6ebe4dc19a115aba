"""Store of a study's data: everything is on the disk before the next thing happens."""

from .clock import Clock
from .folders import DATABASE, store_folder
from .records import (
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
from .signature import plan_signature, signature_changes
from .store import Store

__all__ = [
    "COMPLETE",
    "DATABASE",
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
    "Clock",
    "Contents",
    "Event",
    "Session",
    "Showing",
    "Store",
    "plan_signature",
    "signature_changes",
    "store_folder",
]
