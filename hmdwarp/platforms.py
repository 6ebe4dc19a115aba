"""What differs by platform: POSIX's locks, pipes, terminals, signals, flags and priorities.

Tested on Linux alone. Where these are missing nothing is locked, and what needs a terminal says so
when it is used; nothing fails at import. mypy checks the branches of Windows too.
"""

from __future__ import annotations

import importlib
import math
import os
import select
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from .errors import MachineError


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


def widen_pipe(descriptor: int, count: int) -> None:
    """Let a pipe hold so many bytes. Errors: OSError for more than this user may have."""
    if fcntl is not None and hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(descriptor, fcntl.F_SETPIPE_SZ, count)


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


def has_hung_up(descriptor: int) -> bool:
    """Return whether a terminal has gone; never, where that cannot be known."""
    if sys.platform == "win32":
        return False
    waiting = select.poll()
    waiting.register(descriptor, 0)
    return bool(waiting.poll(0))


def memory_bytes() -> float:
    """Return the memory of the whole machine, infinite where unknown."""
    if hasattr(os, "sysconf"):
        with suppress(ValueError, OSError):
            return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return math.inf


def lower_priority(steps: int, *, batch: bool = False) -> None:
    """Run after others. batch: without preempting them whenever something arrives (Linux)."""
    if hasattr(os, "nice"):
        os.nice(steps)
    if batch and sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Put Ctrl-C off until the block has ended; a process that is started in it hears none."""
    if sys.platform == "win32":
        yield
        return
    heard: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    # Another thread may get the signal for this one.
    handler = signal.signal(signal.SIGINT, lambda number, _: heard.append(number)) if is_main else None
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, handler or signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            signal.raise_signal(signal.SIGINT)


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


def message_socket() -> socket.socket:
    """Return a socket for messages within this machine. Errors: MachineError without POSIX's."""
    if sys.platform == "win32":
        raise MachineError("this system has no Unix sockets for a console: use --console lines")
    return socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def message_sockets() -> tuple[socket.socket, socket.socket]:
    """Return both ends of one. Errors: MachineError without POSIX's."""
    if sys.platform == "win32":
        raise MachineError("this system has no Unix sockets for a console: use --console lines")
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


@contextmanager
def signals_blocked() -> Iterator[None]:
    """Keep SIGINT, SIGTERM and SIGTTOU from programs that are started in this block."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGTTOU})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def unblock(descriptor: int) -> None:
    """Let reads of a pipe return at once."""
    if sys.platform != "win32":
        os.set_blocking(descriptor, False)
