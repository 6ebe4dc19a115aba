"""What differs by platform: POSIX's file locks, pipes and terminals, which Windows lacks.

Tested on Linux alone. Where these modules are missing nothing is locked, and what needs a terminal
says so when it is used; nothing fails at import.
"""

from __future__ import annotations

import importlib
from typing import Any


def _posix(name: str) -> Any:
    """Return a module of POSIX, None where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


fcntl, termios = _posix("fcntl"), _posix("termios")


def lock(descriptor: int, *, wait: bool = False) -> None:
    """Lock an open file or folder until it is closed. Errors: OSError where another locked it."""
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


def widen_pipe(descriptor: int, count: int) -> None:
    """Let a pipe hold so many bytes. Errors: OSError for more than this user may have."""
    if fcntl is not None and hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(descriptor, fcntl.F_SETPIPE_SZ, count)
