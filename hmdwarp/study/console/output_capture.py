"""Capture of everything the program prints while the console has the terminal.

Prints of Python and those of drivers and runtimes alike go into a pipe, which the console reads.
"""

from __future__ import annotations

import fcntl
import os
import sys
from collections.abc import Iterator
from contextlib import suppress

# Room for prints while the console is busy; the kernel's 64 KiB are little for a talkative runtime.
PIPE_BYTES = 1 << 20


class OutputCapture:
    """Redirection of file descriptors 1 and 2, where they are terminals, from begin() to end()."""

    def __init__(self) -> None:
        self.read, self._write = os.pipe()  # reads do not wait
        os.set_blocking(self.read, False)
        with suppress(OSError):  # more than this user may have
            fcntl.fcntl(self._write, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        self.out, self.err = os.dup(1), os.dup(2)  # stdout and stderr as they were
        self._taken = [fd for fd in (1, 2) if os.isatty(fd)]

    def begin(self) -> None:
        """Redirect from now on."""
        _flush()
        for fd in self._taken:
            os.dup2(self._write, fd)

    def end(self) -> None:
        """Restore stdout and stderr. May be called twice."""
        _flush()
        for fd, saved in ((1, self.out), (2, self.err)):
            if fd in self._taken:
                os.dup2(saved, fd)
        self._taken = []
        if self._write >= 0:
            os.close(self._write)
            self._write = -1

    def close(self) -> None:
        """Close the pipe; what the console has not read is printed."""
        for piece in pieces(self.read):
            _write(self.err, piece)
        for fd in (self.read, self.out, self.err):
            os.close(fd)


def pieces(fd: int) -> Iterator[bytes]:
    """Yield what lies in the pipe now."""
    while True:
        try:
            piece = os.read(fd, 1 << 16)
        except BlockingIOError:
            return
        if not piece:
            return
        yield piece


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(OSError, ValueError):
                stream.flush()


def _write(fd: int, data: bytes) -> None:
    with suppress(OSError):
        while data:
            data = data[os.write(fd, data) :]
