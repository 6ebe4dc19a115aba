"""Takes over what the program prints while a screen has the terminal: Python's prints and those of drivers and runtimes alike."""

from __future__ import annotations

import fcntl
import os
import sys
from collections.abc import Iterator
from contextlib import suppress

PIPE_BYTES = (
    1 << 20
)  # what may be printed while the screen is busy; the kernel's own 64 KiB is little for a talkative runtime


class Capture:
    """From begin() to end(), file descriptors 1 and 2 write into a pipe wherever they wrote to a terminal. read: its end, from which
    reads do not wait. out, err: the terminal, as before."""

    def __init__(self) -> None:
        self.read, self._write = os.pipe()
        os.set_blocking(self.read, False)
        with suppress(OSError):  # more than this user may have
            fcntl.fcntl(self._write, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        self.out, self.err = os.dup(1), os.dup(2)
        self._taken = [fd for fd in (1, 2) if os.isatty(fd)]

    def begin(self) -> None:
        """From now on."""
        _flush()
        for fd in self._taken:
            os.dup2(self._write, fd)

    def end(self) -> None:
        """As it was before. May be called twice."""
        _flush()
        for fd, saved in ((1, self.out), (2, self.err)):
            if fd in self._taken:
                os.dup2(saved, fd)
        self._taken = []
        if self._write >= 0:
            os.close(self._write)
            self._write = -1

    def close(self) -> None:
        """Nobody reads any more; what nobody has read is printed."""
        for piece in pieces(self.read):
            _write(self.err, piece)
        for fd in (self.read, self.out, self.err):
            os.close(fd)


def pieces(fd: int) -> Iterator[bytes]:
    """What lies in the pipe now."""
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
