"""One writer at a time: a lock that the kernel holds, and frees when the program dies.

filelock 4.2 opens, locks and classifies errors in the same way; the holder's name, full disks and
the messages, which are most of this file, it leaves to its caller.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from ...errors import HmdwarpError, InputError, MachineError

NAME = "lock"
_HELD = frozenset({errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES})
_NOT_HERE = frozenset({errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EINVAL})


class Lock:
    """Exclusive lock of a folder. Only the kernel's flock counts; the file names the holder.

    flock and not POSIX locks: closing any handle of the file frees those, and two within one
    program do not exclude each other.
    Errors: MachineError, naming the holder, where another has it, and on a file system without
    locks; InputError where it cannot be written.
    """

    def __init__(self, folder: Path, since: datetime) -> None:
        """Take the lock. since: for the message to others."""
        self.path = folder / NAME
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise _no_place(error, folder) from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._sign(since)
        except BaseException as error:
            words = self._holder()
            os.close(self._file)
            if isinstance(error, OSError):
                raise _refused(error, folder, words) from error
            raise

    def _sign(self, since: datetime) -> None:
        text = json.dumps(
            {
                "pid": os.getpid(),
                "host": socket.gethostname(),
                "since": since.astimezone().isoformat(timespec="seconds"),
            }
        )
        with suppress(OSError):  # a full disk: the lock is held all the same
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, text.encode(), 0)

    def _holder(self) -> str:
        """Return "since 14:03 on 2026-01-31, process 123 on HOST"; "" where it is not known."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            said = json.loads(os.pread(self._file, 4096, 0))
            since = datetime.fromisoformat(said["since"]).strftime("%H:%M on %Y-%m-%d")
            return f"since {since}, process {said['pid']} on {said['host']}"
        return ""

    def close(self) -> None:
        """Free the lock. The file stays: without it two could lock two files of one name."""
        if self._file >= 0:
            with suppress(OSError):
                os.ftruncate(self._file, 0)
            os.close(self._file)
            self._file = -1


def _no_place(error: OSError, folder: Path) -> HmdwarpError:
    why = error.strerror or str(error)
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
        return MachineError(f"{folder}: cannot write ({why}): make room, or choose another folder (--store)")
    return InputError(f"{folder}: cannot write ({why}): choose another folder for the study's data (--store)")


def _refused(error: OSError, folder: Path, holder: str) -> HmdwarpError:
    if error.errno in _HELD:
        who = f" ({holder})" if holder else ""
        return MachineError(f"{folder}: a session of this study is running already{who}: end it first, or wait")
    if error.errno in _NOT_HERE:
        return MachineError(
            f"{folder}: this file system cannot lock files ({error.strerror}), as some network drives; "
            "two sessions at once would not exclude each other: keep the study on a disk of this machine (--store)"
        )
    return _no_place(error, folder)
