"""What differs by platform: POSIX's locks, terminals, flags and priorities.

Tested on Linux alone. Where these are missing nothing is locked, and what needs a terminal says so
when it is used; nothing fails at import. mypy checks the branches of Windows too.
"""

from __future__ import annotations

import importlib
import math
import os
import select
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any


def _posix(name: str) -> Any:
    """Return a module of POSIX, None where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


fcntl, termios = _posix("fcntl"), _posix("termios")
# For os.open; 0 where a system has no such flag. Windows alone would translate line ends.
CLOEXEC, NOFOLLOW, NONBLOCK = (getattr(os, f"O_{name}", 0) for name in ("CLOEXEC", "NOFOLLOW", "NONBLOCK"))
BINARY = getattr(os, "O_BINARY", 0)


def lock(descriptor: int, *, wait: bool = False) -> None:
    """Lock an open file or folder until it is closed. Errors: OSError where another locked it."""
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


def open_checked(path: str | os.PathLike[str], check: Callable[[int], None]) -> int:
    """Return a descriptor to read a file from, once check has passed one of it.

    Linux opens by O_PATH first, which neither waits for a pipe nor wakes a device.
    Errors: OSError; those of check.
    """
    o_path = getattr(os, "O_PATH", 0)
    found = os.open(path, (o_path or os.O_RDONLY | NONBLOCK | BINARY) | CLOEXEC)
    try:
        check(found)
        return os.open(f"/proc/self/fd/{found}", os.O_RDONLY | NONBLOCK | CLOEXEC) if o_path else os.dup(found)
    finally:
        os.close(found)


def takes_more(descriptor: int) -> bool:
    """Return whether the system has room for bytes to a socket."""
    if sys.platform == "win32":
        return bool(select.select([], [descriptor], [], 0)[1])
    waiting = select.poll()  # select counts to 1024 descriptors
    waiting.register(descriptor, select.POLLOUT)
    return bool(waiting.poll(0))


def memory_bytes() -> float:
    """Return the memory of the whole machine, infinite where unknown."""
    if hasattr(os, "sysconf"):
        with suppress(ValueError, OSError):
            return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return math.inf


def lower_priority(steps: int) -> None:
    """Run after others."""
    if hasattr(os, "nice"):
        os.nice(steps)


@contextmanager
def priority_kept() -> Iterator[None]:
    """Undo what a library does to the priority of this process's threads meanwhile (Linux).

    SVT-AV1, run by root, makes its threads and the calling one real-time tasks, ahead of all else
    on the machine. Threads that begin meanwhile get the caller's priority.
    """
    before = _priorities()
    try:
        yield
    finally:
        if sys.platform == "linux":
            usual = before[threading.get_native_id()]
            for thread, found in _priorities().items():
                policy, priority = before.get(thread, usual)
                if found != (policy, priority):
                    with suppress(ProcessLookupError):  # it has ended since
                        os.sched_setscheduler(thread, policy, os.sched_param(priority))


def _priorities() -> dict[int, tuple[int, int]]:
    """Return (policy, priority) of each thread of this process; none where they are not listed."""
    found: dict[int, tuple[int, int]] = {}
    if sys.platform == "linux":
        for thread in (int(each.name) for each in Path("/proc/self/task").iterdir()):
            with suppress(ProcessLookupError):
                found[thread] = os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority
    return found


def in_foreground(descriptor: int) -> bool:
    """Return whether a terminal is this program's to read. Errors: OSError for another file."""
    return sys.platform == "win32" or os.tcgetpgrp(descriptor) == os.getpgrp()
