"""What differs by platform: POSIX's locks, terminals, flags and priorities.

Tested on Linux alone; nothing fails at import elsewhere. mypy checks the branches of Windows too.
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

fcntl: Any
termios: Any
try:
    fcntl, termios = map(importlib.import_module, ("fcntl", "termios"))
except ImportError:
    fcntl = termios = None
# For os.open; 0 where a system has no such flag. Windows alone would translate line ends.
CLOEXEC, NOFOLLOW, NONBLOCK = (getattr(os, f"O_{name}", 0) for name in ("CLOEXEC", "NOFOLLOW", "NONBLOCK"))
BINARY = getattr(os, "O_BINARY", 0)


def lock(descriptor: int, *, wait: bool = False) -> None:
    """Lock an open file or folder until it is closed. Errors: OSError where another locked it."""
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)


def open_checked(path: str | os.PathLike[str], check: Callable[[int], None]) -> int:
    """Return a descriptor to read a file from, once check passed one. Errors: OSError; of check."""
    o_path = getattr(os, "O_PATH", 0)  # neither waits for a pipe nor wakes a device
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
    """Run this thread after others; elsewhere than on Linux the whole program."""
    if hasattr(os, "nice"):
        os.nice(steps)


@contextmanager
def priority_kept() -> Iterator[None]:
    """Undo what a library does to the priority of this process's threads meanwhile (Linux).

    SVT-AV1, run by root, makes its threads and the calling one real-time tasks. Threads that begin
    meanwhile get the caller's priority.
    """
    if sys.platform != "linux":
        yield
        return

    def priorities() -> Iterator[tuple[int, tuple[int, int]]]:
        for thread in (int(each.name) for each in Path("/proc/self/task").iterdir()):
            with suppress(ProcessLookupError):  # it has ended since
                yield thread, (os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority)

    before = dict(priorities())
    try:
        yield
    finally:
        for thread, found in priorities():
            if found != (kept := before.get(thread, before[threading.get_native_id()])):
                with suppress(ProcessLookupError):
                    os.sched_setscheduler(thread, kept[0], os.sched_param(kept[1]))


def in_foreground(descriptor: int) -> bool:
    """Return whether a terminal is this program's to read. Errors: OSError for another file."""
    return sys.platform == "win32" or os.tcgetpgrp(descriptor) == os.getpgrp()
